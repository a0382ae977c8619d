"""How far a picture is from its reference, over the pixels that show an object.

[Huang07, eqs. (3), (4)]: the mean relative error, MRE = mean |I - R| / R. Taken on Rec.709
luminance, over object pixels whose reference is brighter than .1 % of the mean: in a darker one a
relative error means nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

REC709 = np.array([0.2126, 0.7152, 0.0722])
DARK = 1e-3


class Errors(NamedTuple):
    """mre: mean relative error; p99: its 99th percentile; bias: signed, of the sums;
    relmse: mean squared error of RGB over (reference^2 + .01 mean^2)."""

    mre: float
    relmse: float
    bias: float
    p99: float


def luminance(rgb) -> np.ndarray:
    """float64 (...) of (..., 3)."""
    return np.asarray(rgb, np.float64)[..., :3] @ REC709


def measured_pixels(reference, object_mask) -> np.ndarray:
    """bool (h, w): object pixels that are not black in the reference (h, w, 3)."""
    light = luminance(reference)
    return object_mask & (light > DARK * light[object_mask].mean())


def relative_difference(picture, reference, mask) -> np.ndarray:
    """Signed, on luminance, float64 (h, w); 0 outside the mask."""
    light, wanted = luminance(picture), luminance(reference)
    return np.where(mask, light - wanted, 0.0) / np.where(mask, wanted, 1.0)


def errors(picture, reference, object_mask) -> Errors:
    """All of Errors for a picture (h, w, 3) over the pixels of object_mask, bool (h, w)."""
    mask = measured_pixels(reference, object_mask)
    relative = np.abs(relative_difference(picture, reference, mask)[mask])
    wanted = np.asarray(reference, np.float64)[mask]
    found = np.asarray(picture, np.float64)[mask]
    floor = 0.01 * luminance(wanted).mean() ** 2
    return Errors(
        mre=float(relative.mean()),
        relmse=float(((found - wanted) ** 2 / (wanted**2 + floor)).mean()),
        bias=float(luminance(found).sum() / luminance(wanted).sum() - 1.0),
        p99=float(np.quantile(relative, 0.99)),
    )


def without_noise(error: float, noise: float) -> float:
    """A mean error less that of its reference: independent errors add in squares."""
    return float(np.sqrt(max(error**2 - noise**2, 0.0)))


def cost_at(error: float, costs, found) -> float | None:
    """The cost at which an error is reached, by straight lines in log-log; None if it is not.

    costs, found: cost and error of each run
    """
    order = np.argsort(costs)
    log_cost, log_error = np.log(np.asarray(costs)[order]), np.log(np.asarray(found)[order])
    log_error = np.minimum.accumulate(log_error)  # more work that brings nothing is no progress
    target = np.log(error)
    if not log_error[-1] <= target <= log_error[0]:
        return None
    first = int(np.argmax(log_error <= target))
    if first == 0:
        return float(np.exp(log_cost[0]))
    x, y = log_error[first - 1 : first + 1], log_cost[first - 1 : first + 1]
    return float(np.exp(y[0] + (target - x[0]) / (x[1] - x[0]) * (y[1] - y[0])))


def cost_beyond(error: float, costs, found, most: float = 4.0) -> float | None:
    """The cost at which an error would be reached if the last step's slope went on.

    None where that is more than ``most`` times the last cost, or the error does not fall.
    """
    order = np.argsort(costs)
    log_cost, log_error = np.log(np.asarray(costs)[order]), np.log(np.asarray(found)[order])
    if len(order) < 2 or log_error[-1] >= log_error[-2]:
        return None
    slope = (log_cost[-1] - log_cost[-2]) / (log_error[-1] - log_error[-2])
    factor = np.exp((np.log(error) - log_error[-1]) * slope)
    return float(np.exp(log_cost[-1]) * factor) if factor <= most else None


def error_at(cost: float, costs, found) -> float | None:
    """The error at a cost, by straight lines in log-log; None outside the curve."""
    order = np.argsort(costs)
    log_cost, log_error = np.log(np.asarray(costs)[order]), np.log(np.asarray(found)[order])
    if not log_cost[0] <= np.log(cost) <= log_cost[-1]:
        return None
    return float(np.exp(np.interp(np.log(cost), log_cost, log_error)))

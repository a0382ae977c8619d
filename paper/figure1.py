"""Figure 1: where the picture is wrong, beside e_d and sigma_d, which know nothing of a reference.

Both come from K and N of a pixel: e_d = sqrt((1 - v) / (v N)) and sigma_d = I_s sqrt(v (1 - v) / N)
with v = K / N [Huang07, eq. 5 to 7].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .metrics import error_map, light_of, rank_correlation
from .runs import Picture, Run


class Figure1(NamedTuple):
    """e_i, e_d, sigma_d: float64 (h, w), 0 outside ``mask``: pixels where samples were seen
    by_e_d, by_sigma_d: rank correlation with e_i over the mask, and over its partly occluded pixels
    partly: share of the mask that is partly occluded
    """

    e_i: np.ndarray
    e_d: np.ndarray
    sigma_d: np.ndarray
    mask: np.ndarray
    by_e_d: tuple[float, float]
    by_sigma_d: tuple[float, float]
    partly: float


def error_maps(visibility, unoccluded, samples) -> tuple[np.ndarray, np.ndarray]:
    """(e_d, sigma_d) of v, I_s (luminance) and N, float64 of one shape; v > 0."""
    spread = np.sqrt(np.maximum(visibility * (1.0 - visibility), 0.0) / samples)
    return spread / visibility, unoccluded * spread


def figure1(run: Run, truth: np.ndarray, lit: np.ndarray, count: int) -> Figure1:
    """truth: float64 (h, w, 3); lit: bool (h, w), where a relative error means something."""
    picture: Picture = run.picture(stop_rule="FIXED", max_samples=count)
    mask = lit & (picture.visibility > 0.0)
    seen = np.where(mask, picture.visibility, 1.0)
    e_d, sigma_d = error_maps(seen, light_of(picture.unoccluded), np.maximum(picture.samples, 1.0))
    e_d, sigma_d = np.where(mask, e_d, 0.0), np.where(mask, sigma_d, 0.0)
    e_i = error_map(picture.rgb, truth, mask)
    partly = mask & (picture.visibility < 1.0)

    def both(values):
        return tuple(rank_correlation(values[m], e_i[m]) for m in (mask, partly))

    share = float(partly.sum() / max(mask.sum(), 1))
    return Figure1(e_i, e_d, sigma_d, mask, both(e_d), both(sigma_d), share)

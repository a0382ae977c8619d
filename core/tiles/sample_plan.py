"""How a budget of samples is shared out over the pixels of a frame, after a first look at them.

As the rule PERCEPTUAL has it (stop_rule.py), a pixel is to have N = T r^.75 samples; T is what
spends the budget. All pixels are decided on at once. Rounding up would give pixels of the same r
all the same count, and a budget between two counts could not be met: N is rounded up or down by a
threshold that differs from pixel to pixel (ordered dither), so that the mean is a steady function
of T. All sums are of whole numbers: T does not depend on the order of the pixels, nor do pictures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..sampling.stop_rule import EXPONENT, FIRST_COUNT

WHOLE_SHARE = 4096  # of Demand.share
_COARSE = 4  # counts from FIRST_COUNT on are multiples of it: Sobol's points are better spread
# A shift of one pixel moves the threshold by these parts: Roberts' plastic sequence, in two
# dimensions. Neighbours differ, and any few of them together cover 0 ... 1 evenly.
_DITHER_X, _DITHER_Y = 0.7548776662466927, 0.5698402909980532
_LOW, _HIGH = 1e-9, 1e12
_CLOSE, _STEPS = 1e-4, 100  # relative, of the budget


class Demand(NamedTuple):
    """What the pixels of a tile ask for.

    power: float32 (n,), r^.75
    least: float32 (n,), of sqrt(T): what a pixel takes at the least (silhouettes), else 0
    taken: int32 (n,), samples so far
    share: int32 (n,), shadow rays in a sample, in 1 / WHOLE_SHARE; 0: none that count
    dither: float32 (n,), in [0, 1)
    grain: counts are multiples of it, the samples of a shading point; 0: one point has them all
    shaded: pixels that show an object
    """

    power: np.ndarray
    least: np.ndarray
    taken: np.ndarray
    share: np.ndarray
    dither: np.ndarray
    grain: int
    shaded: int


def dither_of(columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Demand.dither of pixels of the frame."""
    place = columns * _DITHER_X + rows * _DITHER_Y
    place -= np.floor(place)  # % 1.0 takes three times as long
    return place.astype(np.float32)


def powers(spread: np.ndarray) -> np.ndarray:
    """Demand.power of r, float32."""
    return spread ** np.float32(EXPONENT)


@kernel(forceinline=True)
def _count(demand, p, grain, typical, most):
    exact = max(typical * demand.power[p], np.sqrt(typical) * demand.least[p])
    if exact >= most:
        return max(most, np.int64(demand.taken[p]))
    step = grain
    if grain == 0:
        step = _COARSE if exact >= FIRST_COUNT else 1
    count = step * np.int64(np.floor(exact / step + demand.dither[p]))
    return max(min(count, most), np.int64(demand.taken[p]))


@kernel
def _fill_counts(demand, grain, typical, most, counts):
    for p in range(len(counts)):
        counts[p] = _count(demand, p, grain, typical, most)


@kernel
def _total(demand, grain, typical, most):
    total = np.int64(0)
    for p in range(len(demand.power)):
        if demand.share[p] > 0:
            total += _count(demand, p, grain, typical, most) * demand.share[p]
    return total


def planned_counts(demand: Demand, typical: float, most: int) -> np.ndarray:
    """T r^.75 of each pixel, int32 (n,): from what it has to ``most``, which is max_samples."""
    counts = np.empty(len(demand.power), np.int32)
    _fill_counts(_columns(demand), demand.grain, float(typical), most, counts)
    return counts


def typical_for_rays(demands: list[Demand], rays: float, most: int) -> float:
    """T whose plans take ``rays`` shadow rays in all, those taken so far counted.

    The least there is where they are more already, the greatest where max_samples stops all.
    """
    if not demands:
        return _LOW
    joined = [_columns(demand) for demand in demands if len(demand.power)]
    grain, wanted = demands[0].grain, rays * WHOLE_SHARE

    def total(typical):
        return float(sum(_total(columns, grain, typical, most) for columns in joined))

    low, high = _LOW, _HIGH
    if total(high) <= wanted:
        return high
    typical = 1.0
    for step in range(_STEPS):
        taken = total(typical)
        if abs(taken - wanted) <= _CLOSE * wanted:
            break
        low, high = (typical, high) if taken < wanted else (low, typical)
        # In proportion where that is between the two, every other time: it finds T in a few steps
        # where all pixels go on, and creeps where most have enough.
        guess = typical * wanted / taken if taken > 0.0 and step % 2 == 0 else 0.0
        typical = guess if low < guess < high else float(np.sqrt(low * high))
    return typical


class _Columns(NamedTuple):
    """The arrays of a Demand, for kernels."""

    power: np.ndarray
    least: np.ndarray
    taken: np.ndarray
    share: np.ndarray
    dither: np.ndarray


def _columns(demand: Demand) -> _Columns:
    return _Columns(*demand[:5])

"""When a pixel has enough samples: each rule says, after a round, how many every point wants.

FIXED: as many as allowed. PAPER: more while e_d > E [Huang07, algorithm 1].

PERCEPTUAL spends them where they lower the mean relative error most. With r the relative standard
deviation of a sample (neighbours.py), sum r / sqrt(N) is least for a given sum of N at
N ~ r^(2/3). With the convergence of Sobol's points, and an eye on the largest errors,

    N = T r^.75,  T = .45 / E^2

N is decided anew when the samples have doubled. The floor for the dark is .2 / T: what T samples
would hardly see. docs/decisions/0011-perceptual-rule.md has the figures.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ._jit import kernel
from .neighbours import Neighbours, relative_spread
from .settings import RenderSettings

# Squared error of Sobol's or Halton's points over that of independent samples, at E = .1.
_CONVERGENCE = 0.45
_EXPONENT, _FLOOR = 0.75, 0.2
FIRST_COUNT = 8


def typical_count(error_threshold: float) -> float:
    """T of a threshold above 0: what a pixel with half of its light hidden (r = 1) wants."""
    return _CONVERGENCE / (error_threshold * error_threshold)


@kernel(forceinline=True)
def next_count(taken):
    """The count after ``taken`` at which a point may end: 8, 12, 16, 24, 32, 48, 64, 96, 128 ...

    Powers of two and what is between two of them: Sobol's points are best spread there, and many
    points that end together leave long batches for Embree.
    """
    power = FIRST_COUNT
    while 2 * power <= taken:
        power *= 2
    if taken < power:
        return power
    between = power + power // 2
    return between if taken < between else 2 * power


@kernel(forceinline=True)
def _end_at(wanted, least, most):
    """The first count to end at that is no less than wanted, between two bounds."""
    if wanted <= least:
        return least
    if wanted >= most:
        return most
    return min(next_count(np.int64(np.ceil(wanted)) - 1), most)


@kernel
def _plan(spread, taken, typical, most, planned):
    for p in range(len(planned)):
        exact = typical * np.float64(spread[p]) ** _EXPONENT
        planned[p] = _end_at(exact, np.int64(taken[p]), most)


def plan_counts(spread: np.ndarray, taken: np.ndarray, typical: float, most: int) -> np.ndarray:
    """T r^.75, rounded up to where a point may end, int32 (n,): from ``taken`` to ``most``.

    spread: float32 (n,), r; taken: int32 (n,), samples so far; typical: T
    """
    planned = np.empty(len(spread), np.int32)
    _plan(spread, taken, typical, most, planned)
    return planned


@kernel
def _total_planned(powers, typical, least, most):
    total = 0
    for p in range(len(powers)):
        total += _end_at(typical * powers[p], np.int64(least[p]), most)
    return total


def typical_for_mean(spread: np.ndarray, taken: np.ndarray, target: float, most: int) -> float:
    """T whose planned counts have the mean ``target``; the nearest there is below, or the least.

    spread: float32 (n,), r of all shaded pixels of a frame after a pilot; taken: int32 (n,), their
    samples so far; most: max_samples
    """
    powers = spread.astype(np.float64) ** _EXPONENT
    low, high = 1e-6, 1e12
    if _total_planned(powers, high, taken, most) <= target * len(spread):
        return high
    for _ in range(60):
        middle = float(np.sqrt(low * high))
        if _total_planned(powers, middle, taken, most) <= target * len(spread):
            low = middle
        else:
            high = middle
    return low


def mean_in_time(mean: float, seconds: float, seconds_left: float) -> float:
    """The mean count that ``seconds_left`` more allow, when ``mean`` has taken ``seconds``."""
    return mean * (1.0 + max(seconds_left, 0.0) / seconds)


@kernel
def relative_error(count, seen, seen_squared):
    """e_d of a pixel from its sums, float64; infinite while nothing was seen [Huang07, eq. 7].

    e_d^2 = sum (f_i - mean f)^2 / (sum f_i)^2, f_i the luminance of sample i if seen, else 0: for
    samples of equal weight it is equation 7.
    """
    if seen <= 0.0:
        return np.inf
    return np.sqrt(max(seen_squared - seen * seen / count, 0.0)) / seen


@kernel
def _want_more(active, threshold, most, sums, wanted):
    for p in active:
        error = relative_error(sums.count[p], sums.seen[p], sums.seen_squared[p])
        sums.error[p] = error
        wanted[p] = most if error > threshold else sums.count[p]


class StopRule(Protocol):
    """What sample_points asks between the rounds of a block of points.

    wanted: int32 (n,), how many samples each point is to have; written
    """

    def begin(self, sums, wanted: np.ndarray) -> None:
        """Set ``wanted`` for points that have the samples in ``sums``, or none."""

    def round_end(self, taken: int) -> int:
        """Where the round that begins at ``taken`` samples ends: decide() is asked there."""

    def decide(self, active: np.ndarray, taken: int, sums, wanted: np.ndarray) -> None:
        """Set ``wanted`` of the active points, int32, which have ``taken`` samples now."""

    def finish(self, sums) -> None:
        """Write the error of every point that was sampled."""


class PaperRule:
    """PAPER: until e_d <= threshold; with -1, FIXED."""

    def __init__(self, threshold: float, batch_size: int, most: int):
        self._threshold, self._batch_size, self._most = threshold, batch_size, most

    def begin(self, sums, wanted: np.ndarray) -> None:
        """See StopRule."""
        wanted[:] = np.where(sums.error > self._threshold, self._most, sums.count)

    def round_end(self, taken: int) -> int:
        """See StopRule."""
        return min(taken + self._batch_size, self._most)

    def decide(self, active: np.ndarray, taken: int, sums, wanted: np.ndarray) -> None:
        """See StopRule."""
        _want_more(active, self._threshold, self._most, sums, wanted)

    def finish(self, sums) -> None:
        """See StopRule: decide() has written them."""


class PerceptualRule:
    """PERCEPTUAL: N = typical r^.75, decided anew when the samples have doubled.

    plan: int32 (n,), counts to take in place of that, without decisions: for a budget
    """

    def __init__(
        self, typical: float, most: int, neighbours: Neighbours, plan: np.ndarray | None = None
    ):
        self._typical, self._most, self._neighbours = typical, most, neighbours
        self._plan = plan

    def begin(self, sums, wanted: np.ndarray) -> None:
        """See StopRule."""
        wanted[:] = min(FIRST_COUNT, self._most)
        if self._plan is not None:
            wanted[:] = np.minimum(self._plan, self._most)
        elif sums.count.any():
            self._set(np.flatnonzero(sums.count).astype(np.int32), sums, wanted)

    def round_end(self, taken: int) -> int:
        """See StopRule: the next power of two."""
        if self._plan is not None:
            return self._most
        return min(max(1 << int(taken).bit_length(), FIRST_COUNT), self._most)

    def decide(self, active: np.ndarray, taken: int, sums, wanted: np.ndarray) -> None:
        """See StopRule."""
        if self._plan is None and len(active):
            self._set(active, sums, wanted)

    def finish(self, sums) -> None:
        """See StopRule: sqrt(.45 / N) r, which is E where r is 1 and N as wanted."""
        sampled = np.flatnonzero(sums.count).astype(np.int32)
        scale = np.sqrt(_CONVERGENCE / sums.count[sampled])
        sums.error[sampled] = scale * self.spread(sampled, sums)

    def spread(self, points: np.ndarray, sums) -> np.ndarray:
        """r of some points, float32; points: int32."""
        return relative_spread(sums, self._neighbours, _FLOOR / self._typical, points)

    def _set(self, points, sums, wanted):
        spread = self.spread(points, sums)
        wanted[points] = plan_counts(spread, sums.count[points], self._typical, self._most)


def stop_rule(settings: RenderSettings, neighbours: Neighbours) -> StopRule:
    """The rule that the settings name."""
    threshold, most = settings.error_threshold, settings.max_samples
    # e_d is 0 where all samples were seen: E = 0 must not stop there.
    if settings.stop_rule == "FIXED" or threshold == 0.0:
        return PaperRule(-1.0, most, most)
    if settings.stop_rule == "PAPER":
        return PaperRule(threshold, settings.batch_size, most)
    return PerceptualRule(typical_count(threshold), most, neighbours)

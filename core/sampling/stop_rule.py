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

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..settings import RenderSettings
from .neighbours import pool_spread

# Squared error of Sobol's or Halton's points over that of independent samples, at E = .1.
_CONVERGENCE = 0.45
EXPONENT, FLOOR = 0.75, 0.2
FIRST_COUNT = 8


def typical_count(error_threshold: float) -> float:
    """T of a threshold above 0: what a pixel with half of its light hidden (r = 1) wants."""
    return _CONVERGENCE / (error_threshold * error_threshold)


def threshold_of(typical: float) -> float:
    """E of a T: the inverse of typical_count."""
    return math.sqrt(_CONVERGENCE / typical)


def spread_of(sums) -> np.ndarray:
    """r, float32 (n,), that finish_rule has written as the error of points; 0 without samples."""
    count = np.maximum(sums.count, 1)
    return np.where(sums.count > 0, sums.error * np.sqrt(count / _CONVERGENCE), 0.0).astype(
        np.float32
    )


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
        exact = typical * np.float64(spread[p]) ** EXPONENT
        planned[p] = _end_at(exact, np.int64(taken[p]), most)


def plan_counts(spread: np.ndarray, taken: np.ndarray, typical: float, most: int) -> np.ndarray:
    """T r^.75, rounded up to where a point may end, int32 (n,): from ``taken`` to ``most``.

    spread: float32 (n,), r; taken: int32 (n,), samples so far; typical: T
    """
    planned = np.empty(len(spread), np.int32)
    _plan(spread, taken, typical, most, planned)
    return planned


@kernel
def relative_error(count, seen, seen_squared):
    """e_d of a pixel from its sums, float64; infinite while nothing was seen [Huang07, eq. 7].

    e_d^2 = sum (f_i - mean f)^2 / (sum f_i)^2, f_i the luminance of sample i if seen, else 0: for
    samples of equal weight it is equation 7.
    """
    if seen <= 0.0:
        return np.inf
    return np.sqrt(max(seen_squared - seen * seen / count, 0.0)) / seen


class Rule(NamedTuple):
    """A stop rule as kernels take it.

    kind: PAPER_RULE, PERCEPTUAL_RULE, PLAN or PASS_RULE
    threshold: PAPER_RULE: E; -1 = never done before ``most`` (FIXED); batch: points a round
    typical: PERCEPTUAL_RULE: T; most: samples of a point at the most
    plan: int32, PLAN, PASS_RULE: how many each point gets; else empty
    """

    kind: int
    threshold: float
    batch: int
    typical: float
    most: int
    plan: np.ndarray


PAPER_RULE, PERCEPTUAL_RULE, PLAN, PASS_RULE = 0, 1, 2, 3
_NO_PLAN = np.zeros(0, np.int32)


class RuleRoom(NamedTuple):
    """Scratch of the rules for a block of n points.

    totals: float64 (n, 4); scatter: float64 (n,); spread: float32 (n,), r; points: int32 (n,)
    """

    totals: np.ndarray
    scatter: np.ndarray
    spread: np.ndarray
    points: np.ndarray


def new_rule_room(n: int) -> RuleRoom:
    """Scratch for blocks of up to n points."""
    return RuleRoom(np.empty((n, 4)), np.empty(n), np.empty(n, np.float32), np.empty(n, np.int32))


@kernel(forceinline=True)
def asks_neighbours(rule):
    """Whether the rule is told which points tell of each other."""
    return rule.kind == PERCEPTUAL_RULE or rule.kind == PLAN


@kernel
def _plan_points(rule, neighbours, sums, room, n, wanted):
    """Set ``wanted`` of the n points in room.points by their spread."""
    points, spread = room.points, room.spread
    floor = FLOOR / rule.typical
    pool_spread(points, n, sums, neighbours, floor, room.totals, room.scatter, spread)
    for i in range(n):
        exact = rule.typical * np.float64(spread[i]) ** EXPONENT
        wanted[points[i]] = _end_at(exact, np.int64(sums.count[points[i]]), rule.most)


@kernel
def begin_rule(rule, neighbours, sums, room, wanted):
    """Write how many samples each point is to have; they have those in ``sums``, or none."""
    n = 0
    for p in range(len(wanted)):
        if rule.kind == PLAN or rule.kind == PASS_RULE:
            wanted[p] = min(rule.plan[p], rule.most)
        elif rule.kind == PAPER_RULE:
            wanted[p] = rule.most if sums.error[p] > rule.threshold else sums.count[p]
        else:
            wanted[p] = min(FIRST_COUNT, rule.most)
            if sums.count[p] > 0:
                room.points[n] = p
                n += 1
    if n > 0:
        _plan_points(rule, neighbours, sums, room, n, wanted)


@kernel(forceinline=True)
def end_of_round(rule, taken):
    """Where the round that begins at ``taken`` samples ends: decide_rule is asked there."""
    if rule.kind == PLAN:
        return rule.most
    if rule.kind == PAPER_RULE or rule.kind == PASS_RULE:
        return min(taken + rule.batch, rule.most)
    power = FIRST_COUNT
    while power <= taken:
        power *= 2
    return min(power, rule.most)


@kernel
def decide_rule(rule, neighbours, active, n, taken, sums, room, wanted):
    """Set ``wanted`` of those of the n active points, int32, that have ``taken`` samples now."""
    if rule.kind == PLAN or rule.kind == PASS_RULE:
        return
    m = 0
    for a in range(n):
        p = active[a]
        if sums.count[p] != taken:
            continue
        room.points[m] = p
        m += 1
        if rule.kind == PAPER_RULE:
            error = relative_error(sums.count[p], sums.seen[p], sums.seen_squared[p])
            sums.error[p] = error
            wanted[p] = rule.most if error > rule.threshold else sums.count[p]
    if rule.kind == PERCEPTUAL_RULE and m > 0:
        _plan_points(rule, neighbours, sums, room, m, wanted)


@kernel
def finish_rule(rule, neighbours, sums, room):
    """Write the error of every point that was sampled.

    PERCEPTUAL, or a plan: sqrt(.45 / N) r, which is E where r is 1 and N as wanted.
    """
    if not asks_neighbours(rule):
        return  # decide_rule has written them, or nobody asks
    n = 0
    for p in range(len(sums.count)):
        if sums.count[p] > 0:
            room.points[n] = p
            n += 1
    floor, spread = FLOOR / rule.typical, room.spread
    pool_spread(room.points, n, sums, neighbours, floor, room.totals, room.scatter, spread)
    for i in range(n):
        p = room.points[i]
        sums.error[p] = np.sqrt(_CONVERGENCE / np.float64(sums.count[p])) * np.float64(spread[i])


def paper_rule(threshold: float, batch_size: int, most: int) -> Rule:
    """PAPER: until e_d <= threshold; with -1, FIXED."""
    return Rule(PAPER_RULE, float(threshold), int(batch_size), 1.0, int(most), _NO_PLAN)


def perceptual_rule(typical: float, most: int, plan: np.ndarray | None = None) -> Rule:
    """PERCEPTUAL: N = typical r^.75, decided anew when the samples have doubled.

    plan: int32 (n,), counts to take in place of that, without decisions: for a budget
    """
    kind = PERCEPTUAL_RULE if plan is None else PLAN
    plan = _NO_PLAN if plan is None else np.ascontiguousarray(plan, np.int32)
    return Rule(kind, 0.0, 1, float(typical), int(most), plan)


def pass_rule(batch_size: int, plan: np.ndarray) -> Rule:
    """What points of several passes have to take: ``plan``, int32 (n,), in rounds of batch_size.

    Without errors: those of the pixels are pass_sums.py's.
    """
    return Rule(PASS_RULE, 0.0, int(batch_size), 1.0, int(plan.max(initial=0)), plan)


def stop_rule(settings: RenderSettings) -> Rule:
    """The rule that the settings name; BUDGET, where nobody plans it, is PERCEPTUAL."""
    threshold, most = settings.error_threshold, settings.max_samples
    # e_d is 0 where all samples were seen: E = 0 must not stop there.
    if settings.stop_rule == "FIXED" or threshold == 0.0:
        return paper_rule(-1.0, most, most)
    if settings.stop_rule == "PAPER":
        return paper_rule(threshold, settings.batch_size, most)
    return perceptual_rule(typical_count(threshold), most)

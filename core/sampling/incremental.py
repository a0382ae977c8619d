"""The paper's loop: rounds of n points for each pixel not converged yet [Huang07, algorithm 1].

Embree answers many rays at once, so a round goes over all active pixels of a block: warp their next
n Halton points, trace one batch of shadow rays, add what was seen, ask the stop rule
(stop_rule.py) which pixels go on. Samples taken once are never taken again.

A sampler (unbiased, paper, reference) fills the rays and what each carries.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from .._jit import kernel
from ..bsdf.luminance import chroma, luminance
from ..embree.accel import Accel
from ..settings import RenderSettings
from .neighbours import Neighbours, no_neighbours
from .stop_rule import (
    Rule,
    begin_rule,
    decide_rule,
    end_of_round,
    finish_rule,
    new_rule_room,
    stop_rule,
)

# Shadow rays that are made, traced and added up together: 400 kB, which stay in a core's cache.
_BATCH_RAYS = 8192


class RayBatch(NamedTuple):
    """Shadow rays of one round and the light each would bring, float32 but point.

    origins, directions: (capacity, 3), world space
    point: int32 (capacity,), row of the tile's shading points
    diffuse, glossy: (capacity, 3), L B cos / pdf of the sample, by lobe
    """

    origins: np.ndarray
    directions: np.ndarray
    point: np.ndarray
    diffuse: np.ndarray
    glossy: np.ndarray


class PixelSums(NamedTuple):
    """What is known of each shading point so far.

    count, visible: int32 (n,), N and K
    diffuse, glossy: float64 (n, 3), sums of the light that was seen
    unoccluded: float64 (n, 3), sum of all light, seen or not
    seen, seen_squared: float64 (n,), sums of f_i and f_i^2
    hue: float64 (n,), sum of luminance.chroma of the light that was seen
    error: float32 (n,), e_d, or what the stop rule puts in its place
    """

    count: np.ndarray
    visible: np.ndarray
    diffuse: np.ndarray
    glossy: np.ndarray
    unoccluded: np.ndarray
    seen: np.ndarray
    seen_squared: np.ndarray
    hue: np.ndarray
    error: np.ndarray


class Sampler(Protocol):
    """Where the samples of a tile's points go. One object a tile."""

    def lit(self) -> np.ndarray:
        """bool (n,): the points that any light can reach; the others get no sample."""

    def unoccluded(self) -> np.ndarray | None:
        """I_s, float32 (n, 3), where it is known; None: the mean of the samples stands for it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """Fill rays with samples first ... first + counts[a] - 1 of each active[a], both int32.

        Samples that can carry no light may be left out. Returns how many rays were written.
        """


def new_sums(n: int) -> PixelSums:
    """Zero sums for n shading points."""
    return PixelSums(
        np.zeros(n, np.int32),
        np.zeros(n, np.int32),
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        *(np.zeros(n) for _ in range(3)),
        np.full(n, np.inf, np.float32),
    )


def new_rays(capacity: int) -> RayBatch:
    """Room for a round's shadow rays."""
    return RayBatch(
        np.empty((capacity, 3), np.float32),
        np.empty((capacity, 3), np.float32),
        np.empty(capacity, np.int32),
        np.empty((capacity, 3), np.float32),
        np.empty((capacity, 3), np.float32),
    )


@kernel
def _add_rays(rays, n_rays, occluded, sums):
    for k in range(n_rays):
        p = rays.point[k]
        seen = not occluded[k]
        if seen:
            sums.visible[p] += 1
            red = rays.diffuse[k, 0] + rays.glossy[k, 0]
            green = rays.diffuse[k, 1] + rays.glossy[k, 1]
            blue = rays.diffuse[k, 2] + rays.glossy[k, 2]
            light = np.float64(luminance(red, green, blue))
            sums.seen[p] += light
            sums.seen_squared[p] += light * light
            sums.hue[p] += np.float64(chroma(red, green, blue))
        for a in range(3):
            diffuse, glossy = np.float64(rays.diffuse[k, a]), np.float64(rays.glossy[k, a])
            sums.unoccluded[p, a] += diffuse + glossy
            if seen:
                sums.diffuse[p, a] += diffuse
                sums.glossy[p, a] += glossy


@kernel
def select_points(wanted, taken, sums, active):
    """Write the points that have ``taken`` samples and want more; returns how many."""
    n = 0
    for p in range(len(wanted)):
        if sums.count[p] == taken and wanted[p] > taken:
            active[n] = p
            n += 1
    return n


@kernel
def least_count(wanted, sums):
    """The fewest samples of a point that wants more; -1: none does."""
    least = -1
    for p in range(len(wanted)):
        if wanted[p] > sums.count[p] and (least < 0 or sums.count[p] < least):
            least = sums.count[p]
    return least


@kernel
def _batch_end(counts, first):
    """The end of the points from ``first`` on whose samples are one batch: one point at least."""
    last, total = first + 1, counts[first]
    while last < len(counts) and total + counts[last] <= _BATCH_RAYS:
        total += counts[last]
        last += 1
    return last


def continue_points(
    sampler: Sampler,
    sums: PixelSums,
    accel: Accel,
    rule: Rule,
    cancelled=lambda: False,
    neighbours: Neighbours | None = None,
) -> int:
    """Add samples to points until each has as many as the rule wants: number of rays traced.

    sums: what the points have so far, samples 0, 1, 2 ... of each; added to. Ends early, with what
    it has, when ``cancelled`` says so; it may go on later.
    neighbours: which points tell of each other (stop rule PERCEPTUAL); None: each is alone
    """
    n = len(sums.count)
    neighbours, room = neighbours or no_neighbours(n), new_rule_room(n)
    wanted, active = np.empty(n, np.int32), np.empty(n, np.int32)
    begin_rule(rule, neighbours, sums, room, wanted)
    wanted[~sampler.lit()] = 0
    rays, traced, taken = new_rays(_BATCH_RAYS), 0, least_count(wanted, sums)
    while taken >= 0 and not cancelled():
        n_active = select_points(wanted, taken, sums, active)
        end = min(end_of_round(rule, taken), taken + _BATCH_RAYS)
        counts = np.minimum(wanted[active[:n_active]], end) - np.int32(taken)
        first = 0
        while first < n_active and not (first and cancelled()):
            last = _batch_end(counts, first)
            some, own = active[first:last].copy(), counts[first:last]
            n_rays = sampler.sample(some, taken, own, rays)
            occluded = accel.occluded(rays.origins[:n_rays], rays.directions[:n_rays])
            _add_rays(rays, n_rays, occluded, sums)
            sums.count[some] += own
            traced, first = traced + n_rays, last
        decide_rule(rule, neighbours, active, n_active, end, sums, room, wanted)
        taken = least_count(wanted, sums)
    finish_rule(rule, neighbours, sums, room)
    return traced


def sample_points(
    sampler: Sampler,
    n_points: int,
    accel: Accel,
    settings: RenderSettings,
    cancelled=lambda: False,
    neighbours: Neighbours | None = None,
) -> tuple[PixelSums, int]:
    """Run the loop for the points of one block: (sums, number of shadow rays traced).

    neighbours: see continue_points. Ends early, with what it has, when ``cancelled`` says so.
    """
    sums = new_sums(n_points)
    traced = continue_points(sampler, sums, accel, stop_rule(settings), cancelled, neighbours)
    known = sampler.unoccluded()
    if known is not None:
        sums.unoccluded[:] = known * np.maximum(sums.count, 1)[:, None]
    return sums, traced

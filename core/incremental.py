"""The paper's loop: rounds of n points for each pixel not converged yet [Huang07, algorithm 1].

Embree answers many rays at once, so a round goes over all active pixels of a tile: warp their next
n Halton points, trace one batch of shadow rays, add what was seen, drop the pixels whose error is
small enough. Samples taken once are never taken again.

A sampler (unbiased, paper, reference) fills the rays and what each carries; the error is

    e_d^2 = sum (f_i - mean f)^2 / (sum f_i)^2,  f_i = luminance of sample i if seen, else 0

which for constant weights is equation 7, and is infinite while nothing has been seen.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ._jit import kernel
from .accel import Accel
from .pyramid import luminance
from .settings import RenderSettings


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
    error: float32 (n,), e_d
    """

    count: np.ndarray
    visible: np.ndarray
    diffuse: np.ndarray
    glossy: np.ndarray
    unoccluded: np.ndarray
    seen: np.ndarray
    seen_squared: np.ndarray
    error: np.ndarray


class Sampler(Protocol):
    """Where the samples of a tile's points go. One object a tile."""

    def lit(self) -> np.ndarray:
        """bool (n,): the points that any light can reach; the others get no sample."""

    def unoccluded(self) -> np.ndarray | None:
        """I_s, float32 (n, 3), where it is known; None: the mean of the samples stands for it."""

    def sample(self, active: np.ndarray, first: int, count: int, rays: RayBatch) -> int:
        """Fill rays with samples first ... first + count - 1 of the active points.

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
        np.zeros(n),
        np.zeros(n),
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
            light = np.float64(
                luminance(
                    rays.diffuse[k, 0] + rays.glossy[k, 0],
                    rays.diffuse[k, 1] + rays.glossy[k, 1],
                    rays.diffuse[k, 2] + rays.glossy[k, 2],
                )
            )
            sums.seen[p] += light
            sums.seen_squared[p] += light * light
        for a in range(3):
            diffuse, glossy = np.float64(rays.diffuse[k, a]), np.float64(rays.glossy[k, a])
            sums.unoccluded[p, a] += diffuse + glossy
            if seen:
                sums.diffuse[p, a] += diffuse
                sums.glossy[p, a] += glossy


@kernel
def relative_error(count, seen, seen_squared):
    """e_d of a pixel from its sums, float64; infinite while nothing was seen [Huang07, eq. 7]."""
    if seen <= 0.0:
        return np.inf
    return np.sqrt(max(seen_squared - seen * seen / count, 0.0)) / seen


@kernel
def _close_round(active, count, threshold, sums, still):
    """Update counts and errors; write the points that go on into still; return how many."""
    n = 0
    for a in range(len(active)):
        p = active[a]
        sums.count[p] += count
        error = relative_error(sums.count[p], sums.seen[p], sums.seen_squared[p])
        sums.error[p] = error
        if error > threshold:
            still[n] = p
            n += 1
    return n


def sample_points(
    sampler: Sampler,
    n_points: int,
    accel: Accel,
    settings: RenderSettings,
    cancelled=lambda: False,
) -> tuple[PixelSums, int]:
    """Run the loop for the points of one tile: (sums, number of shadow rays traced).

    Ends early, with what it has, when ``cancelled`` says so.
    """
    sums = new_sums(n_points)
    # e_d is 0 where all samples were seen: E = 0 must not stop there.
    fixed = settings.stop_rule == "FIXED" or settings.error_threshold == 0.0
    threshold = -1.0 if fixed else settings.error_threshold
    rays = new_rays(n_points * min(settings.batch_size, settings.max_samples))
    active, traced, taken = np.flatnonzero(sampler.lit()).astype(np.int32), 0, 0
    still = np.empty_like(active)
    while len(active) and taken < settings.max_samples and not cancelled():
        count = min(settings.batch_size, settings.max_samples - taken)
        n_rays = sampler.sample(active, taken, count, rays)
        occluded = accel.occluded(rays.origins[:n_rays], rays.directions[:n_rays])
        _add_rays(rays, n_rays, occluded, sums)
        active = still[: _close_round(active, count, threshold, sums, still)].copy()
        traced += n_rays
        taken += count
    known = sampler.unoccluded()
    if known is not None:
        sums.unoccluded[:] = known * np.maximum(sums.count, 1)[:, None]
    return sums, traced

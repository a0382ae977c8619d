"""Mode UNBIASED: every sample weighted by L B / pdf, so that a fixed count converges to the truth.

Most points go down the product (product.py, warp.py) and on into the light's own texels; a small
part beta samples the BSDF instead, which covers whatever the product's cells gave density zero, and
more of it where a lobe is narrower than a cell. One-sample mixture: the pdf is the sum of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .brdf import lobes_at, pdf_at, sample_at
from .environment import eval_map
from .incremental import RayBatch
from .light_rays import Light, write_ray
from .lobes import DIFFUSE_LOBE, Lobes
from .product import NARROW_LEVEL, WIDE_LEVEL, build_product, choose_level, pdf_product
from .pyramid import level_offset
from .sequence import PointShifts, sample_number, shifted_point
from .shading import ShadingPoints
from .sphere_map import sphere_to_square
from .warp import (
    DX,
    DY,
    DZ,
    LANES,
    PDF,
    Lanes,
    U,
    V,
    X,
    Y,
    fill_map_coordinates,
    new_lanes,
    warp_lanes,
)

# Part of the samples that follow the BSDF: always, and in all for a mirror-like lobe.
_DEFENSIVE, _MIRROR = 0.02, 0.88
# A lobe this narrow spans about one 64^2 cell.
_CELL_ALPHA = 0.03
_ONE, _BELOW_ONE = np.float32(1.0), np.float32(1.0 - 2.0**-24)


class _Task(NamedTuple):
    """What the samples of a tile's points are made from.

    trees: float32 (n, any), the products; levels: int32 (n,), of their leaves; offset: float32
    """

    points: ShadingPoints
    lobes: Lobes
    light: Light
    trees: np.ndarray
    levels: np.ndarray
    shifts: PointShifts
    halton: np.ndarray
    offset: np.float32


class _Work(NamedTuple):
    """What the samples of a round pass through: the lanes, and those of them that follow the BSDF.

    follows: int32 (LANES,), lanes; x, y: float32 (LANES,), their points
    """

    lanes: Lanes
    follows: np.ndarray
    x: np.ndarray
    y: np.ndarray


@kernel(forceinline=True)
def bsdf_share(kind, alpha):
    """beta: the part of a point's samples that follow the BSDF (kind, alpha: of its Lobes)."""
    if kind <= DIFFUSE_LOBE:
        return _DEFENSIVE
    ratio = np.float64(alpha) / _CELL_ALPHA
    return _DEFENSIVE + _MIRROR / (1.0 + ratio * ratio)


@kernel
def _build_products(lobes, light, trees, levels):
    for p in range(len(levels)):
        level = choose_level(lobes, p)
        levels[p] = level
        if level == NARROW_LEVEL:
            build_product(lobes, p, level, light.narrow, trees[p])
        else:
            build_product(lobes, p, level, light.wide, trees[p])


@kernel(forceinline=True)
def _fill_lanes(task, p, first, last, work, n, n_follows):
    """Put samples first ... last - 1 of point p into the lanes from n on; returns n_follows."""
    lanes, numbers = work.lanes, work.lanes.numbers
    share = bsdf_share(task.lobes.kind[p], task.lobes.alpha[p])
    tree = np.int64(p) * task.trees.shape[1]
    for k in range(first, last):
        x, y = shifted_point(task.halton, task.shifts, p, k)
        if x < share:
            x /= share
            work.follows[n_follows] = n
            work.x[n_follows], work.y[n_follows] = x, y
            n_follows += 1
        else:
            x = (x - share) / (1.0 - share)
        numbers[X + n] = min(np.float32(x), _BELOW_ONE)
        numbers[Y + n] = min(np.float32(y), _BELOW_ONE)
        lanes.tree[n], lanes.point[n], lanes.sample[n] = tree, p, k
        n += 1
    return n_follows


@kernel(forceinline=True)
def _follow_bsdf(task, products, level, work, n_follows):
    """Turn the lanes that follow the BSDF to a direction of it; PDF: what the product gives it."""
    lanes, numbers, pyramid = work.lanes, work.lanes.numbers, task.light.pyramid
    for i in range(n_follows):
        s = work.follows[i]
        at = lobes_at(task.lobes, lanes.point[s])
        wx, wy, wz, _ = sample_at(at, work.x[i], work.y[i])
        x, y = sphere_to_square(np.float64(wx), np.float64(wy), np.float64(wz))
        pdf = pdf_product(products, lanes.tree[s], level, pyramid.averages, pyramid.levels, x, y)
        numbers[DX + s], numbers[DY + s], numbers[DZ + s], numbers[PDF + s] = wx, wy, wz, pdf


@kernel
def _write_lanes(task, level, work, n, n_follows, rays, m):
    """Warp lanes 0 ... n - 1 and write those that carry light as rays from m on; the next m."""
    light, lanes, numbers = task.light, work.lanes, work.lanes.numbers
    products = task.trees.reshape(-1)
    morton = light.narrow.morton if level == NARROW_LEVEL else light.wide.morton
    warp_lanes(products, level, morton, light.pyramid, lanes, n)
    _follow_bsdf(task, products, level, work, n_follows)
    fill_map_coordinates(light.lookup, lanes, n)
    s = 0
    while s < n:
        p = lanes.point[s]
        at = lobes_at(task.lobes, p)
        share = np.float32(bsdf_share(at.kind, at.alpha))
        while s < n and lanes.point[s] == p:
            wi = numbers[DX + s], numbers[DY + s], numbers[DZ + s]
            pdf = share * pdf_at(at, *wi) + (_ONE - share) * numbers[PDF + s]
            radiance = eval_map(light.lookup, numbers[U + s], numbers[V + s])
            u = sample_number(task.shifts, p, lanes.sample[s])
            m = write_ray(at, task.points, light, p, wi, radiance, pdf, u, task.offset, rays, m)
            s += 1
    return m


@kernel
def _sample_round(task, work, active, first, count, rays):
    """Fill rays with the next samples of the active points; returns how many carry light.

    Lanes are filled over the borders of points, and emptied where the products' level changes.
    """
    m, n, n_follows, level = 0, 0, 0, WIDE_LEVEL
    for a in range(len(active)):
        p, k = active[a], first
        while k < first + count:
            if n == LANES or task.levels[p] != level:
                m = _write_lanes(task, level, work, n, n_follows, rays, m)
                n, n_follows, level = 0, 0, task.levels[p]
            take = min(first + count - k, LANES - n)
            n_follows = _fill_lanes(task, p, k, k + take, work, n, n_follows)
            n, k = n + take, k + take
    return _write_lanes(task, level, work, n, n_follows, rays, m)


class UnbiasedSampler:
    """Product sampling of the points of one tile (incremental.Sampler).

    halton: float64 (count, 2); offset: metres that a shadow ray starts off its surface
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        shifts: PointShifts,
        halton: np.ndarray,
        offset: float,
    ):
        n = len(points.pixel)
        levels = np.empty(n, np.int32)
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        size = level_offset((NARROW_LEVEL if glossy else WIDE_LEVEL) + 1)
        trees = np.empty((n, size), np.float32)
        _build_products(lobes, light, trees, levels)
        self._task = _Task(points, lobes, light, trees, levels, shifts, halton, np.float32(offset))
        self._work = _Work(
            new_lanes(),
            np.empty(LANES, np.int32),
            np.empty(LANES, np.float32),
            np.empty(LANES, np.float32),
        )

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self._task.trees[:, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, count: int, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(self._task, self._work, active, first, count, rays)

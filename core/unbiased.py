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
from .sequence import PixelSequence, sample_number, scramble
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
_ZERO, _ONE, _BELOW_ONE = np.float32(0.0), np.float32(1.0), np.float32(1.0 - 2.0**-24)


class _Task(NamedTuple):
    """What the samples of a tile's points are made from.

    trees: float32 (n, any), the products; levels: int32 (n,), of their leaves; offset: float32
    """

    points: ShadingPoints
    lobes: Lobes
    light: Light
    trees: np.ndarray
    levels: np.ndarray
    sequence: PixelSequence
    offset: np.float32


class _Work(NamedTuple):
    """What the samples of a round pass through: the lanes, and those of them that follow the BSDF.

    bits: uint32 (4 LANES,), rows of points and of their scrambles; share: float32 (LANES,), beta
    follows: int32 (LANES,), lanes; x, y: float32 (LANES,), their points
    """

    lanes: Lanes
    bits: np.ndarray
    share: np.ndarray
    follows: np.ndarray
    x: np.ndarray
    y: np.ndarray


def _new_work() -> _Work:
    return _Work(
        new_lanes(),
        np.zeros(4 * LANES, np.uint32),
        np.zeros(LANES, np.float32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.float32),
        np.zeros(LANES, np.float32),
    )


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
def _fill_lanes(task, p, first, last, work, n):
    """Put samples first ... last - 1 of point p into the lanes from n on."""
    lanes, bits, sequence = work.lanes, work.bits, task.sequence
    share = np.float32(bsdf_share(task.lobes.kind[p], task.lobes.alpha[p]))
    tree = np.int64(p) * task.trees.shape[1]
    for k in range(first, last):
        bits[n], bits[LANES + n] = sequence.points[k, 0], sequence.points[k, 1]
        bits[2 * LANES + n], bits[3 * LANES + n] = sequence.x[p], sequence.y[p]
        work.share[n], lanes.tree[n], lanes.point[n], lanes.sample[n] = share, tree, p, k
        n += 1


@kernel
def _place_points(bits, scrambled, numbers, n):
    """X, Y of the lanes from their bits: 24 of them, which a float32 can hold."""
    unit, eight = np.float32(2.0**-24), np.uint32(8)
    for s in range(n):
        x, y = bits[s], bits[LANES + s]
        by_x, by_y = bits[2 * LANES + s], bits[3 * LANES + s]
        x = scramble(x, by_x) if scrambled else np.uint32(x + by_x)
        y = scramble(y, by_y) if scrambled else np.uint32(y + by_y)
        numbers[X + s] = np.float32(np.int32(x >> eight)) * unit
        numbers[Y + s] = np.float32(np.int32(y >> eight)) * unit


@kernel
def _part_lanes(work, n):
    """Note the lanes that follow the BSDF, stretch the others over the square; how many follow."""
    numbers, n_follows = work.lanes.numbers, 0
    for s in range(n):
        x, share = numbers[X + s], work.share[s]
        if x < share:
            work.follows[n_follows] = s
            work.x[n_follows], work.y[n_follows] = min(x / share, _BELOW_ONE), numbers[Y + s]
            n_follows += 1
        numbers[X + s] = min(max(x - share, _ZERO) / (_ONE - share), _BELOW_ONE)
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
def _write_lanes(task, level, work, n, rays, m):
    """Warp lanes 0 ... n - 1 and write those that carry light as rays from m on; the next m."""
    light, lanes, numbers = task.light, work.lanes, work.lanes.numbers
    products = task.trees.reshape(-1)
    _place_points(work.bits, task.sequence.scrambled, numbers, n)
    n_follows = _part_lanes(work, n)
    morton = light.narrow.morton if level == NARROW_LEVEL else light.wide.morton
    warp_lanes(products, level, morton, light.pyramid, lanes, n)
    _follow_bsdf(task, products, level, work, n_follows)
    fill_map_coordinates(light.lookup, lanes, n)
    s = 0
    while s < n:
        p = lanes.point[s]
        at = lobes_at(task.lobes, p)
        share = work.share[s]
        while s < n and lanes.point[s] == p:
            wi = numbers[DX + s], numbers[DY + s], numbers[DZ + s]
            pdf = share * pdf_at(at, *wi) + (_ONE - share) * numbers[PDF + s]
            radiance = eval_map(light.lookup, numbers[U + s], numbers[V + s])
            u = sample_number(task.sequence, p, lanes.sample[s])
            m = write_ray(at, task.points, light, p, wi, radiance, pdf, u, task.offset, rays, m)
            s += 1
    return m


@kernel
def _sample_round(task, work, active, first, count, rays):
    """Fill rays with the next samples of the active points; returns how many carry light.

    Lanes are filled over the borders of points, and emptied where the products' level changes.
    """
    m, n, level = 0, 0, WIDE_LEVEL
    for a in range(len(active)):
        p, k = active[a], first
        while k < first + count:
            if n == LANES or task.levels[p] != level:
                m = _write_lanes(task, level, work, n, rays, m)
                n, level = 0, task.levels[p]
            take = min(first + count - k, LANES - n)
            _fill_lanes(task, p, k, k + take, work, n)
            n, k = n + take, k + take
    return _write_lanes(task, level, work, n, rays, m)


class UnbiasedSampler:
    """Product sampling of the points of one tile (incremental.Sampler).

    offset: metres that a shadow ray starts off its surface
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        sequence: PixelSequence,
        offset: float,
    ):
        n = len(points.pixel)
        levels = np.empty(n, np.int32)
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        size = level_offset((NARROW_LEVEL if glossy else WIDE_LEVEL) + 1)
        trees = np.empty((n, size), np.float32)
        _build_products(lobes, light, trees, levels)
        self._task = _Task(points, lobes, light, trees, levels, sequence, np.float32(offset))
        self._work = _new_work()

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self._task.trees[:, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, count: int, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(self._task, self._work, active, first, count, rays)

"""Mode UNBIASED: every sample weighted by L B / pdf, so that a fixed count converges to the truth.

Most points go down the product (product.py, warp.py) and on into the light's own texels; a small
part beta follows the narrowest lobe instead, and more where that is narrower than the product's
cells and brings much of the light. One-sample mixture: the pdf is the sum of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .brdf import lobes_at, pdf_narrowest_at, sample_narrowest_at
from .environment import eval_map
from .incremental import RayBatch
from .light_rays import Light, write_ray
from .lobes import DIFFUSE_LOBE, Lobes
from .product import Products, new_products, pdf_product
from .product_build import build_product, new_block_scratch
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

# At least, and at most, of the samples follow the narrowest lobe (of a mirror, of a coat): how much
# light that brings, the product mistakes by up to 100 if the mirrored wo meets the rim of a sun.
_DEFENSIVE, _MIRROR, _COAT = 0.02, 0.9, 0.8
_ZERO, _ONE, _BELOW_ONE = np.float32(0.0), np.float32(1.0), np.float32(1.0 - 2.0**-24)


class _Task(NamedTuple):
    """What the samples of a tile's points are made from.

    offset: float32, metres
    """

    points: ShadingPoints
    lobes: Lobes
    light: Light
    products: Products
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
def bsdf_share(follow, kind):
    """beta: the part of a point's samples that follow its narrowest lobe.

    follow: of its Products; kind: of its Lobes
    """
    most = _COAT if kind & DIFFUSE_LOBE else _MIRROR
    return min(max(np.float64(follow), _DEFENSIVE), most)


@kernel
def _build_products(lobes, light, products, scratch):
    averages, levels = light.pyramid.averages, light.pyramid.levels
    for p in range(len(products.blocks)):
        build_product(lobes, p, light.cells, averages, levels, products, scratch)


@kernel(forceinline=True)
def _fill_lanes(task, p, first, last, work, n):
    """Put samples first ... last - 1 of point p into the lanes from n on."""
    lanes, bits, sequence = work.lanes, work.bits, task.sequence
    share = np.float32(bsdf_share(task.products.follow[p], task.lobes.kind[p]))
    tree = np.int64(p) * task.products.trees.shape[1]
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
def _follow_lobes(task, work, n_follows):
    """Turn the lanes that follow a lobe to a direction of it; PDF: what the product gives it."""
    lanes, numbers, pyramid = work.lanes, work.lanes.numbers, task.light.pyramid
    for i in range(n_follows):
        s = work.follows[i]
        p = lanes.point[s]
        wx, wy, wz = sample_narrowest_at(lobes_at(task.lobes, p), work.x[i], work.y[i])
        x, y = sphere_to_square(np.float64(wx), np.float64(wy), np.float64(wz))
        pdf = pdf_product(task.products, p, pyramid, x, y)
        numbers[DX + s], numbers[DY + s], numbers[DZ + s], numbers[PDF + s] = wx, wy, wz, pdf


@kernel
def _write_lanes(task, cut, work, n, rays, m):
    """Warp lanes 0 ... n - 1 and write those that carry light as rays from m on; the next m."""
    light, lanes, numbers = task.light, work.lanes, work.lanes.numbers
    _place_points(work.bits, task.sequence.scrambled, numbers, n)
    n_follows = _part_lanes(work, n)
    warp_lanes(task.products, cut, light.cells.morton, light.pyramid, light.leaves, lanes, n)
    _follow_lobes(task, work, n_follows)
    fill_map_coordinates(light.lookup, lanes, n)
    s = 0
    while s < n:
        p = lanes.point[s]
        at = lobes_at(task.lobes, p)
        share = work.share[s]
        while s < n and lanes.point[s] == p:
            wi = numbers[DX + s], numbers[DY + s], numbers[DZ + s]
            pdf = share * pdf_narrowest_at(at, *wi) + (_ONE - share) * numbers[PDF + s]
            radiance = eval_map(light.lookup, numbers[U + s], numbers[V + s])
            u = sample_number(task.sequence, p, lanes.sample[s])
            m = write_ray(at, task.points, light, p, wi, radiance, pdf, u, task.offset, rays, m)
            s += 1
    return m


@kernel
def _sample_round(task, work, active, first, counts, rays):
    """Fill rays with the next samples of the active points; returns how many carry light.

    Lanes are filled over the borders of points, but not by points with and without blocks.
    """
    m, n, cut = 0, 0, False
    for a in range(len(active)):
        p, k, last = active[a], first, first + counts[a]
        while k < last:
            if n == LANES or (task.products.blocks[p] > 0) != cut:
                m = _write_lanes(task, cut, work, n, rays, m)
                n, cut = 0, task.products.blocks[p] > 0
            take = min(last - k, LANES - n)
            _fill_lanes(task, p, k, k + take, work, n)
            n, k = n + take, k + take
    return _write_lanes(task, cut, work, n, rays, m)


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
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        products = new_products(len(points.pixel), glossy)
        _build_products(lobes, light, products, new_block_scratch())
        self._task = _Task(points, lobes, light, products, sequence, np.float32(offset))
        self._work = _new_work()

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self._task.products.trees[:, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(self._task, self._work, active, first, counts, rays)

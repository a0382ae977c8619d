"""Mode UNBIASED: every sample weighted by L B / pdf, so that a fixed count converges to the truth.

Most points go down the product (product.py, warp.py) and on into the light's own texels; a small
part beta follows the narrowest lobe instead, and more where that is narrower than the product's
cells and brings much of the light. One-sample mixture: the pdf is the sum of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import sample_narrowest_at
from ..bsdf.hair_samples import sample_strand
from ..bsdf.lambert_kinds import HAIR, TRANSLUCENT_ROUND
from ..bsdf.lobes import DIFFUSE_LOBE, Lobes
from ..bsdf.lobes_at import lobes_at
from ..geometry.shading import ShadingPoints
from ..machine.lanes import DIFFUSE, DX, DY, DZ, GLOSSY, LANES, OX, PDF, Lanes, X, Y, new_lanes
from ..products.guide import Guides, note_rays
from ..products.like_products import ProductScratch, new_product_scratch
from ..products.product import Products, pdf_product
from ..products.warp import fill_map_coordinates, warp_lanes
from ..unit_square.sample_order import MOST_ORDERED, SampleOrder, new_sample_order, order_samples
from ..unit_square.sequence import PixelSequence, scramble
from ..unit_square.sphere_map import sphere_to_square
from .light_rays import Light
from .trace_lanes import add_lanes, trace_lanes
from .weigh import fill_radiance, weigh_lanes

# At least, and at most, of the samples follow the narrowest lobe (of a mirror, of a coat): how much
# light that brings, the product mistakes by up to 100 if the mirrored wo meets the rim of a sun.
_DEFENSIVE, _MIRROR, _COAT = 0.02, 0.9, 0.8
_ZERO, _ONE, _BELOW_ONE = np.float32(0.0), np.float32(1.0), np.float32(1.0 - 2.0**-24)


class Task(NamedTuple):
    """What the samples of some shading points are made from.

    products: of these points; guide: of their block, or of none (guide.py)
    offset: float32, metres that a shadow ray starts off its surface
    """

    points: ShadingPoints
    lobes: Lobes
    light: Light
    products: Products
    guide: Guides
    sequence: PixelSequence
    offset: np.float32


class Work(NamedTuple):
    """What the samples of a round pass through: the lanes, and those of them that follow the BSDF.

    bits: uint32 (4 LANES,), rows of points and of their scrambles; share: float32 (LANES,), beta
    follows: int32 (LANES,), lanes; x, y: float32 (LANES,), their points
    scratch: where products are worked out; order: of the samples of a call
    """

    lanes: Lanes
    bits: np.ndarray
    share: np.ndarray
    follows: np.ndarray
    x: np.ndarray
    y: np.ndarray
    scratch: ProductScratch
    order: SampleOrder


def new_work() -> Work:
    """One a thread."""
    return Work(
        new_lanes(),
        np.zeros(4 * LANES, np.uint32),
        np.zeros(LANES, np.float32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.float32),
        np.zeros(LANES, np.float32),
        new_product_scratch(),
        new_sample_order(),
    )


@kernel(forceinline=True)
def bsdf_share(follow, kind):
    """beta: the part of a point's samples that follow its narrowest lobe.

    follow: of its Products; kind: of its Lobes
    """
    most = _COAT if kind & DIFFUSE_LOBE else _MIRROR
    return min(max(np.float64(follow), _DEFENSIVE), most)


@kernel(inline="always")
def _fill_lanes(task, p, end, samples, k, work, n):
    """Put those of samples[k:], int32, that are below end into the lanes of point p from n on.

    Returns the next k and n.
    """
    lanes, bits, sequence = work.lanes, work.bits, task.sequence
    share = np.float32(bsdf_share(task.products.follow[p], task.lobes.kind[p]))
    own = task.products.own[p]
    tree = np.int64(own) * task.products.trees.shape[1]
    while k < len(samples) and n < LANES:
        i = samples[k]
        k += 1
        if i < end:
            bits[n], bits[LANES + n] = sequence.points[i, 0], sequence.points[i, 1]
            bits[2 * LANES + n], bits[3 * LANES + n] = sequence.x[p], sequence.y[p]
            work.share[n], lanes.product[n], lanes.tree[n] = share, own, tree
            lanes.point[n], lanes.sample[n] = p, i
            n += 1
    return k, n


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
        at = lobes_at(task.lobes, p)
        if TRANSLUCENT_ROUND < at.rough[3] <= HAIR:
            wx, wy, wz = sample_strand(at, work.x[i], work.y[i])
        else:
            wx, wy, wz = sample_narrowest_at(at, work.x[i], work.y[i])
        x, y = sphere_to_square(np.float64(wx), np.float64(wy), np.float64(wz))
        pdf = pdf_product(task.products, p, pyramid, x, y)
        lanes.base[s] = -1
        numbers[DX + s], numbers[DY + s], numbers[DZ + s], numbers[PDF + s] = wx, wy, wz, pdf


@kernel(inline="always")
def _finish_lanes(task, cut, work, n):
    """From numbers in lanes 0 ... n - 1 to directions and what these would bring."""
    light, lanes, numbers = task.light, work.lanes, work.lanes.numbers
    _place_points(work.bits, task.sequence.scrambled, numbers, n)
    n_follows = _part_lanes(work, n)
    warp_lanes(task.products, cut, light.pyramid, light.leaves, lanes, n)
    _follow_lobes(task, work, n_follows)
    fill_map_coordinates(light.lookup, lanes, n)
    fill_radiance(light.lookup, lanes, n)
    weigh_lanes(task, work.share, lanes, n)


@kernel
def _write_rays(lanes, n, rays, m):
    """Write the lanes that carry light as rays from m on; the next m."""
    numbers = lanes.numbers
    for s in range(n):
        carried = _ZERO
        for a in range(3):
            rays.origins[m, a] = numbers[OX + LANES * a + s]
            rays.directions[m, a] = numbers[DX + LANES * a + s]
            rays.diffuse[m, a] = numbers[DIFFUSE + LANES * a + s]
            rays.glossy[m, a] = numbers[GLOSSY + LANES * a + s]
            carried += rays.diffuse[m, a] + rays.glossy[m, a]
        rays.point[m] = lanes.point[s]
        m += abs(carried) > _ZERO
    return m


@kernel(inline="always")
def _use_lanes(task, cut, work, n, traversal, sums, rays, m):
    """Trace lanes 0 ... n - 1 and add them to the sums; or write them as rays, if these are wanted.

    Returns m and the number of rays.
    """
    _finish_lanes(task, cut, work, n)
    if len(rays.point) > 0:
        return _write_rays(work.lanes, n, rays, m)
    n_rays = trace_lanes(traversal, work.lanes, n, sums.seen)
    add_lanes(work.lanes, n, sums)
    if len(task.guide.learnt) > 0:
        note_rays(work.lanes, n_rays, task.guide)
    return m + n_rays


@kernel(inline="always")
def _take_in_order(task, work, active, n_active, first, counts, some, traversal, sums, rays, m):
    """take_samples for some samples, int32; rays are written from m on. Returns the next m."""
    # Numbers of a type that is known: for literals, kernels are compiled once more.
    n, a, k, cut = np.int64(0), np.int64(0), np.int64(0), n_active < 0
    while a < n_active or n > 0:
        p = active[min(a, n_active - 1)]
        if n > 0 and (a == n_active or n == LANES or (task.products.blocks[p] > 0) != cut):
            m = _use_lanes(task, cut, work, n, traversal, sums, rays, m)
            n = np.int64(0)
            continue
        cut = task.products.blocks[p] > 0
        k, n = _fill_lanes(task, p, first + counts[a], some, k, work, n)
        if k == len(some):
            a, k = a + 1, np.int64(0)
    return m


@kernel
def take_samples(task, work, active, n_active, first, counts, traversal, sums, rays):
    """Samples first ... first + counts[a] - 1 of each active point; how many have a ray.

    active, counts: int32 (>= n_active,); sums: PixelSums, added to, but for their count.
    rays: RayBatch; where it has room, the rays are written there instead, and nothing is traced.
    Lanes are filled over the borders of points, but not by points with and without blocks.
    """
    m, most, begin = np.int64(0), np.int64(0), np.int64(0)
    for a in range(n_active):
        most = max(most, counts[a])
    while begin < most:
        size = min(most - begin, MOST_ORDERED)
        order_samples(task.sequence, first + begin, size, work.order)
        some = work.order.samples[:size]
        m = _take_in_order(
            task, work, active, n_active, first, counts, some, traversal, sums, rays, m
        )
        begin += size
    return m

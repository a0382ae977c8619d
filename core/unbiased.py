"""Mode UNBIASED: every sample weighted by L B / pdf, so that a fixed count converges to the truth.

Most points go down the product (product.py) and on into the light's own texels; a small part beta
samples the BSDF instead, which covers whatever the product's cells gave density zero, and more of
it where a lobe is narrower than a cell. One-sample mixture: the pdf is the sum of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .accel import start_shadow_ray
from .brdf import eval_at, lobes_at, pdf_at, sample_at
from .environment import EnvironmentLookup, eval_environment
from .halton import halton_table, hash_pixel
from .incremental import RayBatch
from .lobes import DIFFUSE_LOBE, Lobes
from .product import (
    NARROW_LEVEL,
    WIDE_LEVEL,
    ProductCells,
    build_product,
    choose_level,
    new_lanes,
    pdf_product,
    product_cells,
    warp_product,
)
from .pyramid import LightPyramid, level_offset, pdf_light
from .shading import ShadingPoints
from .sphere_map import sphere_to_square

# Part of the samples that follow the BSDF: always, and in all for a mirror-like lobe.
_DEFENSIVE, _MIRROR = 0.02, 0.88
# A lobe this narrow spans about one 64^2 cell.
_CELL_ALPHA = 0.03


class Light(NamedTuple):
    """All that a sampler asks of the environment."""

    lookup: EnvironmentLookup
    pyramid: LightPyramid
    wide: ProductCells
    narrow: ProductCells


class PointShifts(NamedTuple):
    """The Cranley-Patterson shift of each shading point: x, y float64 (n,)."""

    x: np.ndarray
    y: np.ndarray


def make_light(lookup: EnvironmentLookup, pyramid: LightPyramid) -> Light:
    """Everything of the light, from its lookup and its quadtree."""
    return Light(
        lookup, pyramid, product_cells(pyramid, WIDE_LEVEL), product_cells(pyramid, NARROW_LEVEL)
    )


@kernel
def _fill_shifts(pixel, width, x0, y0, seed, shifts):
    for k in range(len(pixel)):
        column, row = x0 + pixel[k] % width, y0 + pixel[k] // width
        shifts.x[k] = hash_pixel(column, row, seed, 1)
        shifts.y[k] = hash_pixel(column, row, seed, 2)


def point_shifts(points: ShadingPoints, tile, seed: int, decorrelation: str) -> PointShifts:
    """Each point's shift, from its place in the frame and the seed; zero for NONE.

    tile: (x, y, width) of the pixels in the frame
    """
    n = len(points.pixel)
    shifts = PointShifts(np.zeros(n), np.zeros(n))
    if decorrelation == "PIXEL":
        x, y, width = tile
        _fill_shifts(points.pixel, width, x, y, seed, shifts)
    return shifts


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
def _shifted(points, shift, k, axis):
    x = points[k, axis] + shift
    return x - np.floor(x)


@kernel
def _fill_lanes(halton, shifts, p, share, first, count, lanes):
    """Points that follow the BSDF at the end of the lanes, the others at their beginning.

    Sums of light must not depend on the size of a batch, so lanes.order keeps the samples' own
    order. Returns how many follow the product.
    """
    n, m = 0, count
    for k in range(first, first + count):
        x, y = _shifted(halton, shifts.x[p], k, 0), _shifted(halton, shifts.y[p], k, 1)
        if x < share:
            m -= 1
            lanes.x[m], lanes.y[m] = x / share, y
            lanes.order[k - first] = m
        else:
            lanes.x[n], lanes.y[n] = (x - share) / (1.0 - share), y
            lanes.order[k - first] = n
            n += 1
    return n


@kernel(forceinline=True)
def _sample_lobes(at, light, trees, level, p, share, lanes, first, last):
    """Lanes first ... last - 1 follow the BSDF; their pdf is that of the mixture."""
    averages, levels = light.pyramid.averages, light.pyramid.levels
    for s in range(first, last):
        wx, wy, wz, pdf = sample_at(at, np.float32(lanes.x[s]), np.float32(lanes.y[s]))
        dx, dy, dz = np.float64(wx), np.float64(wy), np.float64(wz)
        square_x, square_y = sphere_to_square(dx, dy, dz)
        from_product = pdf_product(trees, p, level, averages, levels, square_x, square_y)
        lanes.dx[s], lanes.dy[s], lanes.dz[s] = dx, dy, dz
        lanes.pdf[s] = share * np.float64(pdf) + (1.0 - share) * from_product


@kernel(forceinline=True)
def sample_number(shifts, p, k):
    """A number in [0, 1) of sample k of point p, apart from its Halton point."""
    u = shifts.x[p] + shifts.y[p] + k * 0.6180339887498949
    return u - np.floor(u)


@kernel(forceinline=True)
def _is_lifted(at, points, light, p, wx, wy, wz, u):
    """Whether a sample's ray starts on the smooth patch, as Cycles' rays would.

    Cycles lifts the rays of its light samples and not those of its BSDF samples: of the light from
    a direction, the share that the power heuristic gives to light sampling comes over the patch.
    """
    below, face = points.lift_below[p], points.geometric_normal
    above = face[p, 0] * wx + face[p, 1] * wy + face[p, 2] * wz
    if below <= np.float32(0.0) or above >= below + below:  # lift_share would be 0
        return False
    averages, levels = light.pyramid.averages, light.pyramid.levels
    by_light = pdf_light(averages, levels, np.float64(wx), np.float64(wy), np.float64(wz))
    by_bsdf = np.float64(pdf_at(at, wx, wy, wz))
    return u * (by_light * by_light + by_bsdf * by_bsdf) < by_light * by_light


@kernel(forceinline=True)
def write_ray(at, points, light, p, dx, dy, dz, pdf, u, offset, rays, n):
    """Write sample (dx, dy, dz) of point p as ray n if it can carry light; returns the next n.

    u: sample_number
    """
    if not pdf > 0.0:
        return n
    wx, wy, wz = np.float32(dx), np.float32(dy), np.float32(dz)
    dr, dg, db, gr, gg, gb = eval_at(at, wx, wy, wz)
    if dr + dg + db + gr + gg + gb <= np.float32(0.0):
        return n
    lr, lg, lb = eval_environment(light.lookup, wx, wy, wz)
    if lr + lg + lb <= np.float32(0.0):
        return n
    lifted = _is_lifted(at, points, light, p, wx, wy, wz, u)
    if not start_shadow_ray(points, p, wx, wy, wz, lifted, offset, rays.origins, n):
        return n
    inverse = np.float32(1.0 / pdf)
    rays.diffuse[n, 0] = dr * lr * inverse
    rays.diffuse[n, 1] = dg * lg * inverse
    rays.diffuse[n, 2] = db * lb * inverse
    rays.glossy[n, 0] = gr * lr * inverse
    rays.glossy[n, 1] = gg * lg * inverse
    rays.glossy[n, 2] = gb * lb * inverse
    rays.directions[n, 0], rays.directions[n, 1], rays.directions[n, 2] = wx, wy, wz
    rays.point[n] = p
    return n + 1


@kernel
def _sample_round(
    points, lobes, light, trees, levels, shifts, halton, lanes, offset, active, first, count, rays
):
    """Fill rays with the next samples of the active points; returns how many carry light."""
    n = 0
    averages, finest = light.pyramid.averages, light.pyramid.levels
    for a in range(len(active)):
        p = active[a]
        at = lobes_at(lobes, p)
        level, share = levels[p], bsdf_share(at.kind, at.alpha)
        morton = light.narrow.morton if level == NARROW_LEVEL else light.wide.morton
        middle = _fill_lanes(halton, shifts, p, share, first, count, lanes)
        warp_product(trees, p, level, morton, averages, finest, lanes, 0, middle)
        for s in range(middle):
            wx, wy, wz = np.float32(lanes.dx[s]), np.float32(lanes.dy[s]), np.float32(lanes.dz[s])
            from_lobes = np.float64(pdf_at(at, wx, wy, wz))
            lanes.pdf[s] = share * from_lobes + (1.0 - share) * lanes.pdf[s]
        _sample_lobes(at, light, trees, level, p, share, lanes, middle, count)
        for k in range(count):
            s = lanes.order[k]
            dx, dy, dz, pdf = lanes.dx[s], lanes.dy[s], lanes.dz[s], lanes.pdf[s]
            u = sample_number(shifts, p, first + k)
            n = write_ray(at, points, light, p, dx, dy, dz, pdf, u, offset, rays, n)
    return n


class UnbiasedSampler:
    """Product sampling of the points of one tile (incremental.Sampler).

    halton: float64 (count, 2); batch_size: the most samples of a point in one call; offset: metres
    that a shadow ray starts off its surface
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        shifts: PointShifts,
        halton: np.ndarray,
        batch_size: int,
        offset: float,
    ):
        self._points, self._lobes, self._light = points, lobes, light
        self._shifts, self._halton, self._offset = shifts, halton, np.float32(offset)
        n = len(points.pixel)
        self._lanes = new_lanes(batch_size)
        self._levels = np.empty(n, np.int32)
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        size = level_offset((NARROW_LEVEL if glossy else WIDE_LEVEL) + 1)
        self._trees = np.empty((n, size), np.float32)
        _build_products(lobes, light, self._trees, self._levels)

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self._trees[:, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, count: int, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(
            self._points,
            self._lobes,
            self._light,
            self._trees,
            self._levels,
            self._shifts,
            self._halton,
            self._lanes,
            self._offset,
            active,
            first,
            count,
            rays,
        )


def halton_points(count: int) -> np.ndarray:
    """float64 (count, 2): the points that all pixels shift."""
    table = np.empty((count, 2))
    halton_table(count, table)
    return table

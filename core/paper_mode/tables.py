"""The paper's tables: light and BRDF as 64^4, compressed by their Haar series [Huang07, section 4].

Light: for 64 x 64 normals over the sphere, the radiance of 64 x 64 local directions of the
hemisphere round each (Haar series cannot be rotated, so the light is, beforehand). BRDF: for
64 x 64 outgoing directions, BRDF x cosine of 64 x 64 incoming ones; one table for each width of
lobe and each curve of its Fresnel factor, so that colours stay outside. The Lambert lobe needs one
slice.

All cells have the same solid angle (sphere_map), and hold averages over it.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from .._jit import kernel
from ..bsdf.merl import eval_merl
from ..bsdf.microfacet import (
    beckmann_d,
    beckmann_lambda,
    dielectric_blend,
    ggx_d,
    ggx_lambda,
    schlick_weight,
)
from ..light.environment import EnvironmentLookup, eval_environment
from ..unit_square.sphere_map import (
    fill_hemisphere_grid,
    sphere_grid,
    sphere_to_square,
    square_to_hemisphere,
    square_to_sphere,
)
from ..wavelets.haar_forest import HaarForest, build_forest, join_forests

SIDE = 64
SLICES = SIDE * SIDE
# Curves of the Fresnel factor: 1, the dielectric's, (1 - c)^5, c (1 - c)^6.
CURVES = PLAIN, DIELECTRIC_CURVE, SCHLICK_CURVE, EDGE_CURVE = (0, 1, 2, 3)
_GRID_SIDE = 256  # of the sphere that slices of the light are averaged from
_PER_SIDE = 3  # its samples across a cell of a slice: a cell is 2.2 degrees wide, a sample 0.8
_MEASURED_PER_SIDE = 2
_CHUNK = 64


@kernel
def slice_frame(nx, ny, nz):
    """The tangents (t, b) that go with a slice's normal, right-handed [Duff17]."""
    sign = math.copysign(1.0, nz)
    a = -1.0 / (sign + nz)
    b = nx * ny * a
    return (1.0 + sign * nx * nx * a, sign * b, -sign * nx), (b, sign + ny * ny * a, -ny)


def light_frames() -> np.ndarray:
    """float32 (SLICES, 3, 3): rows t, b, n of each slice of the light, world space."""
    normals = sphere_grid(SIDE)
    frames = np.empty((SLICES, 3, 3), np.float32)
    for s, (nx, ny, nz) in enumerate(normals.astype(np.float64)):
        t, b = slice_frame(nx, ny, nz)
        frames[s] = t, b, (nx, ny, nz)
    return frames


@kernel
def _fill_radiance(lookup, side, per_side, first, last, grid):
    for cell in range(first, last):
        row, column = cell // side, cell % side
        r = g = b = 0.0
        for sample in range(per_side * per_side):
            x = (column + (sample % per_side + 0.5) / per_side) / side
            y = (row + (sample // per_side + 0.5) / per_side) / side
            dx, dy, dz = _sphere(x, y)
            lr, lg, lb = eval_environment(lookup, dx, dy, dz)
            r += max(lr, np.float32(0.0))  # negative light is for mode UNBIASED alone
            g += max(lg, np.float32(0.0))
            b += max(lb, np.float32(0.0))
        share = 1.0 / (per_side * per_side)
        grid[cell, 0], grid[cell, 1], grid[cell, 2] = r * share, g * share, b * share


@kernel
def _fill_light_slices(grid, grid_side, frames, local, first, slices):
    """Average the samples of each cell of each slice; local: float32 (SLICES * per_side^2, 3)."""
    per_cell = local.shape[0] // (SIDE * SIDE)
    share = np.float32(1.0 / per_cell)
    for s in range(slices.shape[0]):
        t, b, n = frames[first + s, 0], frames[first + s, 1], frames[first + s, 2]
        for cell in range(SIDE * SIDE):
            red = green = blue = np.float32(0.0)
            for k in range(cell * per_cell, (cell + 1) * per_cell):
                x, y, z = local[k, 0], local[k, 1], local[k, 2]
                dx = x * t[0] + y * b[0] + z * n[0]
                dy = x * t[1] + y * b[1] + z * n[1]
                dz = x * t[2] + y * b[2] + z * n[2]
                u, v = sphere_to_square(dx, dy, min(max(dz, np.float32(-1)), np.float32(1)))
                column = min(int(u * grid_side), grid_side - 1)
                row = min(int(v * grid_side), grid_side - 1)
                texel = grid[row * grid_side + column]
                red += texel[0]
                green += texel[1]
                blue += texel[2]
            i, j = cell // SIDE, cell % SIDE
            slices[s, 0, i, j] = red * share
            slices[s, 1, i, j] = green * share
            slices[s, 2, i, j] = blue * share


@kernel
def _fill_cell_samples(per_side, local):
    """Local directions of per_side^2 samples in each cell, cell by cell."""
    n = 0
    for cell in range(SIDE * SIDE):
        for sample in range(per_side * per_side):
            x = (cell % SIDE + (sample % per_side + 0.5) / per_side) / SIDE
            y = (cell // SIDE + (sample // per_side + 0.5) / per_side) / SIDE
            dx, dy, dz = square_to_hemisphere(x, y)
            local[n, 0], local[n, 1], local[n, 2] = dx, dy, dz
            n += 1


def cell_samples(per_side: int) -> np.ndarray:
    """float32 (SLICES * per_side^2, 3): local directions that stand for the cells of a slice."""
    local = np.empty((SLICES * per_side * per_side, 3), np.float32)
    _fill_cell_samples(per_side, local)
    return local


def build_light_table(
    lookup: EnvironmentLookup, fraction: float, threads: int, progress=lambda fraction: None
) -> HaarForest:
    """The light's 64^4 table, 3 channels, ``fraction`` of the coefficients of each slice."""
    grid = _radiance_grid(lookup, threads)
    frames, local = light_frames(), cell_samples(_PER_SIDE)

    def build(first):
        slices = np.empty((_CHUNK, 3, SIDE, SIDE), np.float32)
        _fill_light_slices(grid, _GRID_SIDE, frames, local, first, slices)
        return build_forest(slices, fraction)

    return join_forests(_in_chunks(build, threads, progress))


def _radiance_grid(lookup, threads):
    """float32 (_GRID_SIDE^2, 3): the light averaged over the cells of a sphere grid."""
    height, width = lookup.texels.shape[:2]
    per_side = int(np.clip(np.ceil(1.5 * math.sqrt(width * height) / _GRID_SIDE), 2, 24))
    grid = np.empty((_GRID_SIDE * _GRID_SIDE, 3), np.float32)
    rows = _GRID_SIDE * 8

    def fill(first):
        _fill_radiance(lookup, _GRID_SIDE, per_side, first, first + rows, grid)

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(fill, range(0, len(grid), rows)))
    return grid


@kernel
def _fill_lobe_slices(outgoing, local, first, alpha, beckmann, fresnel, curve, slices):
    """BRDF x cosine without colour, averaged over each cell; see brdf.eval_brdf_cos."""
    per_cell = local.shape[0] // (SIDE * SIDE)
    one, half = np.float32(1.0), np.float32(0.5)
    share = np.float32(1.0 / per_cell)
    alpha2 = alpha * alpha
    for s in range(slices.shape[0]):
        ox, oy, oz = outgoing[first + s, 0], outgoing[first + s, 1], outgoing[first + s, 2]
        hidden_o = beckmann_lambda(alpha2, oz) if beckmann else ggx_lambda(alpha2, oz)
        for cell in range(SIDE * SIDE):
            total = np.float32(0.0)
            for k in range(cell * per_cell, (cell + 1) * per_cell):
                hx, hy, hz = local[k, 0] + ox, local[k, 1] + oy, local[k, 2] + oz
                length2 = hx * hx + hy * hy + hz * hz
                cos_h = half * np.sqrt(length2)
                sin2 = max((hx * hx + hy * hy) / length2, np.float32(0.0))
                if beckmann:
                    density = beckmann_d(alpha2, sin2)
                    hidden = beckmann_lambda(alpha2, local[k, 2])
                else:
                    density = ggx_d(alpha2, sin2)
                    hidden = ggx_lambda(alpha2, local[k, 2])
                value = density / (np.float32(4.0) * oz * (one + hidden_o + hidden))
                if curve == DIELECTRIC_CURVE:
                    value *= dielectric_blend(cos_h, fresnel[0], fresnel[1], fresnel[2])
                elif curve == SCHLICK_CURVE:
                    value *= schlick_weight(cos_h)
                elif curve == EDGE_CURVE:
                    value *= cos_h * (one - cos_h) * schlick_weight(cos_h)
                total += value
            slices[s, 0, cell // SIDE, cell % SIDE] = total * share


def build_lobe_table(
    alpha: float,
    beckmann: bool,
    fresnel: tuple[float, float, float],
    curve: int,
    fraction: float,
    threads: int,
    progress=lambda fraction: None,
) -> HaarForest:
    """The 64^4 table of one microfacet lobe and one of CURVES, 1 channel.

    fresnel: what microfacet.dielectric_blend wants; only DIELECTRIC_CURVE reads it
    """
    local = cell_samples(4 if alpha < 0.1 else 2)
    outgoing = np.empty((SLICES, 3), np.float32)
    fill_hemisphere_grid(SIDE, outgoing)
    constants = np.asarray(fresnel, np.float32)

    def build(first):
        slices = np.empty((_CHUNK, 1, SIDE, SIDE), np.float32)
        _fill_lobe_slices(
            outgoing, local, first, np.float32(alpha), beckmann, constants, curve, slices
        )
        return build_forest(slices, fraction)

    return join_forests(_in_chunks(build, threads, progress))


@kernel
def _fill_measured_slices(tables, row, outgoing, local, first, slices):
    """A measured BRDF x cosine, averaged over each cell, three channels."""
    zero = np.float32(0.0)
    up = (zero, zero, np.float32(1.0))
    per_cell = local.shape[0] // (SIDE * SIDE)
    share = np.float32(1.0 / per_cell)
    for s in range(slices.shape[0]):
        wo = (outgoing[first + s, 0], outgoing[first + s, 1], outgoing[first + s, 2])
        for cell in range(SIDE * SIDE):
            red = green = blue = zero
            for k in range(cell * per_cell, (cell + 1) * per_cell):
                z = local[k, 2]
                r, g, b = eval_merl(tables, row, up, wo, (local[k, 0], local[k, 1], z))
                red += r * z
                green += g * z
                blue += b * z
            i, j = cell // SIDE, cell % SIDE
            slices[s, 0, i, j] = red * share
            slices[s, 1, i, j] = green * share
            slices[s, 2, i, j] = blue * share


def build_measured_table(
    tables: np.ndarray,
    row: int,
    fraction: float,
    threads: int,
    progress=lambda fraction: None,
) -> HaarForest:
    """The 64^4 table of one measured BRDF, 3 channels; tables: MeasuredBrdfs.values."""
    local = cell_samples(_MEASURED_PER_SIDE)
    outgoing = np.empty((SLICES, 3), np.float32)
    fill_hemisphere_grid(SIDE, outgoing)

    def build(first):
        slices = np.empty((_CHUNK, 3, SIDE, SIDE), np.float32)
        _fill_measured_slices(tables, row, outgoing, local, first, slices)
        return build_forest(slices, fraction)

    return join_forests(_in_chunks(build, threads, progress))


def build_lambert_table(fraction: float) -> HaarForest:
    """The one slice of cosine / pi, 1 channel."""
    cosine = cell_samples(4)[:, 2].reshape(SIDE, SIDE, -1).mean(-1) / np.float32(math.pi)
    return build_forest(cosine[None, None].astype(np.float32), fraction)


def _in_chunks(build, threads, progress):
    parts, starts = [], range(0, SLICES, _CHUNK)
    with ThreadPoolExecutor(threads) as pool:
        for part in pool.map(build, starts):
            parts.append(part)
            progress(len(parts) / len(starts))
    return parts


@kernel
def _sphere(x, y):
    from_square = square_to_sphere(x, y)
    return np.float32(from_square[0]), np.float32(from_square[1]), np.float32(from_square[2])

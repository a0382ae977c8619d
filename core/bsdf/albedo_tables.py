"""What a rough surface reflects in all: the tables behind energy conservation and layering.

Each entry is a mean over the normals that a viewer sees. The grids and the linear interpolation
between their points are part of the model: Cycles' Principled BSDF is defined by them, and a finer
table would be another material. The numbers are our own quadrature.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .microfacet import (
    HALF,
    ONE,
    TWO,
    ZERO,
    dielectric_blend,
    ggx_lambda,
    sample_ggx_visible_normal,
)

ALBEDO_POINTS, BLEND_POINTS = 32, 16
# A Fibonacci lattice; its tables are within 5e-4 of the converged ones, on average within 1e-6.
_LATTICE, _STEP = 4181, 2584
_TINY = np.float32(1e-4)  # for roughness 0 and cos 0, where the ratios have no value
_STEEP = np.float32(0.99)  # and for the infinite index of refraction


class AlbedoTables(NamedTuple):
    """Directional albedos of the GGX microsurface; roughness is the root of alpha.

    albedo: float32 (32, 32), [cos of wo, roughness], of a surface whose facets reflect all
    mean_albedo: float32 (32,), [roughness], its cosine-weighted mean
    dielectric: float32 (16, 16, 16), [ior, cos of wo, roughness], mean of dielectric_blend; the
        ior axis is the fourth root of its F0
    metal: float32 (16, 16), [cos of wo, roughness], mean of Schlick's weight with the powers 40/7
        and 35/8 (Cycles reads a table over powers half-way between these two)
    """

    albedo: np.ndarray
    mean_albedo: np.ndarray
    dielectric: np.ndarray
    metal: np.ndarray


@functools.cache
def albedo_tables() -> AlbedoTables:
    """The tables, computed in a tenth of a second at the first call."""
    i = np.arange(_LATTICE)
    # Half a turn is enough: the other half is its mirror image.
    lattice = np.stack([0.5 * (i + 0.5), i * _STEP % _LATTICE + 0.5]) / _LATTICE
    lattice = lattice.astype(np.float32)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    cosines = (0.5 + 0.5 * nodes).astype(np.float32)
    albedo = np.zeros((ALBEDO_POINTS, ALBEDO_POINTS), np.float32)
    mean_albedo = np.zeros(ALBEDO_POINTS, np.float32)
    _fill_albedo(lattice, cosines, (weights * cosines).astype(np.float32), albedo, mean_albedo)

    grid = np.clip(np.arange(BLEND_POINTS, dtype=np.float32) / (BLEND_POINTS - 1), _TINY, _STEEP)
    f0 = grid[1:] ** 4  # the first row is the index 1: nothing is reflected
    eta = (1.0 + np.sqrt(f0)) / (1.0 - np.sqrt(f0))
    blends = np.zeros((BLEND_POINTS, BLEND_POINTS, BLEND_POINTS), np.float32)
    metal = np.zeros((BLEND_POINTS, BLEND_POINTS), np.float32)
    _fill_blends(lattice, eta * eta - 1.0, f0, 1.0 / (1.0 - f0), blends, metal)
    dielectric = np.ascontiguousarray(np.moveaxis(blends, 2, 0))
    return AlbedoTables(albedo, mean_albedo, dielectric, metal)


@kernel
def _facet_cosines(roughness, cos_o, u1, u2):
    """A visible normal of the lattice: cosines of wi with the surface, and of wo with the facet."""
    wo_x, alpha = math.sqrt(max(ONE - cos_o * cos_o, ZERO)), roughness * roughness
    hx, _, hz = sample_ggx_visible_normal(wo_x, ZERO, cos_o, alpha, alpha, u1, u2)
    cos_h = wo_x * hx + cos_o * hz
    return TWO * cos_h * hz - cos_o, cos_h


@kernel
def _albedo(lattice, roughness, cos_o):
    """Light that leaves in all directions: of the facets seen, those seen from wi as well."""
    alpha = roughness * roughness
    alpha2 = alpha * alpha
    seen = ONE + ggx_lambda(alpha2, cos_o)
    total = 0.0
    for i in range(lattice.shape[1]):
        cos_i, _ = _facet_cosines(roughness, cos_o, lattice[0, i], lattice[1, i])
        if cos_i > ZERO:
            total += seen / (seen + ggx_lambda(alpha2, cos_i))
    return np.float32(total / lattice.shape[1])


@kernel
def _at(i, n):
    return max(np.float32(i) / np.float32(n - 1), _TINY)


@kernel
def _fill_albedo(lattice, cosines, weights, albedo, mean_albedo):
    """Write the first two tables; cosines, weights: a quadrature of 2 cos over 0 ... 1."""
    n = ALBEDO_POINTS
    for x in range(n):
        for y in range(n):
            albedo[y, x] = _albedo(lattice, _at(x, n), _at(y, n))
        for k in range(cosines.shape[0]):
            mean_albedo[x] += weights[k] * _albedo(lattice, _at(x, n), cosines[k])


@kernel
def _fill_blends(lattice, eta2_minus_1, f0, inv_range, dielectric, metal):
    """Write dielectric, here [cos of wo, roughness, ior] (ior from 1 on), and metal."""
    n = BLEND_POINTS
    share = ONE / np.float32(lattice.shape[1])
    for y in range(n):
        for x in range(n):
            row = dielectric[y, x]
            for i in range(lattice.shape[1]):
                u1, u2 = lattice[0, i], lattice[1, i]
                cos_i, cos_h = _facet_cosines(_at(x, n), _at(y, n), u1, u2)
                if cos_i <= ZERO:
                    continue
                for z in range(n - 1):
                    blend = dielectric_blend(cos_h, eta2_minus_1[z], f0[z], inv_range[z])
                    row[z + 1] += blend * share
                s = max(ONE - cos_h, np.float32(1e-12))
                powers = s ** np.float32(40.0 / 7.0) + s ** np.float32(35.0 / 8.0)
                metal[y, x] += HALF * powers * share


@kernel(forceinline=True)
def _cell(x, n):
    """Index and fraction of x in 0 ... 1 on a grid of n points."""
    x = min(max(x, ZERO), ONE) * np.float32(n - 1)
    i = min(int(x), n - 2)
    return i, x - np.float32(i)


@kernel(forceinline=True)
def read_1d(table, x):
    """Linear interpolation; the coordinates of these three are clamped to 0 ... 1."""
    i, t = _cell(x, table.shape[0])
    return table[i] + t * (table[i + 1] - table[i])


@kernel(forceinline=True)
def read_2d(table, y, x):
    """Bilinear interpolation in table[y, x]."""
    j, u = _cell(y, table.shape[0])
    i, t = _cell(x, table.shape[1])
    low = table[j, i] + t * (table[j, i + 1] - table[j, i])
    high = table[j + 1, i] + t * (table[j + 1, i + 1] - table[j + 1, i])
    return low + u * (high - low)


@kernel(forceinline=True)
def read_3d(table, z, y, x):
    """Trilinear interpolation in table[z, y, x]."""
    k, v = _cell(z, table.shape[0])
    j, u = _cell(y, table.shape[1])
    i, t = _cell(x, table.shape[2])
    total = ZERO
    for c in range(2):
        low = table[k + c, j, i] + t * (table[k + c, j, i + 1] - table[k + c, j, i])
        high = table[k + c, j + 1, i] + t * (table[k + c, j + 1, i + 1] - table[k + c, j + 1, i])
        total += (v if c else ONE - v) * (low + u * (high - low))
    return total

"""Light x BSDF at one shading point, over the whole sphere of world directions.

[Huang07, section 2] multiplies two Haar series. Here both factors are held by their scaling
coefficients at one level (32^2 cells for wide BSDFs, 64^2 for narrow ones), where the product of
the series is the product of the numbers, and the inverse transform is the sum of four children.
Below it the light goes on down to its last texel (pyramid.LightPyramid). The BSDF is evaluated for
the point's own normal, wo and parameters, so no table is looked up and nothing is rounded to a
grid of normals (docs/decisions/0003-product-without-tables.md).

Cells of a level stand in digit-reversed Morton order: children of cell r of level l are
r + q 4^l, q = 0 ... 3, of level l + 1, so that sums over children are sums of four long vectors.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .lobes import DIFFUSE_LOBE
from .pyramid import LightPyramid, level_offset, luminance, morton_to_row_column
from .sphere_map import square_to_sphere

WIDE_LEVEL, NARROW_LEVEL = 5, 6
# Below this alpha a lobe has structure that 32^2 cells (6.3 degrees) cannot hold.
NARROW_ALPHA = 0.5


class ProductCells(NamedTuple):
    """One level's cells: x, y, z float32 (4^level,), directions; light float32 (4^level,),
    luminance; morton int32 (4^level,), the pyramid's cell of each.
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    light: np.ndarray
    morton: np.ndarray


@kernel
def _fill_cells(averages, level, cells):
    side = 1 << level
    for r in range(side * side):
        morton = 0
        for digit in range(level):  # the coarsest digit of the Morton code is r's lowest
            morton = 4 * morton + ((r >> (2 * digit)) & 3)
        row, column = morton_to_row_column(morton, level)
        dx, dy, dz = square_to_sphere((column + 0.5) / side, (row + 0.5) / side)
        cells.x[r], cells.y[r], cells.z[r] = dx, dy, dz
        cells.light[r] = averages[level_offset(level) + morton]
        cells.morton[r] = morton


def product_cells(pyramid: LightPyramid, level: int) -> ProductCells:
    """The cells of one level of the product with the light that falls in from each."""
    n = 1 << (2 * level)
    cells = ProductCells(*(np.empty(n, np.float32) for _ in range(4)), np.empty(n, np.int32))
    _fill_cells(pyramid.averages, level, cells)
    return cells


@kernel
def choose_level(lobes, p):
    """WIDE_LEVEL or NARROW_LEVEL: what the narrowest lobe of point p needs."""
    if lobes.kind[p] > DIFFUSE_LOBE and lobes.alpha[p] < np.float32(NARROW_ALPHA):
        return NARROW_LEVEL
    return WIDE_LEVEL


@kernel
def _fill_diffuse(lobes, p, cells, n, radius, leaves):
    """leaves = light x albedo x cosine / pi, the cosine averaged over a cell at the horizon.

    A cell whose centre lies just below the horizon still has a lit part: its weight must not be 0.
    """
    nx, ny, nz = lobes.normal[p, 0], lobes.normal[p, 1], lobes.normal[p, 2]
    albedo = luminance(lobes.diffuse[p, 0], lobes.diffuse[p, 1], lobes.diffuse[p, 2])
    albedo *= np.float32(1.0 / math.pi)
    quarter = np.float32(0.25) / radius
    for r in range(n):
        cosine = cells.x[r] * nx + cells.y[r] * ny + cells.z[r] * nz
        lit = max(cosine + radius, np.float32(0.0))
        soft = cosine if cosine > radius else lit * lit * quarter
        leaves[r] = albedo * soft * cells.light[r]


@kernel
def _fresnel_ends(lobes, p):
    """Luminance of the glossy lobes' reflectance along the normal, and at the horizon."""
    head_on, grazing = np.float32(0.0), np.float32(0.0)
    for curve in range(2):
        w, f0 = lobes.weight[p, curve], lobes.f0[p, curve]
        head_on += luminance(w[0] * f0[0], w[1] * f0[1], w[2] * f0[2])
        grazing += luminance(w[0], w[1], w[2])
    return head_on, grazing


@kernel
def _add_microfacet(lobes, p, cells, n, radius, leaves):
    """leaves += light x GGX lobe, widened to what a cell can hold (Smith shadowing, Schlick F)."""
    one, half, tiny = np.float32(1.0), np.float32(0.5), np.float32(1e-6)
    normal = lobes.glossy_normal
    nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
    ox, oy, oz = lobes.wo[p, 0], lobes.wo[p, 1], lobes.wo[p, 2]
    head_on, grazing = _fresnel_ends(lobes, p)
    # Half a cell in wi is a quarter of it in the half vector.
    alpha2 = lobes.alpha[p] * lobes.alpha[p] + half * half * radius * radius
    no = max(nx * ox + ny * oy + nz * oz, np.float32(1e-3))
    lambda_o = np.sqrt(alpha2 + (one - alpha2) * no * no)
    quarter = np.float32(0.25) / radius
    scale = alpha2 * np.float32(0.5 / math.pi)
    for r in range(n):
        cosine = cells.x[r] * nx + cells.y[r] * ny + cells.z[r] * nz
        lit = max(cosine + radius, np.float32(0.0))
        ni = cosine if cosine > radius else lit * lit * quarter
        io = cells.x[r] * ox + cells.y[r] * oy + cells.z[r] * oz
        inverse_h2 = half / (one + io + tiny)
        nh = max(cosine + no, np.float32(0.0))
        d = nh * nh * inverse_h2 * (alpha2 - one) + one
        miss = one - np.sqrt(max(half * (one + io), np.float32(0.0)))
        miss2 = miss * miss
        fresnel = head_on + (grazing - head_on) * miss2 * miss2 * miss
        smith = no * np.sqrt(alpha2 + (one - alpha2) * ni * ni) + ni * lambda_o + tiny
        leaves[r] += fresnel * scale * ni / (d * d * smith) * cells.light[r]


@kernel
def build_product(lobes, p, level, cells, tree):
    """Write the product of point p as sums over quadtree cells, all levels in one array.

    tree: float32, at least level_offset(level + 1); the sum of all cells is tree[0]
    """
    n = 1 << (2 * level)
    radius = np.float32(math.sqrt(4.0 / n))  # of a disc of a cell's solid angle
    begin = level_offset(level)
    leaves = tree[begin : begin + n]
    _fill_diffuse(lobes, p, cells, n, radius, leaves)
    if lobes.kind[p] > DIFFUSE_LOBE:
        _add_microfacet(lobes, p, cells, n, radius, leaves)
    for up in range(level - 1, -1, -1):
        m = 1 << (2 * up)
        here, below = level_offset(up), level_offset(up + 1)
        for r in range(m):
            tree[here + r] = (
                tree[below + r]
                + tree[below + m + r]
                + tree[below + 2 * m + r]
                + tree[below + 3 * m + r]
            )


@kernel(forceinline=True)
def pdf_product(products, tree, level, averages, levels, square_x, square_y):
    """The density, sr^-1, that warp.warp_lanes gives the direction at a point of the square.

    products[tree]: where the point's product begins
    """
    side = 1 << levels
    column = min(int(square_x * side), side - 1)
    row = min(int(square_y * side), side - 1)
    cell = 0
    for bit in range(levels):
        cell |= ((column >> bit) & 1) << (2 * bit)
        cell |= ((row >> bit) & 1) << (2 * bit + 1)
    leaf = cell >> (2 * (levels - level))
    r = 0
    for _ in range(level):
        r = 4 * r + (leaf & 3)
        leaf >>= 2
    leaf = cell >> (2 * (levels - level))
    leaf_light = np.float64(averages[level_offset(level) + leaf])
    if leaf_light <= 0.0:
        return 0.0
    share = np.float64(products[tree + level_offset(level) + r]) / np.float64(products[tree])
    light = np.float64(averages[level_offset(levels) + cell])
    return share * (light / leaf_light) * (1 << (2 * level)) / (4.0 * math.pi)

"""The product of light and BRDF at a tile's points, by the paper's tables [Huang07, section 2].

I_s is interpolated between the 4 nearest normals and the 4 nearest outgoing directions of each (16
product integrals); the nearest of both alone shows the grid of normals as facets. The trees that
samples go down are those of the nearest slices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import MEASURED_LOBE
from ..bsdf.luminance import luminance
from ..data.channels import LUMINANCE_B, LUMINANCE_G, LUMINANCE_R
from ..unit_square.sphere_map import hemisphere_to_square, sphere_to_square
from ..wavelets.haar_product import MAX_COMMON, build_product_tree, count_common, product_integral
from .paper_tables import N_PARTS
from .tables import SIDE

_TWO_PI = np.float32(2.0 * np.pi)


class Products(NamedTuple):
    """The products of a tile's points.

    light_slice: int32 (n,); brdf_slice: int32 (n, N_PARTS), -1 for parts that are not sampled
    colors: float32 (n, N_PARTS, 3), factor of each part; root: int32 (n, N_PARTS), codes
    share: float32 (n, N_PARTS), how often a part is chosen, adds up to 1 (or 0 where it is dark)
    diffuse, glossy: float32 (n, 3), I_s by lobe
    """

    light_slice: np.ndarray
    brdf_slice: np.ndarray
    colors: np.ndarray
    root: np.ndarray
    share: np.ndarray
    diffuse: np.ndarray
    glossy: np.ndarray


class IntegralScratch(NamedTuple):
    """Room for a point: stack int32 (2, MAX_COMMON); total float32 (N_PARTS, 3), integral (3,)."""

    stack: np.ndarray
    total: np.ndarray
    integral: np.ndarray


def new_integral_scratch() -> IntegralScratch:
    """Scratch of integrate_products."""
    return IntegralScratch(
        np.empty((2, MAX_COMMON), np.int32),
        np.empty((N_PARTS, 3), np.float32),
        np.empty(3, np.float32),
    )


@kernel
def _part_colors(lobes, p, colors):
    """The colours (N_PARTS, 3) that the slices of point p are weighed with; see Lobes."""
    for c in range(3):
        dielectric, metal = lobes.weight[p, 0, c], lobes.weight[p, 1, c]
        f0_dielectric, f0_metal = lobes.f0[p, 0, c], lobes.f0[p, 1, c]
        if lobes.kind[p] & MEASURED_LOBE:  # one part, whose table has its colours
            colors[1, c] = lobes.tint[p, c]
            continue
        colors[0, c] = lobes.diffuse[p, c]
        colors[1, c] = dielectric * f0_dielectric + metal * f0_metal
        colors[2, c] = dielectric * (np.float32(1.0) - f0_dielectric)
        colors[3, c] = metal * (np.float32(1.0) - f0_metal)
        colors[4, c] = -metal * lobes.edge[p, c]


@kernel
def _cell_of(row, column):
    """The slice of a grid cell that may lie one beyond the octahedral square's edge."""
    if column < 0:
        column, row = -1 - column, SIDE - 1 - row
    elif column >= SIDE:
        column, row = 2 * SIDE - 1 - column, SIDE - 1 - row
    if row < 0:
        row, column = -1 - row, SIDE - 1 - column
    elif row >= SIDE:
        row, column = 2 * SIDE - 1 - row, SIDE - 1 - column
    return row * SIDE + column


@kernel
def _local_wo(frame, wo):
    """wo in a slice's frame, lifted to its horizon."""
    x = frame[0, 0] * wo[0] + frame[0, 1] * wo[1] + frame[0, 2] * wo[2]
    y = frame[1, 0] * wo[0] + frame[1, 1] * wo[1] + frame[1, 2] * wo[2]
    z = frame[2, 0] * wo[0] + frame[2, 1] * wo[1] + frame[2, 2] * wo[2]
    z = max(z, np.float32(1e-3))
    scale = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
    return hemisphere_to_square(np.float64(x * scale), np.float64(y * scale), np.float64(z * scale))


@kernel
def _add_integrals(tables, first, light_slice, wo, weight, scratch):
    """Add weight x (product integral of each part) for one slice of light, wo interpolated."""
    u, v = _local_wo(tables.frames[light_slice], wo)
    x, y = u * SIDE - 0.5, v * SIDE - 0.5
    column, row = int(np.floor(x)), int(np.floor(y))
    fx, fy = np.float32(x - column), np.float32(y - row)
    one = np.float32(1.0)
    integral = scratch.integral
    for part in range(N_PARTS):
        if first[part] < 0:
            continue
        for corner in range(4 if part > 0 else 1):
            share, slice_index = weight, first[part]
            if part > 0:
                i = min(max(row + (corner >> 1), 0), SIDE - 1)
                j = min(max(column + (corner & 1), 0), SIDE - 1)
                slice_index += i * SIDE + j
                share *= (fy if corner >> 1 else one - fy) * (fx if corner & 1 else one - fx)
            integral[:] = 0.0
            product_integral(
                tables.light, light_slice, tables.brdf, slice_index, scratch.stack, integral
            )
            for c in range(3):
                scratch.total[part, c] += share * integral[c]


@kernel
def integrate_products(tables, rows, lobes, scratch, products):
    """Fill everything of ``products`` but the roots."""
    total = scratch.total
    one = np.float32(1.0)
    for p in range(len(rows)):
        first = tables.first_slice[rows[p]]
        normal, wo = lobes.normal[p], lobes.wo[p]
        _part_colors(lobes, p, products.colors[p])
        u, v = sphere_to_square(np.float64(normal[0]), np.float64(normal[1]), np.float64(normal[2]))
        x, y = u * SIDE - 0.5, v * SIDE - 0.5
        column, row = int(np.floor(x)), int(np.floor(y))
        fx, fy = np.float32(x - column), np.float32(y - row)
        total[:] = 0.0
        for corner in range(4):
            share = (fy if corner >> 1 else one - fy) * (fx if corner & 1 else one - fx)
            cell = _cell_of(row + (corner >> 1), column + (corner & 1))
            _add_integrals(tables, first, cell, wo, share, scratch)
        nearest = _cell_of(int(np.floor(y + 0.5)), int(np.floor(x + 0.5)))
        products.light_slice[p] = nearest
        u, v = _local_wo(tables.frames[nearest], wo)
        wo_cell = min(int(v * SIDE), SIDE - 1) * SIDE + min(int(u * SIDE), SIDE - 1)
        _set_shares(first, wo_cell, total, p, products)


@kernel
def _set_shares(first, wo_cell, total, p, products):
    """I_s by lobe, and how often each part is sampled."""
    zero, sum_of_shares = np.float32(0.0), np.float32(0.0)
    for part in range(N_PARTS):
        products.brdf_slice[p, part], products.share[p, part] = -1, zero
        if first[part] < 0:
            continue
        color = products.colors[p, part]
        for c in range(3):
            light = _TWO_PI * color[c] * total[part, c]
            if part == 0:
                products.diffuse[p, c] += light
            else:
                products.glossy[p, c] += light
        share = luminance(
            color[0] * total[part, 0], color[1] * total[part, 1], color[2] * total[part, 2]
        )
        if share > zero:
            products.brdf_slice[p, part] = first[part] + (wo_cell if part > 0 else 0)
            products.share[p, part] = share
            sum_of_shares += share
    for c in range(3):
        products.diffuse[p, c] = max(products.diffuse[p, c], zero)
        products.glossy[p, c] = max(products.glossy[p, c], zero)
    if sum_of_shares > zero:
        for part in range(N_PARTS):
            products.share[p, part] /= sum_of_shares


@kernel
def count_nodes(tables, products, scratch):
    """How many product nodes all points need."""
    total = 0
    for p in range(len(products.light_slice)):
        for part in range(N_PARTS):
            if products.brdf_slice[p, part] >= 0:
                total += count_common(
                    tables.light,
                    products.light_slice[p],
                    tables.brdf,
                    products.brdf_slice[p, part],
                    scratch,
                )
    return total


@kernel
def light_weights(color, weights):
    weights[0] = np.float32(LUMINANCE_R) * color[0]
    weights[1] = np.float32(LUMINANCE_G) * color[1]
    weights[2] = np.float32(LUMINANCE_B) * color[2]


@kernel
def build_trees(tables, products, scratch, weights, trees):
    end = 0
    for p in range(len(products.light_slice)):
        for part in range(N_PARTS):
            if products.brdf_slice[p, part] >= 0:
                light_weights(products.colors[p, part], weights)
                products.root[p, part], end = build_product_tree(
                    tables.light,
                    products.light_slice[p],
                    tables.brdf,
                    products.brdf_slice[p, part],
                    weights,
                    scratch,
                    trees,
                    end,
                )

"""Light x BSDF at one shading point, over the whole sphere of world directions: how it is kept.

[Huang07, section 2] multiplies two Haar series. Here both factors are held by their scaling
coefficients at one level (32^2 cells), where the product of the series is the product of the
numbers, and the inverse transform is the sum of four children. The BSDF is evaluated for the
point's own normal, wo and parameters, so no table is looked up and nothing is rounded to a grid of
normals (docs/decisions/0003-product-without-tables.md).

Cells in which a glossy lobe is steep are cut into blocks of 4 x 4, and cells of those once more:
128^2 and 512^2 cells to the sphere, where they count (docs/decisions/0010-narrow-lobes.md).
product_build.py fills it, warp.py leads points through it and on into the light's last texel.

Cells stand in Morton order, as the light's do: children of cell k are 4 k ... 4 k + 3. Groups of 16
cells of the base that lie below a lobe's horizon are left out together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..light.pyramid import LightPyramid, eval_leaf, level_offset, morton_to_row_column
from ..unit_square.sphere_map import CELL_REACH, square_to_sphere

BASE_LEVEL, BLOCK_LEVELS = 5, 2
SECOND_LEVEL, DEEPEST_LEVEL = BASE_LEVEL + BLOCK_LEVELS, BASE_LEVEL + 2 * BLOCK_LEVELS
BASE_CELLS = 1 << (2 * BASE_LEVEL)
GROUP = 16  # cells of the base
BLOCK_CELLS = 1 << (2 * BLOCK_LEVELS)
BASE_BEGIN = level_offset(BASE_LEVEL)
MAX_BLOCKS = 48  # of a point
# A tree: the base with all its levels, then the cells of all blocks, then the sums of four of them.
BLOCK_BEGIN = BASE_BEGIN + BASE_CELLS
SUMS_BEGIN = BLOCK_BEGIN + BLOCK_CELLS * MAX_BLOCKS
_TREE_SIZE = SUMS_BEGIN + 4 * MAX_BLOCKS
_LINKS_SIZE = BASE_CELLS + BLOCK_CELLS * MAX_BLOCKS


class CellDirections(NamedTuple):
    """Unit vectors at the centres of all cells of a level, Morton order: float32 (4^level,)."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


class ProductCells(NamedTuple):
    """The base's cells: x, y, z float32 (4^BASE_LEVEL,), directions; light float32, luminance.

    groups: float32 (n / 16, 4), a cone around each 16 of them: axis, and the cosine to it below
        which a normal has all of the cone under its horizon
    second, third: the levels of the blocks
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    light: np.ndarray
    groups: np.ndarray
    second: CellDirections
    third: CellDirections


class Products(NamedTuple):
    """The products of n points.

    trees: float32 (n, size), sums of light x BSDF x cosine over cells, in units of a base cell's
        solid angle; trees[p, 0] is the sum of all. Numbers of a block count by their share of it:
        what scales the base leaves them alone
    links: int16 (n, cells), 1 + the block that a cell is cut into, 0 = none: of the base's cells,
        then of the blocks'
    own: int32 (n,), the row of trees and links that a point uses: its own, or that of a point
        that is alike (like_products.py)
    blocks: int32 (n,), how many blocks there are; links of a point without are not set
    follow: float32 (n,), the part of the light that the product leaves to the narrowest lobe
    """

    trees: np.ndarray
    links: np.ndarray
    own: np.ndarray
    blocks: np.ndarray
    follow: np.ndarray


def new_products(n: int, glossy: bool) -> Products:
    """Room for n points; without ``glossy`` for Lambert lobes only."""
    return Products(
        np.empty((n, _TREE_SIZE if glossy else BLOCK_BEGIN), np.float32),
        np.empty((n, _LINKS_SIZE if glossy else 0), np.int16),
        np.zeros(n, np.int32),
        np.zeros(n, np.int32),
        np.zeros(n, np.float32),
    )


@kernel
def _fill_directions(level, directions):
    side = 1 << level
    for k in range(side * side):
        row, column = morton_to_row_column(k)
        dx, dy, dz = square_to_sphere((column + 0.5) / side, (row + 0.5) / side)
        directions.x[k], directions.y[k], directions.z[k] = dx, dy, dz


def product_cells(pyramid: LightPyramid) -> ProductCells:
    """The cells of all products, with the light that falls in from each of the base's."""
    levels = []
    for level in (SECOND_LEVEL, DEEPEST_LEVEL):
        directions = CellDirections(*(np.empty(1 << (2 * level), np.float32) for _ in range(3)))
        _fill_directions(level, directions)
        levels.append(directions)
    base = CellDirections(*(np.empty(BASE_CELLS, np.float32) for _ in range(3)))
    _fill_directions(BASE_LEVEL, base)
    light = pyramid.averages[BASE_BEGIN : BASE_BEGIN + BASE_CELLS].copy()
    return ProductCells(*base, light, _cones(np.stack(base, -1)), *levels)


def _cones(directions: np.ndarray) -> np.ndarray:
    """ProductCells.groups. directions: of the base's cells, float32 (n, 3)"""
    groups = directions.reshape(-1, GROUP, 3).astype(np.float64)
    axes = groups.mean(1)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    widest = np.arccos(np.clip((groups * axes[:, None]).sum(-1).min(1), -1.0, 1.0))
    # A cell has light while its centre is less than that below the horizon (lobe_cells.py).
    under = np.arccos(-CELL_REACH * 2.0 / (1 << BASE_LEVEL))
    below = np.where(under + widest < np.pi, np.cos(np.minimum(under + widest, np.pi)), -2.0)
    return np.concatenate([axes, below[:, None] - 1e-5], 1).astype(np.float32)


@kernel(forceinline=True)
def _product_cell(products, p, cell, levels):
    """(value in units of a base cell, level) of the product's last cell around a cell of levels."""
    r = cell >> (2 * (levels - BASE_LEVEL))
    own = products.own[p]
    tree, links = products.trees[own], products.links[own]
    value, level = np.float64(tree[BASE_BEGIN + r]), BASE_LEVEL
    if products.blocks[p] > 0:
        block = links[r]
        while block > 0:
            level += BLOCK_LEVELS
            inside = (cell >> (2 * (levels - level))) & (BLOCK_CELLS - 1)
            k = BLOCK_CELLS * (block - 1) + inside
            s = SUMS_BEGIN + 4 * (block - 1)
            whole = np.float64((tree[s] + tree[s + 1]) + (tree[s + 2] + tree[s + 3]))
            value *= BLOCK_CELLS * np.float64(tree[BLOCK_BEGIN + k]) / whole
            block = links[BASE_CELLS + k]
    return value, level


@kernel(forceinline=True)
def pdf_product(products, p, light, square_x, square_y):
    """The density, sr^-1, that warp.py gives the direction at a point of the square."""
    radiance, cell = eval_leaf(light, square_x, square_y)
    value, level = _product_cell(products, p, cell, light.levels)
    above = level_offset(level) + (cell >> (2 * (light.levels - level)))
    around = np.float64(light.averages[above])
    if around <= 0.0:
        return 0.0
    scale = BASE_CELLS / (4.0 * math.pi * np.float64(products.trees[products.own[p], 0]))
    return value * scale * (radiance / around)

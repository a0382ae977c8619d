"""The light as a quadtree over the sphere: what points descend through below the product's leaves.

Nodes are averages of luminance over cells of the equal-area octahedral square (sphere_map), 4 pi /
4^l steradians at level l. Levels 0 ... ``levels`` are whole: 4^l cells in Morton order, one level
after another; children of cell k of a level are 4 k ... 4 k + 3 of the next: top left, top right,
bottom left, bottom right. Below them the tree goes on only where the light asks for it
(light_tree.py): four children stand side by side, ``children`` says where.

The averages are the scaling coefficients of the map's Haar series.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..unit_square.sphere_map import sphere_to_square

WHOLE_LEVELS = 9  # 512^2 cells; the product's deepest level must be one of them


class LightPyramid(NamedTuple):
    """averages: float32 (nodes,), W sr^-1 m^-2; levels: the finest level that is whole;
    children: int32 (nodes,), first of a node's four children, 0: none. Only level ``levels`` and
    what is below it is asked for children; deepest: the level of the smallest cells, at most 15
    """

    averages: np.ndarray
    levels: int
    children: np.ndarray
    deepest: int


@kernel(forceinline=True)
def level_offset(level):
    """Where a level begins in the array of all levels: (4^level - 1) / 3."""
    return ((1 << (2 * level)) - 1) // 3


@kernel(forceinline=True)
def _every_other_bit(index):
    """Bits 0, 2, 4 ... 30 as bits 0, 1, 2 ...: five steps, each closes gaps twice as wide."""
    u = np.uint32
    x = u(u(index) & u(0x55555555))
    x = u(u(x | u(x >> u(1))) & u(0x33333333))
    x = u(u(x | u(x >> u(2))) & u(0x0F0F0F0F))
    x = u(u(x | u(x >> u(4))) & u(0x00FF00FF))
    return np.int32(u(u(x | u(x >> u(8))) & u(0x0000FFFF)))


@kernel(forceinline=True)
def morton_to_row_column(index):
    """(row, column) of a cell, whatever its level, up to 15."""
    return _every_other_bit(np.uint32(index) >> np.uint32(1)), _every_other_bit(index)


@kernel(forceinline=True)
def row_column_to_morton(row, column, level):
    """The cell of a level; inverse of morton_to_row_column."""
    index = 0
    for bit in range(level):
        index |= ((column >> bit) & 1) << (2 * bit)
        index |= ((row >> bit) & 1) << (2 * bit + 1)
    return index


@kernel(forceinline=True)
def spread_bits(bits):
    """Put a zero between the bits of an int32 below 2^16."""
    bits = (bits | (bits << np.int32(8))) & np.int32(0x00FF00FF)
    bits = (bits | (bits << np.int32(4))) & np.int32(0x0F0F0F0F)
    bits = (bits | (bits << np.int32(2))) & np.int32(0x33333333)
    return (bits | (bits << np.int32(1))) & np.int32(0x55555555)


@kernel(forceinline=True)
def cell_beside(row, column, side):
    """The cell at (row, column), int32, of side x side, which may lie one beyond their border."""
    if column < 0 or column >= side:
        row, column = side - 1 - row, min(max(column, 0), side - 1)
    if row < 0 or row >= side:
        row, column = min(max(row, 0), side - 1), side - 1 - column
    return spread_bits(np.int32(column)) | (spread_bits(np.int32(row)) << np.int32(1))


@kernel(forceinline=True)
def eval_leaf(pyramid, x, y):
    """(average of the leaf at a point of the square, Morton index of its cell of level levels)."""
    averages, levels, children = pyramid.averages, pyramid.levels, pyramid.children
    side = 1 << levels
    x, y = x * side, y * side
    column, row = min(int(x), side - 1), min(int(y), side - 1)
    x, y = x - column, y - row
    cell = row_column_to_morton(row, column, levels)
    node = level_offset(levels) + cell
    while children[node] > 0:
        x, y = x + x, y + y
        right, below = np.int64(x >= 1.0), np.int64(y >= 1.0)
        x, y = x - right, y - below
        node = children[node] + 2 * below + right
    return np.float64(averages[node]), cell


@kernel
def pdf_light(pyramid, dx, dy, dz):
    """The density, sr^-1, of directions chosen in proportion to the light alone."""
    x, y = sphere_to_square(dx, dy, dz)
    light, _ = eval_leaf(pyramid, x, y)
    return light / (4.0 * np.pi * np.float64(pyramid.averages[0]))

"""The light as a quadtree over the sphere: what points descend through below the product's leaves.

The whole map, at its own resolution, as averages of luminance over the cells of the equal-area
octahedral square (sphere_map): level l has 4^l cells of 4 pi / 4^l steradians, in Morton order, all
levels in one array. Children of cell k of a level are 4 k ... 4 k + 3 of the next: top left,
top right, bottom left, bottom right.

The averages are the scaling coefficients of the map's Haar series with nothing left out.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .environment import EnvironmentLookup, eval_environment
from .sphere_map import sphere_to_square, square_to_sphere

LUMINANCE_R, LUMINANCE_G, LUMINANCE_B = 0.2126, 0.7152, 0.0722  # Rec.709
MIN_LEVELS, MAX_LEVELS = 7, 12  # 128^2 ... 4096^2 cells
# A texel's light reaches one texel beyond it (bilinear filter), so no cell that touches light may
# have density zero: this part of a cell's brightest sample is its floor.
_FLOOR = 1e-3


class LightPyramid(NamedTuple):
    """averages: float32 (level_offset(levels + 1),), W sr^-1 m^-2; levels: the finest one."""

    averages: np.ndarray
    levels: int


@kernel(forceinline=True)
def level_offset(level):
    """Where a level begins in the array of all levels: (4^level - 1) / 3."""
    return ((1 << (2 * level)) - 1) // 3


@kernel(forceinline=True)
def morton_to_row_column(index, level):
    """(row, column) of a cell of a level."""
    row, column = 0, 0
    for bit in range(level):
        column |= ((index >> (2 * bit)) & 1) << bit
        row |= ((index >> (2 * bit + 1)) & 1) << bit
    return row, column


@kernel(forceinline=True)
def row_column_to_morton(row, column, level):
    """The cell of a level; inverse of morton_to_row_column."""
    index = 0
    for bit in range(level):
        index |= ((column >> bit) & 1) << (2 * bit)
        index |= ((row >> bit) & 1) << (2 * bit + 1)
    return index


@kernel(forceinline=True)
def luminance(r, g, b):
    """Rec.709 luminance, float32."""
    return np.float32(LUMINANCE_R) * r + np.float32(LUMINANCE_G) * g + np.float32(LUMINANCE_B) * b


@kernel
def pdf_light(averages, levels, dx, dy, dz):
    """The density, sr^-1, of directions chosen in proportion to the light alone."""
    side = 1 << levels
    x, y = sphere_to_square(dx, dy, dz)
    column, row = min(int(x * side), side - 1), min(int(y * side), side - 1)
    cell = row_column_to_morton(row, column, levels)
    light = np.float64(averages[level_offset(levels) + cell])
    return light / (4.0 * np.pi * np.float64(averages[0]))


@kernel
def _fill_leaves(lookup, level, first, last, per_side, leaves):
    """Average the light over the cells first ... last - 1: corners and centres of per_side^2 parts.

    Corners see light that reaches just into a cell; a cell that missed the rim of a sun had next to
    no density there, and 1 to 3 % of the sun's light came in a few far too bright samples.
    """
    side, n = 1 << level, 2 * per_side  # points stand half a part apart; row + column even: in use
    scale = np.float32(0.5 / (per_side * per_side))
    for index in range(first, last):
        row, column = morton_to_row_column(index, level)
        total, brightest = np.float32(0.0), np.float32(0.0)
        for i in range(n + 1):
            for j in range(i % 2, n + 1, 2):
                x, y = (column + j / n) / side, (row + i / n) / side
                dx, dy, dz = square_to_sphere(x, y)
                r, g, b = eval_environment(lookup, np.float32(dx), np.float32(dy), np.float32(dz))
                value = luminance(r, g, b)
                inside = (0.5 if i % n == 0 else 1.0) * (0.5 if j % n == 0 else 1.0)
                total += np.float32(inside) * value
                brightest = max(brightest, value)
        leaves[index] = max(total * scale, np.float32(_FLOOR) * brightest)


@kernel
def _sum_up(averages, levels):
    for level in range(levels - 1, -1, -1):
        here, below = level_offset(level), level_offset(level + 1)
        for k in range(1 << (2 * level)):
            child = below + 4 * k
            averages[here + k] = np.float32(0.25) * (
                averages[child] + averages[child + 1] + averages[child + 2] + averages[child + 3]
            )


def levels_for(height: int, width: int) -> int:
    """The finest level for a map: cells of a fraction of a texel, a texel for large maps.

    Light varies inside a texel (bilinear filter) and the density inside a cell does not: with cells
    of .8 of a texel in width, weights vary by 57 % on the paper's 256x128 probe, with .2 by 21 %.
    """
    base = int(np.ceil(0.5 * np.log2(width * height)))  # a cell for each texel at the equator
    levels = max(base, min(base + 1, 11), min(base + 2, 10))
    return int(np.clip(levels, MIN_LEVELS, MAX_LEVELS))


def build_pyramid(lookup: EnvironmentLookup, threads: int, cancelled=lambda: False) -> LightPyramid:
    """The light of all directions as a quadtree; ``cancelled`` is asked between chunks."""
    height, width = lookup.texels.shape[:2]
    levels = levels_for(height, width)
    averages = np.empty(level_offset(levels + 1), np.float32)
    leaves = averages[level_offset(levels) :]
    # One part a cell: it is smaller than a texel of the equator, unless MAX_LEVELS forbids.
    per_side = 1 if levels < MAX_LEVELS else max(1, round(width / (1 << levels)))
    chunk = max(1 << 14, len(leaves) // 256)

    def fill(first):
        if not cancelled():
            _fill_leaves(lookup, levels, first, min(first + chunk, len(leaves)), per_side, leaves)

    with ThreadPoolExecutor(max(1, threads)) as pool:
        list(pool.map(fill, range(0, len(leaves), chunk)))
    _sum_up(averages, levels)
    return LightPyramid(averages, levels)

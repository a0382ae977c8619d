"""The hierarchical warp of many points side by side [Clarberg05], from the root to the last texel.

Points of several pixels stand in lanes: a step of the descent is a gather of each lane's four
children, then the same arithmetic in all lanes, which compiles to vector instructions (1 ns a step
and lane, where a point alone takes 8).
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..light.environment import fetch_texels, map_coordinates
from ..light.light_leaves import choose_leaf, fetch_cell, fetch_leaf
from ..light.pyramid import level_offset, morton_to_row_column
from ..machine.addresses import get_float
from ..machine.lanes import DX, DY, DZ, PDF, A, B, C, D, U, V, X, Y
from .product import (
    BASE_BEGIN,
    BASE_CELLS,
    BASE_LEVEL,
    BLOCK_BEGIN,
    BLOCK_CELLS,
    BLOCK_LEVELS,
    DEEPEST_LEVEL,
    SUMS_BEGIN,
)

_ZERO, _HALF, _ONE, _TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
_BELOW_ONE = np.float32(1.0 - 2.0**-24)
_QUARTER_PI, _SQRT_HALF = np.float32(0.25 * math.pi), np.float32(math.sqrt(0.5))
_TINY = np.float32(1e-30)


@kernel
def _choose_children(numbers, quadrant, n):
    """One step of the warp in every lane, split by rows first: quadrant and what is left of x, y.

    A side without weight is never taken, whatever x and y were rounded to.
    """
    for s in range(n):
        a, b, c, d = numbers[A + s], numbers[B + s], numbers[C + s], numbers[D + s]
        top, bottom = a + b, c + d
        y = numbers[Y + s] * (top + bottom)
        low = (y >= top) & (bottom > _ZERO)
        y = y - top if low else y
        row = bottom if low else top
        left = c if low else a
        right = d if low else b
        x = numbers[X + s] * row
        far = (x >= left) & (right > _ZERO)
        x = x - left if far else x
        cell = right if far else left
        numbers[X + s] = min(x / cell, _BELOW_ONE)
        numbers[Y + s] = min(y / row, _BELOW_ONE)
        quadrant[s] = np.int32((2 if low else 0) + (1 if far else 0))


@kernel
def _descend_bases(trees, lanes, n):
    """From the root of each lane's product to a leaf of its base: cell, base; PDF: its value."""
    numbers, cell, tree = lanes.numbers, lanes.cell, lanes.tree
    for s in range(n):
        cell[s] = 0
    for step in range(BASE_LEVEL):
        begin = level_offset(step + 1)
        for s in range(n):
            child = tree[s] + (begin + 4 * cell[s])
            numbers[A + s], numbers[B + s] = trees[child], trees[child + 1]
            numbers[C + s], numbers[D + s] = trees[child + 2], trees[child + 3]
        _choose_children(numbers, lanes.quadrant, n)
        for s in range(n):
            cell[s] = 4 * cell[s] + lanes.quadrant[s]
    for s in range(n):
        lanes.base[s] = cell[s]
        numbers[PDF + s] = trees[tree[s] + (BASE_BEGIN + cell[s])]


@kernel
def _step_to(level, begin, trees, light, lanes, n):
    """One step to ``level``: in its block's numbers from ``begin`` on, else by light.

    begin: of four sums for each block, or of four times four cells
    By addresses, as which of two arrays it is cannot be foretold: a branch costs 5 ns a lane.
    """
    numbers, cell = lanes.numbers, lanes.cell
    stride, inside = (4, 0) if begin == SUMS_BEGIN else (BLOCK_CELLS, BLOCK_CELLS - 1)
    blocks = trees.ctypes.data + 4 * (begin - stride)  # block 0 is none
    averages = light.averages.ctypes.data + 4 * level_offset(level)
    for s in range(n):
        block, k = np.int64(lanes.block[s]), 4 * np.int64(cell[s])
        by_block = blocks + 4 * (lanes.tree[s] + stride * block + (k & inside))
        place = by_block if block > 0 else averages + 4 * k
        numbers[A + s], numbers[B + s] = get_float(place), get_float(place + 4)
        numbers[C + s], numbers[D + s] = get_float(place + 8), get_float(place + 12)
    _choose_children(numbers, lanes.quadrant, n)
    for s in range(n):
        cell[s] = 4 * cell[s] + lanes.quadrant[s]


@kernel
def _descend_blocks(products, light, lanes, n):
    """From the base to DEEPEST_LEVEL: down the blocks, and by light beside and below them.

    PDF: where a lane is in a block, times what its cell has of the block, over what all cells have
    alike: a guide scales the base alone. U: the light around the last such cell
    """
    numbers, links, trees = lanes.numbers, products.links.reshape(-1), products.trees.reshape(-1)
    stride = products.links.shape[1]
    for s in range(n):
        lanes.block[s] = links[np.int64(lanes.product[s]) * stride + lanes.base[s]]
    level = np.int64(BASE_LEVEL)
    while level < DEEPEST_LEVEL:
        _step_to(level + 1, SUMS_BEGIN, trees, light, lanes, n)
        for s in range(n):
            numbers[V + s] = (numbers[A + s] + numbers[B + s]) + (numbers[C + s] + numbers[D + s])
        _step_to(level + 2, BLOCK_BEGIN, trees, light, lanes, n)
        level += BLOCK_LEVELS
        around = level_offset(level)
        for s in range(n):
            block, cell = np.int64(lanes.block[s]), np.int64(lanes.cell[s])
            inside = block > 0  # if not, what is worked out means nothing
            k = BLOCK_CELLS * max(block - 1, 0) + (cell & (BLOCK_CELLS - 1))
            value = np.float32(BLOCK_CELLS) * trees[lanes.tree[s] + (BLOCK_BEGIN + k)]
            here = light.averages[around + cell]
            link = links[np.int64(lanes.product[s]) * stride + (BASE_CELLS + k)]
            numbers[PDF + s] *= value / numbers[V + s] if inside else _ONE
            numbers[U + s] = here if inside else numbers[U + s]
            lanes.block[s] = link if inside else 0


@kernel
def _descend_light(averages, level, levels, lanes, n):
    """From a cell of ``level`` (Morton order) to one of the light's last whole level."""
    numbers, cell = lanes.numbers, lanes.cell
    for step in range(level, levels):
        begin = level_offset(step + 1)
        for s in range(n):
            child = begin + 4 * np.int64(cell[s])
            numbers[A + s], numbers[B + s] = averages[child], averages[child + 1]
            numbers[C + s], numbers[D + s] = averages[child + 2], averages[child + 3]
        _choose_children(numbers, lanes.quadrant, n)
        for s in range(n):
            cell[s] = 4 * cell[s] + lanes.quadrant[s]


@kernel
def _choose_leaves(light, leaves, lanes, n):
    """From the last whole level to a leaf: X, Y of the whole square, PDF."""
    numbers, cells, levels = lanes.numbers, lanes.cell, light.levels
    begin, inverse = level_offset(levels), np.float32(1.0 / (1 << levels))
    for s in range(n):
        fetch_cell(leaves, cells[s])
    for s in range(n):
        fetch_leaf(leaves, cells[s], numbers[X + s])
    for s in range(n):
        cell = cells[s]
        average = light.averages[begin + np.int64(cell)]
        x, y, average = choose_leaf(leaves, average, cell, numbers[X + s], numbers[Y + s])
        row, column = morton_to_row_column(cell)
        numbers[X + s] = (np.float32(column) + x) * inverse
        numbers[Y + s] = (np.float32(row) + y) * inverse
        numbers[PDF + s] *= average


@kernel
def _square_to_sphere(numbers, n):
    """sphere_map.square_to_sphere in every lane, of the points that _to_square left in X and Y."""
    for s in range(n):
        u, v = _TWO * numbers[X + s] - _ONE, _TWO * numbers[Y + s] - _ONE
        signed = _ONE - (abs(u) + abs(v))
        r = _ONE - abs(signed)
        # phi - pi / 4, in [-pi / 4, pi / 4]
        t = _QUARTER_PI * ((abs(v) - abs(u)) / max(r, _TINY))
        t2 = t * t
        sine = np.float32(2.75573192e-6) * t2 + np.float32(-1.98412698e-4)
        sine = sine * t2 + np.float32(8.33333333e-3)
        sine = (sine * t2 + np.float32(-1.66666667e-1)) * t2 * t + t
        cosine = np.float32(2.48015873e-5) * t2 + np.float32(-1.38888889e-3)
        cosine = cosine * t2 + np.float32(4.16666667e-2)
        cosine = (cosine * t2 - _HALF) * t2 + _ONE
        radius = r * np.sqrt(max(_TWO - r * r, _ZERO)) * _SQRT_HALF
        z = _ONE - r * r
        numbers[DX + s] = math.copysign((cosine - sine) * radius, u)
        numbers[DY + s] = math.copysign((cosine + sine) * radius, v)
        numbers[DZ + s] = math.copysign(z, signed)


@kernel
def warp_lanes(products, cut, light, leaves, lanes, n):
    """Warp the points (X, Y) of lanes 0 ... n - 1 to directions (DX, DY, DZ), with their PDF.

    products: of all points, with lanes.product and lanes.tree: which; their sums must be above 0
    cut: whether these have blocks: all or none; light: the LightPyramid below, and its
    LightLeaves. PDF is in sr^-1.
    """
    numbers, cell = lanes.numbers, lanes.cell
    averages = light.averages
    trees = products.trees.reshape(-1)
    _descend_bases(trees, lanes, n)
    scale = np.float32(BASE_CELLS / (4.0 * math.pi))
    for s in range(n):
        numbers[PDF + s] *= scale / trees[lanes.tree[s]]
        numbers[U + s] = averages[BASE_BEGIN + cell[s]]
    level = BASE_LEVEL
    if cut:
        _descend_blocks(products, light, lanes, n)
        level = DEEPEST_LEVEL
    for s in range(n):
        numbers[PDF + s] /= numbers[U + s]
    _descend_light(averages, level, light.levels, lanes, n)  # whole to DEEPEST_LEVEL at least
    _choose_leaves(light, leaves, lanes, n)
    _square_to_sphere(numbers, n)


@kernel
def fill_map_coordinates(lookup, lanes, n):
    """U, V: where the environment's map holds the light from each lane's direction; ask for it."""
    numbers = lanes.numbers
    for s in range(n):
        numbers[U + s], numbers[V + s] = map_coordinates(
            lookup, numbers[DX + s], numbers[DY + s], numbers[DZ + s]
        )
    for s in range(n):
        fetch_texels(lookup, numbers[U + s], numbers[V + s])

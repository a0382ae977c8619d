"""The hierarchical warp of many points side by side [Clarberg05], from the root to the last texel.

Points of several pixels stand in lanes: a step of the descent is a gather of each lane's four
children, then the same arithmetic in all lanes, which compiles to vector instructions (1 ns a step
and lane, where a point alone takes 8). So that it does, all numbers of the lanes are rows of one
array at distances known to the compiler, in float32 and without branches.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .environment import map_coordinates
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
from .pyramid import level_offset, morton_to_row_column

LANES = 256
# Where the rows of Lanes.numbers begin: the children's weights, what is left of the point, the
# direction, its density, its place in the environment's map.
_A, _B, _C, _D = 0, LANES, 2 * LANES, 3 * LANES
X, Y = 4 * LANES, 5 * LANES
DX, DY, DZ, PDF = 6 * LANES, 7 * LANES, 8 * LANES, 9 * LANES
U, V = 10 * LANES, 11 * LANES
_ROWS = 12

_ZERO, _HALF, _ONE, _TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
_BELOW_ONE = np.float32(1.0 - 2.0**-24)
_QUARTER_PI, _SQRT_HALF = np.float32(0.25 * math.pi), np.float32(math.sqrt(0.5))
_TINY = np.float32(1e-30)
_FEW = 8  # a part of the lanes smaller than this is not worth a step of all


class Lanes(NamedTuple):
    """Room for LANES points on their way down.

    numbers: float32 (rows * LANES,): X, Y, DX ... are where a row begins
    cell, quadrant: int32 (LANES,), where a lane is, and where it goes
    block: int32 (LANES,), 1 + the block of its product that it is in, 0 = none
    node: int32 (LANES,), where it is in the light, below the whole levels
    tree: int64 (LANES,), where the lane's product begins in the array of all products
    point, sample: int32 (LANES,), the caller's: shading point and index of its sample
    """

    numbers: np.ndarray
    cell: np.ndarray
    quadrant: np.ndarray
    block: np.ndarray
    node: np.ndarray
    tree: np.ndarray
    point: np.ndarray
    sample: np.ndarray


def new_lanes() -> Lanes:
    """Lanes with nothing in them."""
    return Lanes(
        np.zeros(_ROWS * LANES, np.float32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.int64),
        np.zeros(LANES, np.int32),
        np.zeros(LANES, np.int32),
    )


@kernel
def _choose_children(numbers, quadrant, n):
    """One step of the warp in every lane, split by rows first: quadrant and what is left of x, y.

    A side without weight is never taken, whatever x and y were rounded to.
    """
    for s in range(n):
        a, b, c, d = numbers[_A + s], numbers[_B + s], numbers[_C + s], numbers[_D + s]
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
def _descend_bases(trees, morton, lanes, n):
    """From the root of each lane's product to a leaf of its base.

    Then cell is the light's cell, block the leaf, PDF the leaf's value.
    """
    numbers, cell, tree = lanes.numbers, lanes.cell, lanes.tree
    for s in range(n):
        cell[s] = 0
    for step in range(BASE_LEVEL):
        m = np.int32(1 << (2 * step))
        begin = level_offset(step + 1)
        for s in range(n):
            child = tree[s] + (begin + cell[s])
            numbers[_A + s], numbers[_B + s] = trees[child], trees[child + m]
            numbers[_C + s], numbers[_D + s] = trees[child + 2 * m], trees[child + 3 * m]
        _choose_children(numbers, lanes.quadrant, n)
        for s in range(n):
            cell[s] += lanes.quadrant[s] * m
    for s in range(n):
        leaf = cell[s]
        lanes.block[s], cell[s] = leaf, morton[leaf]
        numbers[PDF + s] = trees[tree[s] + (BASE_BEGIN + leaf)]


@kernel
def _step_to(level, begin, trees, light, lanes, n):
    """One step to ``level``: in its block's numbers from ``begin`` on, else by light; 1s below it.

    begin: of four sums for each block, or of four times four cells
    """
    numbers, cell, averages = lanes.numbers, lanes.cell, light.averages
    stride, inside = (4, 0) if begin == SUMS_BEGIN else (BLOCK_CELLS, 3)
    first = level_offset(level)
    for s in range(n):
        block = lanes.block[s]
        if block > 0:
            child = lanes.tree[s] + (begin + stride * (block - 1) + 4 * (cell[s] & inside))
            numbers[_A + s], numbers[_B + s] = trees[child], trees[child + 1]
            numbers[_C + s], numbers[_D + s] = trees[child + 2], trees[child + 3]
        elif level <= light.levels:
            child = first + 4 * np.int64(cell[s])
            numbers[_A + s], numbers[_B + s] = averages[child], averages[child + 1]
            numbers[_C + s], numbers[_D + s] = averages[child + 2], averages[child + 3]
        else:
            numbers[_A + s] = numbers[_B + s] = numbers[_C + s] = numbers[_D + s] = _ONE
    _choose_children(numbers, lanes.quadrant, n)
    for s in range(n):
        cell[s] = 4 * cell[s] + lanes.quadrant[s]


@kernel
def _descend_blocks(products, light, scale, lanes, n):
    """From the base to DEEPEST_LEVEL: down the blocks, and by light beside and below them.

    PDF: changed where a lane is in a block; scale: from a base cell's value to a density
    """
    numbers, links, trees = lanes.numbers, products.links.reshape(-1), products.trees.reshape(-1)
    stride = products.links.shape[1]
    for s in range(n):
        lanes.block[s] = links[np.int64(lanes.point[s]) * stride + lanes.block[s]]
    level = BASE_LEVEL
    while level < DEEPEST_LEVEL:
        _step_to(level + 1, SUMS_BEGIN, trees, light, lanes, n)
        _step_to(level + 2, BLOCK_BEGIN, trees, light, lanes, n)
        level += BLOCK_LEVELS
        scale *= np.float32(BLOCK_CELLS)
        deeper = 2 * max(level - light.levels, 0)
        around = level_offset(min(level, light.levels))
        for s in range(n):
            if lanes.block[s] > 0:
                cell = lanes.cell[s]
                k = BLOCK_CELLS * (lanes.block[s] - 1) + (cell & (BLOCK_CELLS - 1))
                value = trees[lanes.tree[s] + (BLOCK_BEGIN + k)] / trees[lanes.tree[s]]
                numbers[PDF + s] = scale * value / light.averages[around + (cell >> deeper)]
                lanes.block[s] = links[np.int64(lanes.point[s]) * stride + (BASE_CELLS + k)]


@kernel
def _descend_light(averages, level, levels, lanes, n):
    """From a cell of ``level`` (Morton order) to one of the light's last whole level."""
    numbers, cell = lanes.numbers, lanes.cell
    for step in range(level, levels):
        begin = level_offset(step + 1)
        for s in range(n):
            child = begin + 4 * np.int64(cell[s])
            numbers[_A + s], numbers[_B + s] = averages[child], averages[child + 1]
            numbers[_C + s], numbers[_D + s] = averages[child + 2], averages[child + 3]
        _choose_children(numbers, lanes.quadrant, n)
        for s in range(n):
            cell[s] = 4 * cell[s] + lanes.quadrant[s]


@kernel
def _descend_alone(light, numbers, s, node):
    """Lane s on from a node to its leaf, which is returned; X and Y stay those of the node."""
    averages, children = light.averages, light.children
    x, y = numbers[X + s], numbers[Y + s]
    column, row, size = _ZERO, _ZERO, _ONE
    while children[node] > 0:
        child, size = children[node], _HALF * size
        top, bottom = (
            averages[child] + averages[child + 1],
            averages[child + 2] + averages[child + 3],
        )
        y *= top + bottom
        if y >= top and bottom > _ZERO:
            y, row, top, child = y - top, row + size, bottom, child + 2
        y = min(y / top, _BELOW_ONE)
        x *= top
        left, right = averages[child], averages[child + 1]
        if x >= left and right > _ZERO:
            x, column, left, child = x - left, column + size, right, child + 1
        x = min(x / left, _BELOW_ONE)
        node = child
    numbers[X + s] = min(column + size * x, _BELOW_ONE)
    numbers[Y + s] = min(row + size * y, _BELOW_ONE)
    return node


@kernel
def _descend_leaves(light, lanes, n):
    """On from the last whole level to the leaves; returns the level that all lanes end at.

    A lane that is in its leaf already goes on evenly, which leaves its point where it is. The last
    few lanes that are not go on alone.
    """
    averages, children = light.averages, light.children
    numbers, cell, node = lanes.numbers, lanes.cell, lanes.node
    begin = np.int32(level_offset(light.levels))
    for s in range(n):
        node[s] = begin + cell[s]
    for level in range(light.levels, light.deepest):
        inside = 0
        for s in range(n):
            child = children[node[s]]
            inside += child > 0
            a, b = averages[child], averages[child + 1]
            c, d = averages[child + 2], averages[child + 3]
            numbers[_A + s] = a if child > 0 else _ONE
            numbers[_B + s] = b if child > 0 else _ONE
            numbers[_C + s] = c if child > 0 else _ONE
            numbers[_D + s] = d if child > 0 else _ONE
        if inside * _FEW < n:
            for s in range(n):
                if children[node[s]] > 0:
                    node[s] = _descend_alone(light, numbers, s, node[s])
            return level
        _choose_children(numbers, lanes.quadrant, n)
        for s in range(n):
            child = children[node[s]]
            node[s] = child + lanes.quadrant[s] if child > 0 else node[s]
            cell[s] = 4 * cell[s] + lanes.quadrant[s]
    return light.deepest


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
def warp_lanes(products, cut, morton, light, lanes, n):
    """Warp the points (X, Y) of lanes 0 ... n - 1 to directions (DX, DY, DZ), with their PDF.

    products: of all points, with lanes.tree and lanes.point: which; their sums must be above 0
    cut: whether these have blocks: all or none; morton: of the ProductCells; light: the
    LightPyramid below. PDF is in sr^-1.
    """
    numbers, cell = lanes.numbers, lanes.cell
    averages = light.averages
    trees = products.trees.reshape(-1)
    _descend_bases(trees, morton, lanes, n)
    scale = np.float32(BASE_CELLS / (4.0 * math.pi))
    for s in range(n):
        numbers[PDF + s] *= scale / (trees[lanes.tree[s]] * averages[BASE_BEGIN + cell[s]])
    level = BASE_LEVEL
    if cut:
        _descend_blocks(products, light, scale, lanes, n)
        level = DEEPEST_LEVEL
    _descend_light(averages, level, light.levels, lanes, n)  # whole to DEEPEST_LEVEL at least
    finest = _descend_leaves(light, lanes, n)
    inverse = np.float32(1.0 / (1 << finest))
    for s in range(n):
        row, column = morton_to_row_column(cell[s], finest)
        numbers[X + s] = (np.float32(column) + numbers[X + s]) * inverse
        numbers[Y + s] = (np.float32(row) + numbers[Y + s]) * inverse
        numbers[PDF + s] *= averages[lanes.node[s]]
    _square_to_sphere(numbers, n)


@kernel
def fill_map_coordinates(lookup, lanes, n):
    """U, V: where the environment's map holds the light from each lane's direction."""
    numbers = lanes.numbers
    for s in range(n):
        numbers[U + s], numbers[V + s] = map_coordinates(
            lookup, numbers[DX + s], numbers[DY + s], numbers[DZ + s]
        )

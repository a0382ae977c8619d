"""Grow the light's quadtree where a sample of it would still be uncertain.

A sample of a leaf has weight L / average, so the light's samples have a relative variance of
    sum over leaves of  (solid angle) (mean square / mean - mean)  /  total light  =  sum of v.
The leaf with the largest v is split next, until their sum is small or the tree is full: a sun's rim
goes down to a fraction of a texel, a smooth sky stays coarse, and the size of the tree does not
follow that of the map.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .cell_lookup import footprint, look_up_cell
from .environment import EnvironmentLookup
from .light_cells import cell_light, sum_up
from .pyramid import WHOLE_LEVELS, LightPyramid, level_offset, morton_to_row_column

MAX_LEVEL = 15
_NODES = 3 << 19
_VARIANCE = 0.1**2  # of the weights, where the tree stops: the product's own is .1 to .3 squared
_PARTS = 16  # of a cell's side, at most, when it is looked up
_BUCKETS, _LOWEST = 160, -60.0  # leaves with v from 2^-60, in steps of sqrt(2)
# A part of a split leaf keeps at least this of its light, and of its mean square, for what samples
# did not see (without, one weight in a million was 1400 at a sun's rim).
_FLOOR, _UNSEEN = np.float32(1.0 / 1024), np.float32(3e-4)
# Of its parent's light, of its brightest sample: a part with less is looked up at nine times the
# points; what a leaf keeps of its brightest sample, so that no weight is much above 8.
_DARK, _STEEP, _RIM = np.float32(1.0 / 64), np.float32(0.25), np.float32(0.125)
_STEPS = 1000  # splits between two calls of progress


class _Growth(NamedTuple):
    """A tree in work. All arrays but ``first`` have a row a node.

    averages, link (children of what is split, else the next leaf of its bucket), variance (v),
    cell (Morton index), level; first: the leaves of each bucket; counts: (nodes, bucket);
    sums: (total light, sum of v)
    """

    averages: np.ndarray
    link: np.ndarray
    variance: np.ndarray
    cell: np.ndarray
    level: np.ndarray
    first: np.ndarray
    counts: np.ndarray
    sums: np.ndarray


@kernel(forceinline=True)
def _put(tree, node, level, cell, mean, square):
    """Write a leaf, and queue it by its part of the variance."""
    tree.averages[node] = mean
    tree.cell[node], tree.level[node] = cell, level
    tree.link[node] = -1
    tree.variance[node] = np.float32(0.0)
    if not mean > np.float32(0.0):
        return
    excess = np.float64(square) / np.float64(mean) - np.float64(mean)
    if excess <= 0.0:
        return
    v = excess / tree.sums[0] / (1 << (2 * level))
    tree.variance[node] = v
    tree.sums[1] += v
    bucket = int(2.0 * (math.log2(v) - _LOWEST))
    if level < MAX_LEVEL and bucket >= 0:
        bucket = min(bucket, _BUCKETS - 1)
        tree.link[node] = tree.first[bucket]
        tree.first[bucket] = node
        tree.counts[1] = max(tree.counts[1], bucket)


@kernel(forceinline=True)
def _known(light, level, cell):
    """(mean, mean square) of a cell of a level that the statistics have."""
    if level == light.level:
        return light.finest[cell, 0], light.finest[cell, 1]
    at = level_offset(level) + cell
    return light.mean[at], light.square[at]


@kernel
def _plant(tree, light):
    """Begin with the whole levels."""
    begin = level_offset(WHOLE_LEVELS)
    tree.link[:begin], tree.level[:begin] = 0, 0
    for cell in range(1 << (2 * WHOLE_LEVELS)):
        mean, square = _known(light, WHOLE_LEVELS, cell)
        _put(tree, begin + cell, WHOLE_LEVELS, cell, mean, square)
    tree.counts[0] = begin + (1 << (2 * WHOLE_LEVELS))


@kernel
def _look_up_child(lookup, level, cell, parent, parent_square):
    """(mean, mean square) of a cell that is too small for the statistics."""
    row, column = morton_to_row_column(cell)
    size = np.float32(1.0 / (1 << level))
    x, y = np.float32(column) * size, np.float32(row) * size
    texels = footprint(lookup, x, y, size)
    n = max(1, min(_PARTS, int(texels + np.float32(0.75))))
    average, square, brightest = look_up_cell(lookup, x, y, size, n)
    if average < max(_DARK * parent, _STEEP * brightest):  # a rim: so few samples may miss it
        average, square, brightest = look_up_cell(lookup, x, y, size, 3 * n)
        more = max(average, _RIM * brightest)  # bounds their weights, and what is wasted counts
        square += np.float32(2.0) * more * (more - average)
        average = more
    if texels > np.float32(2 * _PARTS):  # at a pole: what lies between the samples, nobody knows
        average = np.float32(0.5) * (average + parent)
        square = max(square, np.float32(0.5) * parent_square)
    return max(average, _FLOOR * max(brightest, parent)), max(square, _UNSEEN * parent_square)


@kernel
def _split(lookup, light, tree, node, new):
    """Give a leaf its four children, nodes new ... new + 3."""
    level, cell = np.int64(tree.level[node]), np.int64(tree.cell[node])
    parent, v = tree.averages[node], np.float64(tree.variance[node])
    excess = v * (1 << (2 * level)) * tree.sums[0]
    parent_square = np.float32((excess + np.float64(parent)) * np.float64(parent))
    tree.sums[1] -= v
    for q in range(4):
        child = 4 * cell + q
        if level < light.level:
            mean, square = _known(light, level + 1, child)
        else:
            mean, square = _look_up_child(lookup, level + 1, child, parent, parent_square)
        _put(tree, new + q, level + 1, child, mean, square)
    tree.link[node], tree.level[node] = new, -level


@kernel
def _grow(lookup, light, tree, steps):
    """Split up to ``steps`` leaves; returns whether the tree is done."""
    for _ in range(steps):
        bucket = tree.counts[1]
        while bucket >= 0 and tree.first[bucket] < 0:
            bucket -= 1
        tree.counts[1] = bucket
        new = tree.counts[0]
        if bucket < 0 or tree.sums[1] < _VARIANCE or new + 4 > len(tree.averages):
            return True
        node = tree.first[bucket]
        tree.first[bucket] = tree.link[node]
        tree.counts[0] = new + 4
        _split(lookup, light, tree, node, new)
    return False


@kernel
def _finish(tree, n):
    """Averages of all that was split, from the leaves up: leaves have no children.

    Returns the level of the smallest cells.
    """
    deepest = WHOLE_LEVELS
    for node in range(n - 1, level_offset(WHOLE_LEVELS) - 1, -1):
        if tree.level[node] < 0:
            child = tree.link[node]
            tree.averages[node] = np.float32(0.25) * (
                tree.averages[child]
                + tree.averages[child + 1]
                + tree.averages[child + 2]
                + tree.averages[child + 3]
            )
        else:
            tree.link[node] = 0
            deepest = max(deepest, np.int64(tree.level[node]))
    sum_up(tree.averages, WHOLE_LEVELS)
    return deepest


def _new_growth(total: float) -> _Growth:
    return _Growth(
        averages=np.empty(_NODES, np.float32),
        link=np.empty(_NODES, np.int32),
        variance=np.empty(_NODES, np.float32),
        cell=np.empty(_NODES, np.int32),
        level=np.empty(_NODES, np.int8),
        first=np.full(_BUCKETS, -1, np.int32),
        counts=np.array([0, -1], np.int64),
        sums=np.array([max(total, 1e-30), 0.0]),
    )


def build_pyramid(lookup: EnvironmentLookup, progress=lambda fraction: None) -> LightPyramid:
    """The light of all directions as a quadtree.

    progress is told every few milliseconds, and may raise to stop.
    """
    light = cell_light(lookup, lambda fraction: progress(0.5 * fraction))
    tree = _new_growth(light.total)
    _plant(tree, light)
    while not _grow(lookup, light, tree, _STEPS):
        progress(0.5 + 0.5 * int(tree.counts[0]) / _NODES)
    n, total = int(tree.counts[0]), light.total
    del light
    deepest = int(_finish(tree, n))
    averages, children = tree.averages, tree.link
    averages.resize(n, refcheck=False)  # in place: no second copy of either
    children.resize(n, refcheck=False)
    if averages[0] > 0.0:  # what the leaves' samples say, and what the texels add up to
        averages *= np.float32(total / float(averages[0]))
    return LightPyramid(averages, WHOLE_LEVELS, children, deepest)

"""The leaves below the light's whole levels, each a table lookup away from its cell.

A cell of the last whole level is .4 degrees wide. Which of its leaves a point falls into needs no
descent, as no two samples of a pixel meet there often: the leaves are chosen by alias [Walker77].
Each entry of a cell's table is its own leaf below a threshold and another leaf above it, and a
lookup reads one line of memory where a descent reads two a level.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..machine.prefetch import fetch
from .pyramid import LightPyramid, level_offset

_MOST_DEPTH = 6  # levels below the whole ones: 15 in all
_BITS = 6  # of a column or row inside a cell
_ROW, _DEPTH, _OTHER = _BITS, 2 * _BITS, 15  # where they begin in a place; a second place above
_PLACE = np.int32((1 << 15) - 1)
_THRESHOLD, _OWN, _ALIAS = 0, 1, 2  # columns of LightLeaves.numbers; 3 is places
_ZERO, _ONE, _BELOW_ONE = np.float32(0.0), np.float32(1.0), np.float32(1.0 - 2.0**-24)
_TINY = np.float32(1e-30)


class LightLeaves(NamedTuple):
    """first: int32 (4^levels + 1,), where the entries of a cell begin: none where it is a leaf
    numbers: float32 (entries, 4): threshold, average of the entry's own leaf and of its alias
    places: int32 (entries, 4), the same memory; column 3: column, row, depth of both leaves
    """

    first: np.ndarray
    numbers: np.ndarray
    places: np.ndarray


@kernel(allocates=True)
def _count_leaves(pyramid, first):
    children, begin = pyramid.children, level_offset(pyramid.levels)
    stack = np.empty(4 * _MOST_DEPTH + 4, np.int32)
    total = 0
    for cell in range(len(first) - 1):
        first[cell] = total
        if children[begin + cell] == 0:
            continue
        stack[0], n = begin + cell, 1
        while n > 0:
            n -= 1
            child = children[stack[n]]
            if child == 0:
                total += 1
                continue
            for q in range(4):
                stack[n + q] = child + q
            n += 4
    first[len(first) - 1] = total
    return total


@kernel
def _collect(pyramid, cell, stack, averages, places):
    """Write the leaves of one cell; returns how many. stack: int32 (any, 2), node and place"""
    children, count, n = pyramid.children, 0, 1
    stack[0, 0], stack[0, 1] = level_offset(pyramid.levels) + cell, 0
    while n > 0:
        n -= 1
        node, place = stack[n, 0], stack[n, 1]
        child = children[node]
        if child == 0:
            averages[count], places[count] = pyramid.averages[node], place
            count += 1
            continue
        column, row = place & 63, (place >> _ROW) & 63
        depth = (place >> _DEPTH) + 1
        for q in range(3, -1, -1):
            inside = (2 * column + (q & 1)) | ((2 * row + (q >> 1)) << _ROW) | (depth << _DEPTH)
            stack[n, 0], stack[n, 1] = child + q, inside
            n += 1
    return count


@kernel
def _make_aliases(averages, places, share, small, large, numbers, packed):
    """Fill the entries of one cell [Vose91]; share, small, large: scratch, one each a leaf."""
    n, total = len(averages), 0.0
    for k in range(n):
        share[k] = np.float64(averages[k]) / (1 << (2 * (places[k] >> _DEPTH)))
        total += share[k]
    n_small, n_large = 0, 0
    for k in range(n):
        share[k] = share[k] * n / total if total > 0.0 else 1.0
        numbers[k, _THRESHOLD], numbers[k, _OWN], numbers[k, _ALIAS] = 1.0, averages[k], averages[k]
        packed[k] = places[k] | (places[k] << _OTHER)
        if share[k] < 1.0:
            small[n_small] = k
            n_small += 1
        else:
            large[n_large] = k
            n_large += 1
    while n_small > 0 and n_large > 0:
        n_small -= 1
        k, other = small[n_small], large[n_large - 1]
        numbers[k, _THRESHOLD], numbers[k, _ALIAS] = share[k], averages[other]
        packed[k] = places[k] | (places[other] << _OTHER)
        share[other] -= 1.0 - share[k]
        if share[other] < 1.0:
            n_large -= 1
            small[n_small] = other
            n_small += 1


@kernel(allocates=True)
def _fill(pyramid, first, numbers, packed):
    most = 1 << (2 * _MOST_DEPTH)
    stack = np.empty((4 * _MOST_DEPTH + 4, 2), np.int32)
    averages, places = np.empty(most, np.float32), np.empty(most, np.int32)
    share, small, large = np.empty(most), np.empty(most, np.int32), np.empty(most, np.int32)
    for cell in range(len(first) - 1):
        a, b = first[cell], first[cell + 1]
        if a < b:
            n = _collect(pyramid, cell, stack, averages, places)
            _make_aliases(
                averages[:n], places[:n], share, small, large, numbers[a:b], packed[a:b, 3]
            )


def light_leaves(pyramid: LightPyramid) -> LightLeaves:
    """The tables of a quadtree; 16 bytes for each leaf below the whole levels."""
    first = np.zeros(4**pyramid.levels + 1, np.int32)
    numbers = np.empty((max(_count_leaves(pyramid, first), 1), 4), np.float32)
    leaves = LightLeaves(first, numbers, numbers.view(np.int32))
    _fill(pyramid, first, numbers, leaves.places)
    return leaves


@kernel(forceinline=True)
def fetch_cell(leaves, cell):
    """Ask for where the entries of a cell begin."""
    fetch(leaves.first, 4 * np.int64(cell))


@kernel(forceinline=True)
def fetch_leaf(leaves, cell, x):
    """Ask for the entry that choose_leaf reads."""
    first = leaves.first[cell]
    n = leaves.first[cell + 1] - first
    k = np.int32(max(x, _ZERO) * np.float32(n))
    fetch(leaves.numbers, 16 * np.int64(first + k))


@kernel(forceinline=True)
def choose_leaf(leaves, average, cell, x, y):
    """(x, y, average): where a point of a cell of the last whole level falls, and the light there.

    average: of the cell; x, y: float32 in [0, 1), of the cell, before and after. Without branches.
    """
    first = leaves.first[cell]
    n = leaves.first[cell + 1] - first
    split = n > 0
    x = x if x > _ZERO else _ZERO  # NaN, where no light is at all, must not become an index
    x *= np.float32(n) if split else _ONE
    k = min(np.int32(x), max(n - 1, 0))
    entry = min(first + k, len(leaves.numbers) - 1)
    r = x - np.float32(k)
    threshold, place = leaves.numbers[entry, _THRESHOLD], leaves.places[entry, 3]
    own = (r < threshold) | (not split)
    threshold = threshold if split else _ONE
    place = place if own else place >> _OTHER
    place = place & _PLACE if split else np.int32(0)
    light = leaves.numbers[entry, _OWN] if own else leaves.numbers[entry, _ALIAS]
    r = r if own else r - threshold
    r = min(r / max(threshold if own else _ONE - threshold, _TINY), _BELOW_ONE)
    size = _ONE / np.float32(np.int32(1) << (place >> _DEPTH))
    x = (np.float32(place & 63) + r) * size
    y = (np.float32((place >> _ROW) & 63) + y) * size
    return min(x, _BELOW_ONE), min(y, _BELOW_ONE), light if split else average

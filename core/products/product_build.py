"""Fill the product of a shading point: its base, then blocks where a glossy lobe is steep.

Each generation of blocks is worked out in one go: their cells are gathered into long arrays first,
so that the arithmetic (lobe_cells.py) runs over hundreds of cells at a time, 2 ns each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lambert_kinds import HAIR, TRANSLUCENT_ROUND
from ..bsdf.lobes import DIFFUSE_LOBE
from ..bsdf.sheen import add_sheen
from ..bsdf.toon import fill_toon, is_toon
from ..light.pyramid import level_offset
from .hair_cells import fill_hair
from .lobe_cells import add_gloss, fill_lambert, gloss_at, lambert_at
from .product import (
    BASE_BEGIN,
    BASE_CELLS,
    BASE_LEVEL,
    BLOCK_BEGIN,
    BLOCK_CELLS,
    DEEPEST_LEVEL,
    GROUP,
    MAX_BLOCKS,
    SECOND_LEVEL,
    SUMS_BEGIN,
)

# Blocks that cells of the base may have; cells of these blocks may have the rest.
_MAX_FIRST = 24
# A cell is cut if its spread (lobe_cells.py) is more than this part of the product.
_CUT = 0.015
# A lobe of which the product keeps less than this has no cells cut: nearly all samples follow the
# lobe itself, and blocks are most of what such a point costs.
_LEAST_KEPT = np.float32(0.3)
# Seen flatter than this (cosine), lobes crowd into few cells of the base: up to this part of the
# samples follows the lobe itself, or a rare one is 70 times too bright.
_FLAT, _MOST_FLAT = np.float32(0.2), np.float32(0.4)
# Of the samples of sheen, those that follow its own lobe.
_SHEEN = np.float32(0.05)


class BlockScratch(NamedTuple):
    """Room to work out the blocks of one point: cells, and for each block its parent cell."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    light: np.ndarray
    spread: np.ndarray
    parent: np.ndarray
    morton: np.ndarray


def new_block_scratch() -> BlockScratch:
    """Scratch of build_product; one a thread."""
    n = BLOCK_CELLS * MAX_BLOCKS
    cells = (np.empty(n, np.float32) for _ in range(4))
    spread = np.empty(max(n, BASE_CELLS), np.float32)
    return BlockScratch(*cells, spread, *(np.empty(MAX_BLOCKS, np.int32) for _ in range(2)))


@kernel
def _select(spread, n, limit, most, parent, first):
    """Write the cells whose spread is above the limit to parent[first ...]; returns how many.

    Where they were more than ``most``, the limit rises until they are not. n: a multiple of 16
    """
    while True:
        count = 0
        for r in range(n):
            count += spread[r] > limit
        if count <= most:
            break
        limit *= np.float32(1.5)
    if count == 0:
        return 0
    k = first
    for group in range(0, n, BLOCK_CELLS):
        largest = np.float32(0.0)
        for j in range(BLOCK_CELLS):
            largest = max(largest, spread[group + j])
        if largest > limit:
            for j in range(BLOCK_CELLS):
                if spread[group + j] > limit:
                    parent[k] = group + j
                    k += 1
    return count


@kernel
def _gather_blocks(directions, averages, level, first, n, scratch):
    """Write directions and light of the cells of blocks first ... first + n - 1."""
    begin = level_offset(level)  # whole to DEEPEST_LEVEL at least
    for b in range(n):
        k, to = BLOCK_CELLS * scratch.morton[first + b], BLOCK_CELLS * b
        for j in range(BLOCK_CELLS):
            scratch.x[to + j] = directions.x[k + j]
            scratch.y[to + j] = directions.y[k + j]
            scratch.z[to + j] = directions.z[k + j]
        for j in range(BLOCK_CELLS):
            scratch.light[to + j] = averages[begin + k + j]


@kernel
def _fill_blocks(lambert, gloss, level, first, n, tree, scratch):
    """Write the cells of blocks first ... first + n - 1, which _gather_blocks has gathered."""
    to, n_cells = BLOCK_BEGIN + BLOCK_CELLS * first, BLOCK_CELLS * n
    values = tree[to : to + n_cells]
    radius = np.float32(2.0 / (1 << level))
    scale = np.float32(1.0 / (1 << (2 * (level - BASE_LEVEL))))
    cells = (scratch.x, scratch.y, scratch.z, scratch.light)
    if lambert.albedo > np.float32(0.0):
        fill_lambert(lambert, *cells, n_cells, radius, scale, values)
    else:
        values[:] = np.float32(0.0)
    add_gloss(gloss, *cells, n_cells, radius, scale, values, scratch.spread)


@kernel
def _sum_blocks(tree, begin, first, last, parent):
    """Sum up blocks first ... last - 1 and write each sum to its parent cell, tree[begin + ...]."""
    for k in range(4 * first, 4 * last):
        c = BLOCK_BEGIN + 4 * k
        tree[SUMS_BEGIN + k] = (tree[c] + tree[c + 1]) + (tree[c + 2] + tree[c + 3])
    for b in range(first, last):
        k = SUMS_BEGIN + 4 * b
        tree[begin + parent[b]] = (tree[k] + tree[k + 1]) + (tree[k + 2] + tree[k + 3])


@kernel
def _cut_steep_cells(lambert, gloss, cells, averages, total, tree, links, scratch):
    """Cut cells of the base, and cells of the new blocks, into blocks; returns how many.

    scratch.spread: of the base's cells; total: their sum
    """
    parent, morton = scratch.parent, scratch.morton
    limit = np.float32(_CUT) * total
    n = _select(scratch.spread, BASE_CELLS, limit, _MAX_FIRST, parent, 0)
    if n == 0:
        return 0
    links[:] = 0
    for b in range(n):
        links[parent[b]] = b + 1
        morton[b] = parent[b]
    _gather_blocks(cells.second, averages, SECOND_LEVEL, 0, n, scratch)
    _fill_blocks(lambert, gloss, SECOND_LEVEL, 0, n, tree, scratch)
    for b in range(n):
        total -= tree[BASE_BEGIN + parent[b]]
    for k in range(BLOCK_BEGIN, BLOCK_BEGIN + BLOCK_CELLS * n):
        total += tree[k]
    limit = np.float32(_CUT) * total
    m = _select(scratch.spread, BLOCK_CELLS * n, limit, MAX_BLOCKS - n, parent, n)
    for b in range(n, n + m):
        links[BASE_CELLS + parent[b]] = b + 1
        morton[b] = BLOCK_CELLS * morton[parent[b] // BLOCK_CELLS] + parent[b] % BLOCK_CELLS
    _gather_blocks(cells.third, averages, DEEPEST_LEVEL, n, m, scratch)
    _fill_blocks(lambert, gloss, DEEPEST_LEVEL, n, m, tree, scratch)
    _sum_blocks(tree, BLOCK_BEGIN, n, n + m, parent)
    _sum_blocks(tree, BASE_BEGIN, 0, n, parent)
    return n + m


@kernel
def sum_base(tree):
    """Write all levels above the base of a product's tree."""
    for up in range(BASE_LEVEL - 1, -1, -1):
        here, below = level_offset(up), level_offset(up + 1)
        for k in range(1 << (2 * up)):
            c = below + 4 * k
            tree[here + k] = (tree[c] + tree[c + 1]) + (tree[c + 2] + tree[c + 3])


@kernel(forceinline=True)
def _is_hair(lobes, p):
    return lobes.kind[p] <= DIFFUSE_LOBE and TRANSLUCENT_ROUND < lobes.rough[p, 3] <= HAIR


@kernel(forceinline=True)
def _below(groups, g, normal, turned):
    return (
        groups[g, 0] * normal[0] + groups[g, 1] * normal[1] + groups[g, 2] * normal[2]
        <= groups[g, 3] - turned
    )


@kernel(forceinline=True)
def _next_run(groups, normal, turned, g):
    """(first, last + 1) of the next groups from g on that may be above the horizon."""
    n = len(groups)
    while g < n and _below(groups, g, normal, turned):
        g += 1
    first = g
    while g < n and not _below(groups, g, normal, turned):
        g += 1
    return first, g


@kernel(forceinline=True)
def _run(cells, a, b):
    return cells.x[a:b], cells.y[a:b], cells.z[a:b], cells.light[a:b]


@kernel
def _fill_base_lambert(lobe, cells, radius, leaves):
    """Write the base's cells; returns their sum."""
    total, g = np.float32(0.0), 0
    if lobe.albedo == total:  # a metal
        leaves[:] = total
        return total
    normal, one = (lobe.x, lobe.y, lobe.z), np.float32(1.0)
    while g < len(cells.groups):
        first, end = _next_run(cells.groups, normal, lobe.turned, g)
        leaves[GROUP * g : GROUP * first] = np.float32(0.0)
        a, b = GROUP * first, GROUP * end
        total += fill_lambert(lobe, *_run(cells, a, b), b - a, radius, one, leaves[a:b])
        g = end
    return total


@kernel
def _add_base_gloss(lobe, cells, radius, leaves, spread):
    """Add the glossy lobe to the base's cells."""
    g, one = 0, np.float32(1.0)
    while g < len(cells.groups):
        first, end = _next_run(cells.groups, lobe.normal, lobe.turned, g)
        spread[GROUP * g : GROUP * first] = np.float32(0.0)
        a, b = GROUP * first, GROUP * end
        run = _run(cells, a, b)
        add_gloss(lobe, *run, b - a, radius, one, leaves[a:b], spread[a:b])
        g = end


@kernel
def build_product(lobes, p, turned, cells, averages, products, scratch):
    """Write the product of point p; trees[p, 0] is 0 where no light can reach it.

    turned: float32, how far normals may be turned of points that use it too, radians
    averages: of the LightPyramid
    """
    products.own[p] = p
    tree = products.trees[p]
    leaves = tree[BASE_BEGIN:BLOCK_BEGIN]
    radius, one = np.float32(2.0 / (1 << BASE_LEVEL)), np.float32(1.0)
    if _is_hair(lobes, p):
        products.blocks[p] = 0
        products.follow[p] = fill_hair(lobes, p, cells, radius, leaves)
        sum_base(tree)
        return
    lambert = lambert_at(lobes, p, turned)
    matte = _fill_base_lambert(lambert, cells, radius, leaves)
    products.blocks[p], products.follow[p] = 0, 0.0
    if lobes.kind[p] <= DIFFUSE_LOBE:
        kind = lobes.rough[p, 3]
        if is_toon(lobes.rough[p]):
            products.follow[p] = fill_toon(lobes, p, cells, radius, leaves)
        elif TRANSLUCENT_ROUND < kind < np.float32(0.0):
            add_sheen(lobes, p, cells, radius, leaves)
            products.follow[p] = _SHEEN
        sum_base(tree)
        return
    gloss = gloss_at(lobes, p, turned)
    _add_base_gloss(gloss, cells, radius, leaves, scratch.spread)
    total = np.float32(0.0)
    for r in range(BASE_CELLS):
        total += leaves[r]
    if total > np.float32(0.0) and gloss.kept >= _LEAST_KEPT:
        products.blocks[p] = _cut_steep_cells(
            lambert, gloss, cells, averages, total, tree, products.links[p], scratch
        )
    sum_base(tree)
    if tree[0] > np.float32(0.0):
        held = max(tree[0] - matte, np.float32(0.0))
        narrow = (one - gloss.kept) * held / (gloss.kept * matte + held)
        flat = max(one - gloss.cos_o / _FLAT, np.float32(0.0))
        products.follow[p] = max(narrow, _MOST_FLAT * flat * flat)

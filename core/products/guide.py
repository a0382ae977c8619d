"""What the shadow rays of a block have learnt: how much of each part of the sky is free.

The points of a cell of 8 x 8 pixels see much the same occluders. Where a part V of the rays into a
cell of the product's base was free, a sample's second moment is L^2 B^2 V / pdf, so its variance is
least for pdf ~ L B sqrt(V); but nets leave little of the variance where all is free, so the product
is scaled by sqrt(V (1 - V / 2)). Every round is unbiased given those before it, whatever they have
learnt, and so is their sum.

V of a cell leans on the rays of the eight cells beside it, as if two of its own had seen what they
say together; those on the cell four times as large, as if _TRUST rays had seen that, and so on up
to the whole sphere. Of a cell's rays no more than _TOLD tell of what is around it: thousands go
into a hidden sun, which is no reason to give up the sky beside it. V is never less than _DOUBT rays
of all that were asked: a few leave doubt, many let go even of a sun a thousand times as bright as
the sky. docs/decisions/0016-learnt-visibility.md has the figures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..light.pyramid import level_offset, spread_bits
from .product import BASE_BEGIN, BASE_CELLS, BASE_LEVEL, BLOCK_BEGIN
from .product_build import sum_base

_TRUST, _BESIDE = np.float32(8.0), np.float32(2.0)
_TOLD, _DOUBT = np.float32(24.0), np.float32(0.001)
_ONE, _SMOOTH = np.float32(1.0), np.float32(0.5)
# Learn at 1 sample of a point, sent ahead (scouts.py), 4, 16, 64 ...; where none is, 2, 8, 32 ...
_FIRST, _FACTOR = 2, 4
_FULL = np.uint16(65535)
_SIDE = 1 << BASE_LEVEL


class Guides(NamedTuple):
    """What n blocks have learnt, by cells of the product's base in Morton order.

    asked, free: uint16 (n, BASE_CELLS), rays, and those that nothing lay on
    gain: float32 (n, BASE_CELLS), what products are scaled by
    learnt: int32 (n,), samples of a point at which the gain was worked out; 0: it is 1 everywhere
    """

    asked: np.ndarray
    free: np.ndarray
    gain: np.ndarray
    learnt: np.ndarray


class GuideRoom(NamedTuple):
    """Scratch: float32 (BASE_BEGIN + BASE_CELLS,), all levels over the cells; (BASE_CELLS,).

    framed: the cells' counts row by row, and those over the square's border; beside: without that
    """

    asked: np.ndarray
    free: np.ndarray
    ratio: np.ndarray
    framed: np.ndarray
    beside: np.ndarray


def new_guides(n: int) -> Guides:
    """n blocks that know nothing yet; 8 kB each."""
    return Guides(
        np.zeros((n, BASE_CELLS), np.uint16),
        np.zeros((n, BASE_CELLS), np.uint16),
        np.ones((n, BASE_CELLS), np.float32),
        np.zeros(n, np.int32),
    )


def new_guide_room() -> GuideRoom:
    """One a thread."""
    sizes = (BLOCK_BEGIN, BLOCK_BEGIN, BASE_CELLS, (_SIDE + 2, _SIDE + 2), (_SIDE, _SIDE))
    return GuideRoom(*(np.zeros(size, np.float32) for size in sizes))


@kernel
def guide_of(guides, block):
    """The guide of one block, as Guides of one row."""
    k = slice(block, block + 1)
    return Guides(guides.asked[k], guides.free[k], guides.gain[k], guides.learnt[k])


@kernel(forceinline=True)
def next_lesson(guide):
    """How many samples a point must have before the guide learns again."""
    return _FIRST if guide.learnt[0] == 0 else _FACTOR * guide.learnt[0]


@kernel
def note_rays(lanes, n_rays, guide):
    """Count the rays of the lanes, but for those that follow a lobe."""
    asked, free = guide.asked[0], guide.free[0]
    for k in range(n_rays):
        s = lanes.ray[k]
        c = lanes.base[s]
        if c < 0:
            continue
        if asked[c] == _FULL:
            asked[c] >>= np.uint16(1)
            free[c] >>= np.uint16(1)
        asked[c] += np.uint16(1)
        free[c] += np.uint16(lanes.seen[s] != 0)


@kernel(forceinline=True)
def _count_cells(guide, room):
    """Write the counts of the base to the room, of no more than _TOLD rays of a cell."""
    for c in range(BASE_CELLS):
        asked, free = np.float32(guide.asked[0, c]), np.float32(guide.free[0, c])
        share = min(_ONE, _TOLD / max(asked, _ONE))
        room.asked[BASE_BEGIN + c], room.free[BASE_BEGIN + c] = asked * share, free * share


@kernel(forceinline=True)
def _quad(i, j):
    """Where the four cells of rows 2 i, 2 i + 1 and columns 2 j, 2 j + 1 begin."""
    below = spread_bits(np.int32(i)) << np.int32(1)
    return BASE_BEGIN + ((spread_bits(np.int32(j)) | below) << np.int32(2))


@kernel
def _lay_out(counts, framed):
    """Write the counts of the base row by row; what lies over a border follows it (cell_beside)."""
    for i in range(_SIDE // 2):
        upper, lower = framed[2 * i + 1], framed[2 * i + 2]
        for j in range(_SIDE // 2):
            c, k = _quad(i, j), 2 * j + 1
            upper[k], upper[k + 1] = counts[c], counts[c + 1]
            lower[k], lower[k + 1] = counts[c + 2], counts[c + 3]
    first, last = 1, _SIDE
    for k in range(first, last + 1):
        other = _SIDE + 1 - k
        framed[0, k], framed[_SIDE + 1, k] = framed[first, other], framed[last, other]
        framed[k, 0], framed[k, _SIDE + 1] = framed[other, first], framed[other, last]
    framed[0, 0], framed[0, _SIDE + 1] = framed[last, last], framed[last, first]
    framed[_SIDE + 1, 0], framed[_SIDE + 1, _SIDE + 1] = framed[first, last], framed[first, first]


@kernel
def _look_around(counts, framed, beside):
    """Write over the counts of the base those of the eight cells beside each; beside: scratch."""
    _lay_out(counts, framed)
    for row in range(_SIDE):
        above, own, under = framed[row], framed[row + 1], framed[row + 2]
        for j in range(_SIDE):
            near = above[j] + above[j + 1] + above[j + 2] + own[j] + own[j + 2]
            beside[row, j] = near + (under[j] + under[j + 1] + under[j + 2])
    for i in range(_SIDE // 2):
        upper, lower = beside[2 * i], beside[2 * i + 1]
        for j in range(_SIDE // 2):
            c, k = _quad(i, j), 2 * j
            counts[c], counts[c + 1] = upper[k], upper[k + 1]
            counts[c + 2], counts[c + 3] = lower[k], lower[k + 1]


@kernel
def _find_parts(asked, part):
    """Make parts that are free of the counts in ``part``, on all levels above the base."""
    part[0] = (part[0] + _ONE) / (asked[0] + np.float32(2.0))
    for level in range(1, BASE_LEVEL):
        begin, above = level_offset(level), level_offset(level - 1)
        for k in range(1 << (2 * level)):
            prior = _TRUST * part[above + (k >> 2)]
            part[begin + k] = (part[begin + k] + prior) / (asked[begin + k] + _TRUST)


@kernel
def learn(guide, taken, room):
    """Work out the gain anew; room.ratio: over the gain before. taken: samples of a point."""
    asked, part, gain = room.asked, room.free, guide.gain[0]
    _count_cells(guide, room)
    sum_base(asked)
    sum_base(part)
    _find_parts(asked, part)
    _look_around(asked, room.framed, room.beside)
    _look_around(part, room.framed, room.beside)
    least = np.sqrt(_DOUBT / (np.float32(np.sum(guide.asked[0])) + _ONE))
    above, beside = level_offset(BASE_LEVEL - 1), room.ratio
    for k in range(BASE_CELLS // 4):
        beside[4 * k : 4 * k + 4] = _TRUST * part[above + k]
    for c in range(BASE_CELLS):
        seen, rays = beside[c] + part[BASE_BEGIN + c], asked[BASE_BEGIN + c] + _TRUST
        free = np.float32(guide.free[0, c]) + _BESIDE * (seen / rays)
        free /= np.float32(guide.asked[0, c]) + _BESIDE
        new = max(np.sqrt(free * (_ONE - _SMOOTH * free)), least)
        room.ratio[c] = new / gain[c]
        gain[c] = new
    guide.learnt[0] = taken


@kernel
def scale_product(products, row, by):
    """Scale the product of a row by ``by``, float32 (BASE_CELLS,), cell by cell of its base."""
    tree = products.trees[row]
    for c in range(BASE_CELLS):
        tree[BASE_BEGIN + c] *= by[c]
    sum_base(tree)


@kernel
def scale_products(products, count, wanted, used, by):
    """Scale what points use that want more samples than their count, each product once.

    count, wanted: int32, of the points; used: scratch, int32
    """
    n = len(count)
    for p in range(n):
        used[p] = 0
    for p in range(n):
        if wanted[p] > count[p]:
            used[products.own[p]] = 1
    for row in range(n):
        if used[row] != 0:
            scale_product(products, row, by)

"""What the shadow rays of a block have learnt: how much of each part of the sky is free.

The points of a cell of 8 x 8 pixels see much the same occluders. Where a part V of the rays into a
cell of the product's base was free, a sample's second moment is L^2 B^2 V / pdf, so its variance is
least for pdf ~ L B sqrt(V); but nets leave little of the variance where all is free, so the product
is scaled by sqrt(V (1 - V / 2)). Every round is unbiased given those before it, whatever they have
learnt, and so is their sum.

V of a cell leans on that of the cell four times as large, as if _TRUST rays had seen that, and so
on up to the whole sphere. Of a cell's rays no more than _TOLD tell of what is around it: thousands
go into a hidden sun, which is no reason to give up the sky beside it. V is never less than _DOUBT
rays of all that were asked: a few leave doubt, many let go even of a sun a thousand times as bright
as the sky. docs/decisions/0016-learnt-visibility.md has the figures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..light.pyramid import level_offset
from .product import BASE_BEGIN, BASE_CELLS, BASE_LEVEL, BLOCK_BEGIN
from .product_build import sum_base

_TRUST = np.float32(8.0)
_TOLD, _DOUBT = np.float32(24.0), np.float32(0.01)
_ONE, _SMOOTH = np.float32(1.0), np.float32(0.5)
_FIRST, _FACTOR = 2, 4  # learn at 2 samples of a point, 8, 32, 128 ...
_FULL = np.uint16(65535)


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
    """Scratch: float32 (BASE_BEGIN + BASE_CELLS,), all levels over the cells; (BASE_CELLS,)."""

    asked: np.ndarray
    free: np.ndarray
    ratio: np.ndarray


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
    sizes = (BLOCK_BEGIN, BLOCK_BEGIN, BASE_CELLS)
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
def _count_cells(guide, most, room):
    """Write the counts of the base to the room, of no more than ``most`` rays of a cell."""
    for c in range(BASE_CELLS):
        asked, free = np.float32(guide.asked[0, c]), np.float32(guide.free[0, c])
        share = min(_ONE, most / max(asked, _ONE))
        room.asked[BASE_BEGIN + c], room.free[BASE_BEGIN + c] = asked * share, free * share


@kernel
def learn(guide, taken, room):
    """Work out the gain anew; room.ratio: over the gain before. taken: samples of a point."""
    asked, part, gain = room.asked, room.free, guide.gain[0]
    _count_cells(guide, _TOLD, room)
    sum_base(asked)
    sum_base(part)
    _count_cells(guide, np.float32(_FULL), room)
    least = np.sqrt(_DOUBT / (np.sum(asked[BASE_BEGIN : BASE_BEGIN + BASE_CELLS]) + _ONE))
    part[0] = (part[0] + _ONE) / (asked[0] + np.float32(2.0))
    for level in range(1, BASE_LEVEL + 1):
        begin, above = level_offset(level), level_offset(level - 1)
        for k in range(1 << (2 * level)):
            prior = _TRUST * part[above + (k >> 2)]
            part[begin + k] = (part[begin + k] + prior) / (asked[begin + k] + _TRUST)
    for c in range(BASE_CELLS):
        free = part[BASE_BEGIN + c]
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

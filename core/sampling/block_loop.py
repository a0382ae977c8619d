"""The paper's loop for mode UNBIASED, in machine code from a block's products to its sums.

A block is the points of one cell of 8 x 8 pixels (neighbours.py), of one pass or a few, whose
products stay in a core's second cache from round to round. The rounds are those of incremental.py,
where the loop is written out for any sampler; here samples are traced as soon as the lanes are
full, so that nothing is written to memory but the sums, and no round asks for Python's lock.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..products.guide import (
    GuideRoom,
    guide_of,
    learn,
    new_guide_room,
    next_lesson,
    scale_product,
    scale_products,
)
from ..products.product import Products, new_products
from ..unit_square.sample_order import MOST_ORDERED
from ..unit_square.sequence import PixelSequence
from .block_views import lobes_at, points_at, sums_at
from .incremental import RayBatch, least_count, new_rays, select_points
from .neighbours import CELL_PX, Neighbours, fill_neighbours
from .products_apart import build_with, builder_address
from .scouts import ScoutRoom, mostly_hidden, new_scout_room, send_scouts
from .stop_rule import (
    Rule,
    RuleRoom,
    asks_neighbours,
    begin_rule,
    decide_rule,
    end_of_round,
    finish_rule,
    new_rule_room,
)
from .unbiased import Task, Work, new_work, take_samples

PASSES_AT_ONCE = 8  # of a cell's pixels, at the most
CELL_POINTS = CELL_PX * CELL_PX
BLOCK_POINTS = PASSES_AT_ONCE * CELL_POINTS
# Samples between two looks at the flag of a cancel: some milliseconds.
_BATCH = MOST_ORDERED


class Room(NamedTuple):
    """Scratch of a thread for blocks of up to n points.

    near, group: of Neighbours; slots: of fill_neighbours
    wanted, active, some, counts, used: int32 (n,); rays: without room, for take_samples
    builder: address of what builds products, of products_apart
    """

    work: Work
    products: Products
    rule: RuleRoom
    guide: GuideRoom
    scouts: ScoutRoom
    near: np.ndarray
    group: np.ndarray
    slots: np.ndarray
    wanted: np.ndarray
    active: np.ndarray
    some: np.ndarray
    counts: np.ndarray
    used: np.ndarray
    rays: RayBatch
    builder: int


def new_room(glossy: bool, n: int = BLOCK_POINTS, builder: int | None = None) -> Room:
    """glossy: whether any of the points has a lobe beside Lambert's; n: points of a block.

    builder: None: the address is asked for, which may compile what is there
    """
    return Room(
        new_work(),
        new_products(n, glossy),
        new_rule_room(n),
        new_guide_room(),
        new_scout_room(n),
        np.empty((n, 8), np.int32),
        np.empty(n, np.int32),
        np.empty((CELL_PX + 2, CELL_PX + 2), np.int32),
        *(np.empty(n, np.int32) for _ in range(5)),
        new_rays(0),
        builder_address() if builder is None else builder,
    )


class Places(NamedTuple):
    """Where the points are: column and row of their pixels in the frame, material; int32 (n,)."""

    column: np.ndarray
    row: np.ndarray
    material: np.ndarray


@kernel(inline="always")
def _take_piece(task, n_active, first, end, traversal, sums, room, stop):
    """Samples first ... end - 1 of the active points that want them; how many had a ray."""
    active, wanted, some, counts = room.active, room.wanted, room.some, room.counts
    n, total, traced = 0, 0, 0
    for a in range(n_active):
        p = active[a]
        count = min(wanted[p], end) - first
        if count > 0:
            some[n], counts[n] = p, count
            n, total = n + 1, total + count
        if n > 0 and (total > _BATCH or a == n_active - 1):
            if stop[0]:
                break
            own = some, n, first, counts
            traced += take_samples(task, room.work, *own, traversal, sums, room.rays)
            for k in range(n):
                sums.count[some[k]] += counts[k]
            n, total = 0, 0
    return traced


@kernel(inline="always")
def _take_round(task, n_active, first, end, traversal, sums, room, stop):
    """The same for a whole round, with the guide's lessons in between."""
    traced, guide = 0, task.guide
    while first < end and not stop[0]:
        piece = min(end, first + _BATCH)
        if len(guide.learnt) > 0:
            if first >= next_lesson(guide):
                learn(guide, first, room.guide)
                scale_products(task.products, sums.count, room.wanted, room.used, room.guide.ratio)
            piece = min(piece, next_lesson(guide))
        traced += _take_piece(task, n_active, first, piece, traversal, sums, room, stop)
        first = piece
    return traced


@kernel
def _look_ahead(task, traversal, sums, room, wanted):
    """Have the guide learn from rays that are sent ahead; how many there were."""
    own, traced = (wanted, room.some, room.counts, room.rays), np.int64(0)
    for every in (2, 1):
        n = send_scouts(task, traversal, sums, room.work, room.scouts, every, *own)
        if n == 0:
            break
        traced += n
        learn(task.guide, 1, room.guide)
        scale_products(task.products, sums.count, room.wanted, room.used, room.guide.ratio)
        if not mostly_hidden(task.guide):
            break
    return traced


@kernel(inline="always")
def _continue_block(task, traversal, rule, neighbours, sums, room, stop):
    """incremental.continue_points for one block; how many samples had a ray."""
    n = len(sums.count)
    wanted, active = room.wanted[:n], room.active
    begin_rule(rule, neighbours, sums, room.rule, wanted)
    for p in range(n):
        if not task.products.trees[task.products.own[p], 0] > np.float32(0.0):
            wanted[p] = 0
    traced, taken = np.int64(0), least_count(wanted, sums)
    if taken >= 0 and len(task.guide.learnt) > 0 and task.guide.learnt[0] == 0:
        traced += _look_ahead(task, traversal, sums, room, wanted)
    while taken >= 0 and not stop[0]:
        n_active = select_points(wanted, taken, sums, active)
        end = end_of_round(rule, taken)
        traced += _take_round(task, n_active, taken, end, traversal, sums, room, stop)
        decide_rule(rule, neighbours, active, n_active, end, sums, room.rule, wanted)
        taken = least_count(wanted, sums)
    finish_rule(rule, neighbours, sums, room.rule)
    return traced


@kernel(inline="always")
def _prepare_products(task, apart, room):
    """Build the products of a block, as its guide wants them."""
    products = task.products
    n = len(task.lobes.kind)
    given = task.lobes, n, apart, task.light, products, room.work.scratch
    build_with(room.builder, given)
    if len(task.guide.learnt) > 0 and task.guide.learnt[0] > 0:
        for p in range(n):
            if products.own[p] == p:
                scale_product(products, p, task.guide.gain[0])


@kernel
def continue_blocks(
    bounds,
    guides,
    where,
    points,
    lobes,
    apart,
    light,
    sequence,
    offset,
    traversal,
    rule,
    sums,
    room,
    stop,
):
    """Add samples to points until each has as many as the rule wants: number of rays traced.

    bounds: int32 (blocks + 1,), where blocks of points begin, at most BLOCK_POINTS each; for rule
        PERCEPTUAL whole cells, in neighbours.cell_order
    guides: of the blocks, added to; of none: nothing is learnt
    where: Places; apart: of build_products; sequence: of the points; offset: float32
    rule: stop_rule.Rule
    sums: PixelSums, added to; stop: uint8 (1,), ends it early if not 0, with what there is
    """
    traced = 0
    for block in range(len(bounds) - 1):
        a, b = bounds[block], bounds[block + 1]
        neighbours = Neighbours(room.near[: b - a], room.group[: b - a])
        own = points_at(points, a, b)
        if asks_neighbours(rule):
            own_places = where.column[a:b], where.row[a:b], where.material[a:b]
            fill_neighbours(*own_places, own.normal, room.slots, neighbours)
        part = Rule(rule.kind, rule.threshold, rule.batch, rule.typical, rule.most, rule.plan[a:b])
        task = Task(
            own,
            lobes_at(lobes, a, b),
            light,
            room.products,
            guide_of(guides, block),
            PixelSequence(sequence.points, sequence.x[a:b], sequence.y[a:b], sequence.scrambled),
            offset,
        )
        _prepare_products(task, apart, room)
        traced += _continue_block(
            task, traversal, part, neighbours, sums_at(sums, a, b), room, stop
        )
        if stop[0]:
            break
    return traced

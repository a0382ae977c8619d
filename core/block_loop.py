"""The paper's loop for mode UNBIASED, in machine code from a block's products to its sums.

A block is the points of one cell of 8 x 8 pixels (neighbours.py), whose products stay in a core's
second cache from round to round. The rounds are those of incremental.py, where the loop is written
out for any sampler; here samples are traced as soon as the lanes are full, so that nothing is
written to memory but the sums, and no round asks for Python's lock.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .incremental import PixelSums, RayBatch, least_count, new_rays, select_points
from .lobes import Lobes
from .neighbours import CELL_PX, Neighbours, fill_neighbours
from .product import Products, new_products
from .sequence import PixelSequence
from .shading import ShadingPoints
from .stop_rule import (
    PAPER_RULE,
    Rule,
    RuleRoom,
    begin_rule,
    decide_rule,
    end_of_round,
    finish_rule,
    new_rule_room,
)
from .unbiased import Task, Work, build_products, new_work, take_samples

BLOCK_POINTS = CELL_PX * CELL_PX
# Samples between two looks at the flag of a cancel: some milliseconds.
_BATCH = 8192


class Room(NamedTuple):
    """Scratch of a thread for blocks of up to BLOCK_POINTS points.

    near, group: of Neighbours; slots: of fill_neighbours; wanted, active, counts: int32 (n,)
    rays: without room, for take_samples
    """

    work: Work
    products: Products
    rule: RuleRoom
    near: np.ndarray
    group: np.ndarray
    slots: np.ndarray
    wanted: np.ndarray
    active: np.ndarray
    counts: np.ndarray
    rays: RayBatch


def new_room(glossy: bool) -> Room:
    """glossy: whether any of the points has a lobe beside Lambert's."""
    n = BLOCK_POINTS
    return Room(
        new_work(),
        new_products(n, glossy),
        new_rule_room(n),
        np.empty((n, 8), np.int32),
        np.empty(n, np.int32),
        np.empty((CELL_PX + 2, CELL_PX + 2), np.int32),
        *(np.empty(n, np.int32) for _ in range(3)),
        new_rays(0),
    )


class Places(NamedTuple):
    """Where the points are: column and row of their pixels in the frame, material; int32 (n,)."""

    column: np.ndarray
    row: np.ndarray
    material: np.ndarray


@kernel
def _points_at(points, a, b):
    return ShadingPoints(
        points.pixel[a:b],
        points.triangle[a:b],
        points.position[a:b],
        points.wo[a:b],
        points.geometric_normal[a:b],
        points.normal[a:b],
        points.lift[a:b],
        points.lift_below[a:b],
    )


@kernel
def _lobes_at(lobes, a, b):
    return Lobes(
        lobes.kind[a:b],
        lobes.distribution[a:b],
        lobes.alpha[a:b],
        lobes.diffuse[a:b],
        lobes.weight[a:b],
        lobes.f0[a:b],
        lobes.edge[a:b],
        lobes.fresnel[a:b],
        lobes.normal[a:b],
        lobes.glossy_normal[a:b],
        lobes.wo[a:b],
        lobes.cos_o[a:b],
        lobes.seen[a:b],
        lobes.diffuse_share[a:b],
        lobes.glossy_color[a:b],
        lobes.emission[a:b],
    )


@kernel
def _sums_at(sums, a, b):
    return PixelSums(
        sums.count[a:b],
        sums.visible[a:b],
        sums.diffuse[a:b],
        sums.glossy[a:b],
        sums.unoccluded[a:b],
        sums.seen[a:b],
        sums.seen_squared[a:b],
        sums.error[a:b],
    )


@kernel
def _take_round(task, n_active, taken, traversal, sums, room, stop):
    """Samples from ``taken`` on of all active points, a batch after another; how many had a ray."""
    active, counts, first, traced = room.active, room.counts, 0, 0
    while first < n_active and not (first > 0 and stop[0]):
        last, total = first + 1, counts[first]
        while last < n_active and total + counts[last] <= _BATCH:
            total += counts[last]
            last += 1
        some, own, n = active[first:last], counts[first:last], last - first
        traced += take_samples(task, room.work, some, n, taken, own, traversal, sums, room.rays)
        for a in range(first, last):
            sums.count[active[a]] += counts[a]
        first = last
    return traced


@kernel
def _continue_block(task, traversal, rule, neighbours, sums, room, stop):
    """incremental.continue_points for one block; how many samples had a ray."""
    n = len(sums.count)
    wanted, active, counts = room.wanted[:n], room.active, room.counts
    begin_rule(rule, neighbours, sums, room.rule, wanted)
    for p in range(n):
        if not task.products.trees[p, 0] > np.float32(0.0):
            wanted[p] = 0
    traced, taken = 0, least_count(wanted, sums)
    while taken >= 0 and not stop[0]:
        n_active = select_points(wanted, taken, sums, active)
        end = min(end_of_round(rule, taken), taken + _BATCH)
        for a in range(n_active):
            counts[a] = min(wanted[active[a]], end) - taken
        traced += _take_round(task, n_active, taken, traversal, sums, room, stop)
        decide_rule(rule, neighbours, active, n_active, end, sums, room.rule, wanted)
        taken = least_count(wanted, sums)
    finish_rule(rule, neighbours, sums, room.rule)
    return traced


@kernel
def continue_blocks(
    bounds, places, points, lobes, light, sequence, offset, traversal, rule, sums, room, stop
):
    """Add samples to points until each has as many as the rule wants: number of rays traced.

    bounds: int32 (blocks + 1,), where blocks of points begin, at most BLOCK_POINTS each; for rule
        PERCEPTUAL whole cells, in neighbours.cell_order
    places: Places; sequence: of the points; offset: float32; rule: stop_rule.Rule, without a plan
    sums: PixelSums, added to; stop: uint8 (1,), ends it early if not 0, with what there is
    """
    traced = 0
    for block in range(len(bounds) - 1):
        a, b = bounds[block], bounds[block + 1]
        neighbours = Neighbours(room.near[: b - a], room.group[: b - a])
        own = _points_at(points, a, b)
        if rule.kind != PAPER_RULE:
            where = places.column[a:b], places.row[a:b], places.material[a:b]
            fill_neighbours(where[0], where[1], where[2], own.normal, room.slots, neighbours)
        part = Rule(rule.kind, rule.threshold, rule.batch, rule.typical, rule.most, rule.plan[a:b])
        task = Task(
            own,
            _lobes_at(lobes, a, b),
            light,
            room.products,
            PixelSequence(sequence.points, sequence.x[a:b], sequence.y[a:b], sequence.scrambled),
            offset,
        )
        build_products(task.lobes, light, room.products, room.work.scratch)
        traced += _continue_block(
            task, traversal, part, neighbours, _sums_at(sums, a, b), room, stop
        )
        if stop[0]:
            break
    return traced

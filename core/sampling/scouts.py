"""A block's first rays, which tell its guide what is free and count for nothing else.

Samples that are taken before anything is learnt are the worst that a point has: in a room behind
whose wall the sun stands nearly all of them go there, and the few that find the window weigh as
much as all the others together. So every other pixel sends a ray ahead, and where most of these are
stopped, each point sends one more, by what they have told. Their places in the square are a net
over the block [Roberts18], and have nothing to do with those of the points' samples, which are as
unbiased as ever. docs/decisions/0016-learnt-visibility.md has the figures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..unit_square.sequence import PixelSequence
from .incremental import PixelSums, new_sums
from .unbiased import Task, take_samples

_WORTH = 8  # samples that a point wants at the least to send one
_HIDDEN = 0.25  # of the first ones are free, or fewer: more are sent
# From a scout's place to the next one's, as parts of 2^32: powers of the plastic number.
_STEP_X, _STEP_Y = np.uint32(0xC13FA9A9), np.uint32(0x91E10DA6)
_OTHER = np.uint32(0x9E3779B9)  # makes another number of a pixel's hash


class ScoutRoom(NamedTuple):
    """Scratch. thrown: sums of n points, which nobody reads; x, y: uint32 (n,), places in the
    square; start: uint32 (1, 2), zeros, the common point of sequences that are all shift."""

    thrown: PixelSums
    start: np.ndarray
    x: np.ndarray
    y: np.ndarray


def new_scout_room(n: int) -> ScoutRoom:
    """For blocks of up to n points."""
    return ScoutRoom(
        new_sums(n), np.zeros((1, 2), np.uint32), np.zeros(n, np.uint32), np.zeros(n, np.uint32)
    )


@kernel(forceinline=True)
def mostly_hidden(guide):
    """Whether so few of the rays that it knows of were free that more should be sent ahead."""
    return np.sum(guide.free[0]) < _HIDDEN * np.sum(guide.asked[0])


@kernel
def send_scouts(task, traversal, sums, work, room, every, wanted, some, counts, rays):
    """Have a ray of one of ``every`` pixels noted in the task's guide; how many rays there were.

    Of a pixel's points in the block, which follow each other, it is the first's, that of its first
    pass; where every pixel sends some, all of them do.
    sums, wanted: of the points; work, some, counts, rays: scratch, of take_samples
    """
    n, pixels, own, pixel = np.int64(0), np.int64(0), room, task.points.pixel
    x, y = task.sequence.x[0] ^ _OTHER, task.sequence.y[0] ^ np.uint32(_OTHER * np.uint32(every))
    for p in range(len(sums.count)):
        if every > 1 and p > 0 and pixel[p] == pixel[p - 1]:
            continue
        pixels += 1
        if pixels % every == 0 and wanted[p] - sums.count[p] >= _WORTH:
            some[n], counts[n] = p, 1
            x, y = np.uint32(x + _STEP_X), np.uint32(y + _STEP_Y)
            own.x[p], own.y[p] = x, y
            n += 1
    if n == 0:
        return n
    places = PixelSequence(own.start, own.x, own.y, n < 0)
    points, lobes, light, products, guide, _, offset = task
    scouts = Task(points, lobes, light, products, guide, places, offset)
    first = np.int64(0)
    return take_samples(scouts, work, some, n, first, counts, traversal, own.thrown, rays)

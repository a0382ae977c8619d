"""The order in which a point's samples are taken: neighbours in the square one after another.

Rays that follow each other then go the same way through Embree's hierarchy, and lanes read the same
lines of the product and the light. Which parts of the square samples fall into is the same for all
points but for Owen's scramble, which only swaps halves: one order serves a whole block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel

MOST_ORDERED = 8192  # samples at once: a block's batch (block_loop.py)
_DIGITS = 4  # of a coordinate: 256 parts of the square
_PARTS = 1 << (2 * _DIGITS)
_FEW = 8  # go through Embree at once, whatever their order
_ONE, _TWO, _TOP = np.uint32(1), np.uint32(2), np.uint32(31)


class SampleOrder(NamedTuple):
    """Scratch: int32 (MOST_ORDERED,), samples; uint8, their parts; int32, where parts begin."""

    samples: np.ndarray
    part: np.ndarray
    begin: np.ndarray


def new_sample_order() -> SampleOrder:
    """One a thread."""
    return SampleOrder(
        np.zeros(MOST_ORDERED, np.int32),
        np.zeros(MOST_ORDERED, np.uint8),
        np.zeros(_PARTS + 1, np.int32),
    )


@kernel
def _part_of(sequence, k):
    """Digits of sample k's y and x in turn, the greatest first."""
    x, y, part = sequence.points[k, 0], sequence.points[k, 1], np.uint32(0)
    for digit in range(_DIGITS):
        # Bits that are to be scrambled stand in reverse order.
        at = np.uint32(digit) if sequence.scrambled else _TOP - np.uint32(digit)
        part = np.uint32((part << _TWO) | (((y >> at) & _ONE) << _ONE) | ((x >> at) & _ONE))
    return part


@kernel
def order_samples(sequence, first, count, order):
    """Write first ... first + count - 1 to order.samples, by parts of the square they fall into.

    sequence: PixelSequence; count: at most MOST_ORDERED; order: SampleOrder
    """
    samples, part, begin = order.samples, order.part, order.begin
    if count <= _FEW:
        for k in range(count):
            samples[k] = first + k
        return
    begin[:] = 0
    for k in range(count):
        part[k] = _part_of(sequence, first + k)
        begin[np.int64(part[k]) + 1] += 1
    for k in range(_PARTS):
        begin[k + 1] += begin[k]
    for k in range(count):
        samples[begin[part[k]]] = first + k
        begin[part[k]] += 1

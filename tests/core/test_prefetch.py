"""Asking for memory ahead of its use."""

import numpy as np

from iwis.core._jit import kernel
from iwis.core.machine.prefetch import fetch


@kernel
def _sum_fetched(numbers, offsets):
    for k in range(len(offsets)):
        fetch(numbers, offsets[k])
    total = 0.0
    for k in range(len(numbers)):
        total += numbers[k]
    return total


def test_any_offset_will_do():
    """A NaN may have become an index: nothing is read, so nothing fails."""
    numbers = np.ones(100, np.float32)
    offsets = np.array([0, 396, -(2**40), 2**40, 2**62, -(2**62)], np.int64)
    assert _sum_fetched(numbers, offsets) == 100.0

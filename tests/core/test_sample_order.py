"""The order of a point's samples: all of them once, neighbours together."""

import numpy as np
import pytest

from iwis.core.unit_square.sample_order import MOST_ORDERED, new_sample_order, order_samples
from iwis.core.unit_square.sequence import common_points, pixel_sequence, sequence_point


def _sequence(decorrelation, count):
    pixel = np.arange(3, dtype=np.int32)
    return pixel_sequence(common_points(count, decorrelation), pixel, (5, 7, 3), 1, decorrelation)


def _ordered(sequence, first, count):
    order = new_sample_order()
    order_samples(sequence, first, count, order)
    return order.samples[:count]


@pytest.mark.parametrize("decorrelation", ["OWEN", "PIXEL", "NONE"])
@pytest.mark.parametrize("first, count", [(0, 1), (2, 6), (8, 24), (32, 96), (100, MOST_ORDERED)])
def test_each_sample_comes_once(decorrelation, first, count):
    """Whatever the first one and the count."""
    found = _ordered(_sequence(decorrelation, 9000), first, count)
    np.testing.assert_array_equal(np.sort(found), np.arange(first, first + count))


@pytest.mark.parametrize("decorrelation", ["OWEN", "NONE"])
def test_neighbours_in_the_square_follow_each_other(decorrelation):
    """Four fourths of the order lie in four fourths of the square, in every pixel."""
    sequence = _sequence(decorrelation, 256)
    found = _ordered(sequence, 64, 64)
    for p in range(3):
        points = np.array([sequence_point(sequence, p, k) for k in found])
        for part in points.reshape(4, 16, 2):
            size = np.ptp(part, axis=0)
            # Halton's second number has digits in base 3: a few of 16 may stand elsewhere.
            assert size.max() < 0.5 if decorrelation == "OWEN" else np.median(size) < 0.6

"""core/unit_square/halton.py: the points are Halton's, and pixels get numbers of their own."""

import numpy as np
import pytest

from iwis.core.unit_square.halton import (
    halton_table,
    hash_pixel,
    radical_inverse_2,
    radical_inverse_3,
)
from support.naive import radical_inverse
from support.statistics import chi2_p_value, sidak


def test_radical_inverse_2_mirrors_binary_digits():
    """Exact: every result is a binary fraction."""
    for index in [*range(300), 65535, 65536, 2**31, 2**32 - 1]:
        assert radical_inverse_2(index) == radical_inverse(index, 2)


def test_radical_inverse_3_mirrors_ternary_digits():
    """To rounding: thirds are no binary fractions."""
    for index in [*range(300), 3**12, 3**12 - 1, (1 << 20)]:
        assert radical_inverse_3(index) == pytest.approx(radical_inverse(index, 3), abs=1e-15)


def test_table_starts_at_index_one_and_is_incremental():
    """The origin is left out; a longer table begins with the shorter one."""
    short, long = np.empty((10, 2)), np.empty((100, 2))
    halton_table(10, short)
    halton_table(100, long)
    np.testing.assert_array_equal(long[:10], short)
    np.testing.assert_allclose(
        short[:4], [[1 / 2, 1 / 3], [1 / 4, 2 / 3], [3 / 4, 1 / 9], [1 / 8, 4 / 9]]
    )
    assert 0.0 < long.min() and long.max() < 1.0


@pytest.mark.statistical
def test_hashes_are_uniform_and_independent_of_neighbours():
    """Pairs of a pixel's two shifts, of its neighbour, and of the next seed fill the square evenly.

    alpha 1e-3 over the three tests; the twin, whose second number depends on the first by 5 %,
    is rejected.
    """
    alpha = sidak(1e-3, 3)
    side, cells = 256, 16
    first = np.array([[hash_pixel(x, y, 0, 1) for x in range(side)] for y in range(side)])
    second = np.array([[hash_pixel(x, y, 0, 2) for x in range(side)] for y in range(side)])
    reseeded = np.array([[hash_pixel(x, y, 1, 1) for x in range(side)] for y in range(side)])

    def p_value(a, b):
        counts, _, _ = np.histogram2d(a.ravel(), b.ravel(), cells, [[0, 1], [0, 1]])
        return chi2_p_value(counts, np.full(counts.shape, counts.sum() / cells**2))

    assert p_value(first, second) > alpha
    assert p_value(first[:, ::2], first[:, 1::2]) > alpha
    assert p_value(first, reseeded) > alpha
    assert p_value(first, 0.95 * second + 0.05 * first) < alpha


def test_hashes_lie_in_the_unit_interval():
    """0 <= h < 1 also for the largest pixels and seeds."""
    for x in (0, 1, 65535):
        for seed in (0, (1 << 31) - 1):
            assert 0.0 <= hash_pixel(x, 65535, seed, 2) < 1.0

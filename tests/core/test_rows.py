"""core/data/rows.py: rows of columns."""

import numpy as np
import pytest

from iwis.core.data.rows import any_in_row, row_and_column, row_maxima, row_means, rows_of

WAYS = [slice(3, 7), np.arange(20) % 3 == 1, np.array([4, 4, 0, 19]), [2, 5], np.zeros(0, np.int64)]


@pytest.mark.parametrize("which", WAYS, ids=["slice", "mask", "indices", "list", "none"])
def test_rows_are_those_that_indexing_takes(which, rng):
    columns = rng.random(20), rng.random((20, 3)), rng.random((20, 2, 3)), rng.random((3, 20)).T
    for found, column in zip(rows_of(columns, which), columns, strict=True):
        np.testing.assert_array_equal(found, column[which])
        assert found.flags.c_contiguous


def test_what_rows_of_three_say(rng):
    vectors = rng.integers(-1, 2, (500, 3)).astype(np.float32)
    np.testing.assert_array_equal(any_in_row(vectors), vectors.any(axis=1))
    np.testing.assert_allclose(row_means(vectors), vectors.mean(axis=1), atol=1e-7)
    np.testing.assert_array_equal(row_maxima(vectors), vectors.max(axis=1))


def test_place_is_a_row_and_a_column():
    rows, columns = row_and_column(np.arange(35, dtype=np.int32), np.int32(7))
    assert rows.dtype == columns.dtype == np.int32
    np.testing.assert_array_equal(7 * rows + columns, np.arange(35))
    assert columns.max() == 6 and rows.max() == 4

"""Some rows of tables that are kept as columns."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def rows_of(columns: Iterable[np.ndarray], which) -> list[np.ndarray]:
    """Rows of each array, C-contiguous. which: a slice, a mask, bool (n,), or indices, int (m,).

    NumPy takes a mask or indices from (n, 3) in three times as long as its take() does.
    """
    if isinstance(which, slice):
        return [np.ascontiguousarray(column[which]) for column in columns]
    which = np.asarray(which)
    if which.dtype == np.bool_:
        which = np.flatnonzero(which)
    return [column[which] if column.ndim == 1 else column.take(which, axis=0) for column in columns]


def any_in_row(vectors: np.ndarray) -> np.ndarray:
    """bool (n,): whether any number of a row of (n, 3) is not 0. NumPy's any() takes five times as
    long along rows of three, and so do its sums and means."""
    return (vectors[:, 0] != 0) | (vectors[:, 1] != 0) | (vectors[:, 2] != 0)


def row_means(vectors: np.ndarray) -> np.ndarray:
    """float32 (n,) or (): means of float32 (n, 3) or (3,)."""
    return (vectors[..., 0] + vectors[..., 1] + vectors[..., 2]) * np.float32(1.0 / 3.0)


def row_maxima(vectors: np.ndarray) -> np.ndarray:
    """(n,): the largest number of each row of (n, 3)."""
    return np.maximum(np.maximum(vectors[:, 0], vectors[:, 1]), vectors[:, 2])


def row_and_column(place: np.ndarray, width) -> tuple[np.ndarray, np.ndarray]:
    """Of places in a picture of that width, row by row, int (n,); divmod takes three times as
    long."""
    rows = place // width
    return rows, place - rows * width

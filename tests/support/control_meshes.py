"""Small control meshes for tests of subdivision."""

import numpy as np

from iwis.core.fine_meshes.subdivision import Control, make_control

_CUBE = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def cube(scale=(1.0, 1.0, 1.0)) -> Control:
    """From -1 to 1 times a scale, its faces outwards."""
    axes = np.mgrid[-1:2:2, -1:2:2, -1:2:2].reshape(3, -1).T
    corners = np.array(_CUBE, np.int32).ravel()
    return make_control(axes * scale, corners, np.arange(0, 25, 4, dtype=np.int32))


def grid(n, height) -> Control:
    """n x n quads from -n to n, that face up, of a height(x, y)."""
    y, x = np.mgrid[-n : n + 1 : 2, -n : n + 1 : 2].astype(np.float64)
    points = np.stack([x, y, height(x, y)], -1).reshape(-1, 3)
    row, column = np.mgrid[0:n, 0:n].reshape(2, -1)
    first = row * (n + 1) + column
    corners = np.stack([first, first + 1, first + n + 2, first + n + 1], -1).astype(np.int32)
    return make_control(points, corners.ravel(), np.arange(0, 4 * n * n + 1, 4, dtype=np.int32))


def quads_of(control: Control) -> np.ndarray:
    """int32 (f, 4)"""
    return control.corners.reshape(-1, 4)

"""The low-discrepancy points of each pixel: Halton's, moved by a shift of the pixel's own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .halton import halton_table, hash_pixel
from .shading import ShadingPoints


class PointShifts(NamedTuple):
    """The Cranley-Patterson shift of each shading point: x, y float64 (n,)."""

    x: np.ndarray
    y: np.ndarray


@kernel
def _fill_shifts(pixel, width, x0, y0, seed, shifts):
    for k in range(len(pixel)):
        column, row = x0 + pixel[k] % width, y0 + pixel[k] // width
        shifts.x[k] = hash_pixel(column, row, seed, 1)
        shifts.y[k] = hash_pixel(column, row, seed, 2)


def point_shifts(points: ShadingPoints, tile, seed: int, decorrelation: str) -> PointShifts:
    """Each point's shift, from its place in the frame and the seed; zero for NONE.

    tile: (x, y, width) of the pixels in the frame
    """
    n = len(points.pixel)
    shifts = PointShifts(np.zeros(n), np.zeros(n))
    if decorrelation == "PIXEL":
        x, y, width = tile
        _fill_shifts(points.pixel, width, x, y, seed, shifts)
    return shifts


def halton_points(count: int) -> np.ndarray:
    """float64 (count, 2): the points that all pixels shift."""
    table = np.empty((count, 2))
    halton_table(count, table)
    return table


@kernel(forceinline=True)
def shifted_point(halton, shifts, p, k):
    """(x, y), float64 in [0, 1): sample k of shading point p."""
    x, y = halton[k, 0] + shifts.x[p], halton[k, 1] + shifts.y[p]
    return x - np.floor(x), y - np.floor(y)


@kernel(forceinline=True)
def sample_number(shifts, p, k):
    """A number in [0, 1) of sample k of point p, apart from its Halton point."""
    u = shifts.x[p] + shifts.y[p] + k * 0.6180339887498949
    return u - np.floor(u)

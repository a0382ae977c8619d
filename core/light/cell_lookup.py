"""The light in one cell of the square, by looking the map up at points of the cell."""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..bsdf.luminance import magnitude
from .environment import eval_map, map_coordinates
from .pyramid import row_column_to_morton

LARGEST = np.float32(1e17)  # its square is still a float32
_MOST_PARTS = 16  # of a cell's side


@kernel(forceinline=True)
def square_to_direction(x, y):
    """square_to_sphere in float32 without library calls: error below 1e-6."""
    one, half = np.float32(1.0), np.float32(0.5)
    u, v = x + x - one, y + y - one
    abs_u, abs_v = abs(u), abs(v)
    signed = one - abs_u - abs_v
    r = one - abs(signed)
    turn = (abs_v - abs_u) / r if r > np.float32(0.0) else np.float32(0.0)
    a = turn * np.float32(0.25 * math.pi)  # the angle less pi / 4
    s = a * a
    sine = a * (
        one + s * (np.float32(-1 / 6) + s * (np.float32(1 / 120) - s * np.float32(1 / 5040)))
    )
    cosine = one + s * (
        np.float32(-0.5)
        + s * (np.float32(1 / 24) + s * (np.float32(-1 / 720) + s * np.float32(1 / 40320)))
    )
    radius = r * np.sqrt(max(np.float32(2.0) - r * r, np.float32(0.0))) * np.sqrt(half)
    dx, dy = (cosine - sine) * radius, (cosine + sine) * radius
    dz = one - r * r
    return math.copysign(dx, u), math.copysign(dy, v), math.copysign(dz, signed)


@kernel(forceinline=True)
def _wrapped(difference):
    difference = abs(difference)
    return min(difference, np.float32(1.0) - difference)


@kernel(forceinline=True)
def footprint(lookup, x, y, size):
    """Texels along the longest side of a cell whose corner is (x, y)."""
    height, width = lookup.texels.shape[0], lookup.texels.shape[1]
    most = np.float32(0.0)
    dx, dy, dz = square_to_direction(x, y)
    u0, v0 = map_coordinates(lookup, dx, dy, dz)
    first_u, first_v = u0, v0
    for side in range(1, 5):
        if side == 4:
            u, v = first_u, first_v
        else:
            far_x, far_y = np.float32(side == 1 or side == 2), np.float32(side >= 2)
            dx, dy, dz = square_to_direction(x + far_x * size, y + far_y * size)
            u, v = map_coordinates(lookup, dx, dy, dz)
        across, up = _wrapped(u - u0) * np.float32(width), _wrapped(v - v0) * np.float32(height)
        most = max(most, max(across, up))
        u0, v0 = u, v
    return most


@kernel(forceinline=True)
def look_up_cell(lookup, x, y, size, n):
    """(mean, mean square, largest) of magnitude at the corners and centres of n^2 parts of a cell.

    x, y: float32, the cell's corner; size: of its side, in the square. Corners see light that
    reaches just into a cell.
    """
    total = square = brightest = np.float32(0.0)
    part = np.float32(0.5) * size / np.float32(n)
    for i in range(2 * n + 1):
        for j in range(i % 2, 2 * n + 1, 2):
            dx, dy, dz = square_to_direction(x + np.float32(j) * part, y + np.float32(i) * part)
            u, v = map_coordinates(lookup, dx, dy, dz)
            r, g, b = eval_map(lookup, u, v)
            value = magnitude(r, g, b)
            on_edge = (i % (2 * n) == 0) + (j % (2 * n) == 0)
            weight = np.float32(1.0) if on_edge == 0 else np.float32(0.5 if on_edge == 1 else 0.25)
            bounded = min(value, LARGEST)
            total += weight * value
            square += weight * bounded * bounded
            brightest = max(brightest, value)
    scale = np.float32(0.5) / np.float32(n * n)
    return total * scale, square * scale, brightest


@kernel
def look_up_cells(lookup, level, first, last, cells):
    side = 1 << level
    size = np.float32(1.0 / side)
    for index in range(first, last):
        row, column = index // side, index % side
        x, y = np.float32(column) * size, np.float32(row) * size
        n = max(1, min(_MOST_PARTS, int(footprint(lookup, x, y, size)) + 1))
        cell = row_column_to_morton(row, column, level)
        cells[cell, 0], cells[cell, 1], _ = look_up_cell(lookup, x, y, size, n)

"""What surfaces let through, at places on them: grids over triangles, and what is between corners.

opacity.py makes them, Embree's filter (embree_filter.py) asks them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..machine.addresses import get_byte, get_float

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_DIRECTION = 4  # row of RTCRayN; of RTCHitN the first three are the face's normal
# A grid for each of so many cosines of the angle between ray and normal, (k / BENDS)^2, as what
# mirrors bends most where it is seen flat: of rays that meet the front, then of those at the back.
BENDS = 32
ANGLES = 2 * (BENDS + 1)


class Opacity(NamedTuple):
    """Grids of a mesh's triangles.

    row: int32 (triangles,), which grid; -1: opaque
    start: int64 (grids,), where each begins in values; side: int32 (grids,), R
    values: uint8, of 255 what passes at the corners: for each step v, R + 1 - v of them along u
    angled: uint8 (grids,), whether there are ANGLES such grids one after another
    normals: float32 (triangles, 3, 3), of the corners, where any is; else of none
    colored: whether there are three of all this one after another, red, green, blue
    """

    row: np.ndarray
    start: np.ndarray
    side: np.ndarray
    values: np.ndarray
    angled: np.ndarray
    normals: np.ndarray
    colored: bool = False

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """What a filter reads, in one piece each."""
        return tuple(np.ascontiguousarray(array) for array in self[:6])

    def among(self, rows: np.ndarray) -> Opacity:
        """The grids of some of the triangles, int (k,)."""
        normals = self.normals[rows] if len(self.normals) else self.normals
        return self._replace(row=self.row[rows], normals=normals)

    def same(self, other: Opacity | None) -> bool:
        """Whether two are equal."""
        return other is not None and all(map(np.array_equal, self, other))


@kernel
def _between_corners(values, start, side, u, v):
    """float32, of 255: what a grid lets through at (u, v)."""
    x, y = u * np.float32(side), v * np.float32(side)
    column, row = min(int(x), side - 1), min(int(y), side - 1)
    row = max(min(row, side - 1 - column), 0)
    x, y = x - np.float32(column), y - np.float32(row)
    below = start + row * (side + 1) - row * (row - 1) // 2 + column
    above = below + side + 1 - row
    right, up = np.float32(get_byte(values + below + 1)), np.float32(get_byte(values + above))
    if x + y <= _ONE or column + row + 1 >= side:
        here = np.float32(get_byte(values + below))
        return here + x * (right - here) + y * (up - here)
    there = np.float32(get_byte(values + above + 1))
    return there + (_ONE - x) * (up - there) + (_ONE - y) * (right - there)


@kernel
def angle_of(ray, hit, row, normals, u, v):
    """(row of the grid before the cosine of a ray to the normal, how far that is to the next)."""
    along = across = front = length = _ZERO
    for axis in range(3):
        d = get_float(ray + (_DIRECTION + axis) * row)
        a, b = get_float(normals + 4 * axis), get_float(normals + 12 + 4 * axis)
        normal = a + u * (b - a) + v * (get_float(normals + 24 + 4 * axis) - a)
        front += d * get_float(hit + axis * row)
        along, across, length = along + d * normal, across + normal * normal, length + d * d
    size = across * length
    cosine = min(abs(along) / np.sqrt(size), _ONE) if size > _ZERO else _ONE
    place = np.sqrt(cosine) * np.float32(BENDS)
    before = min(int(place), BENDS - 1)
    beyond = place - np.float32(before)
    return before if front < _ZERO else before + BENDS + 1, beyond


@kernel
def passes_at(values, start, side, u, v, angle, beyond):
    """_between_corners between two of the grids that follow each other; angle < 0: there is one."""
    if angle < 0:
        return _between_corners(values, start, side, u, v)
    start += angle * ((side + 1) * (side + 2) // 2)
    here = _between_corners(values, start, side, u, v)
    there = _between_corners(values, start + (side + 1) * (side + 2) // 2, side, u, v)
    return here + beyond * (there - here)

"""A place on the faces of a MESH that a point sees, its density, and where a direction meets them.

A place is uniform over the area of all faces, as all have one radiance; the face is found by
bisection of the areas' running sum and not by an alias table: so even numbers lie evenly over the
mesh, and the search costs less than the shadow ray. float64, as the other shapes.
"""

from __future__ import annotations

import math

import numpy as np

from ._jit import kernel
from .lamps import BLOCK

_NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel(forceinline=True)
def _corner(corners, k, c, px, py, pz):
    """A corner of face k, from a point."""
    return (
        np.float64(corners[k, c, 0]) - px,
        np.float64(corners[k, c, 1]) - py,
        np.float64(corners[k, c, 2]) - pz,
    )


@kernel(forceinline=True)
def _less(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel(forceinline=True)
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel(forceinline=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(forceinline=True)
def _face_at(area, first, end, where):
    """The first of rows first ... end - 1 whose running sum is above ``where``."""
    while end - first > 1:
        middle = (first + end) // 2
        if area[middle - 1] > where:
            end = middle
        else:
            first = middle
    return first


@kernel
def sample_mesh(lamps, i, px, py, pz, a, b):
    """sample_lamp of a MESH."""
    area, first, end = lamps.faces.area, lamps.span[i, 0], lamps.span[i, 1]
    whole = area[end - 1]
    k = _face_at(area, first, end, a * whole)
    before = area[k - 1] if k > first else 0.0
    a = min(max((a * whole - before) / max(area[k] - before, 1e-300), 0.0), 1.0)
    origin = _corner(lamps.faces.corners, k, 0, px, py, pz)
    side = _less(_corner(lamps.faces.corners, k, 1, px, py, pz), origin)
    other = _less(_corner(lamps.faces.corners, k, 2, px, py, pz), origin)
    root = math.sqrt(a)
    u, v = root * (1.0 - b), root * b
    x = origin[0] + u * side[0] + v * other[0]
    y = origin[1] + u * side[1] + v * other[1]
    z = origin[2] + u * side[2] + v * other[2]
    normal = _cross(side, other)
    far = math.sqrt(x * x + y * y + z * z)
    length = math.sqrt(_dot(normal, normal))
    flat = abs(_dot(normal, (x, y, z)))  # far x length x cosine
    if not flat > 1e-9 * far * length:
        return _NOTHING
    scale = 1.0 / far
    return x * scale, y * scale, z * scale, far, 1.0, far * far * far * length / (flat * whole)


@kernel(forceinline=True)
def _meet_face(corners, k, px, py, pz, ray):
    """(distance along a ray to face k, cosine) [Moller97]; 0: it misses."""
    origin = _corner(corners, k, 0, px, py, pz)
    side = _less(_corner(corners, k, 1, px, py, pz), origin)
    other = _less(_corner(corners, k, 2, px, py, pz), origin)
    normal = _cross(side, other)
    length, slope = math.sqrt(_dot(normal, normal)), _dot(normal, ray)
    if not abs(slope) > 1e-9 * length:
        return 0.0, 0.0
    turned = _cross(origin, ray)
    u, v = _dot(turned, other) / slope, -_dot(turned, side) / slope
    if u < 0.0 or v < 0.0 or u + v > 1.0:
        return 0.0, 0.0
    return _dot(origin, normal) / slope, abs(slope) / length


@kernel
def meet_mesh(lamps, i, px, py, pz, dx, dy, dz):
    """meet_lamp of a MESH: its nearest face."""
    faces, ray = lamps.faces, (dx, dy, dz)
    nearest, cosine = np.inf, 1.0
    for block in range(lamps.span[i, 0] // BLOCK, lamps.span[i, 1] // BLOCK):
        ball, radius = faces.balls[block], faces.balls[block, 3]
        x, y, z = ball[0] - px, ball[1] - py, ball[2] - pz
        along = _dot((x, y, z), ray)
        if along < -radius or x * x + y * y + z * z - along * along > radius * radius:
            continue
        for k in range(block * BLOCK, block * BLOCK + BLOCK):
            far, slope = _meet_face(faces.corners, k, px, py, pz, ray)
            if 0.0 < far < nearest:
                nearest, cosine = far, slope
    if nearest == np.inf:
        return 0.0, 0.0, 0.0
    return nearest, 1.0, nearest * nearest / (cosine * faces.area[lamps.span[i, 1] - 1])

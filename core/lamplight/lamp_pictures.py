"""Lamps whose light varies over them: a picture on the lamp's own UV map, a factor of its radiance.

The map is Cycles': of an area from its lower left corner, seen from its front; of a spot the plane
across its axis, as far as its cone goes; of points, and of spots too wide for a plane, the sphere
around them. A lamp with a radius has its picture on its surface; where it has none, or always
faces whoever looks at it, a direction sees the place that it leaves from. What tells by direction,
as a luminaire's table or a spot's UV map, is on the sphere of directions, or a spot's plane,
whatever the lamp.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..data.lamps import ELLIPSE, PLANE_EDGE, RECTANGLE, SPHERE

_ZERO = np.float32(0.0)


@kernel(forceinline=True)
def _dot(vectors, i, x, y, z):
    return (
        np.float64(vectors[i, 0]) * x
        + np.float64(vectors[i, 1]) * y
        + np.float64(vectors[i, 2]) * z
    )


@kernel(forceinline=True)
def _on_sphere(x, y, z):
    """Place on the map of directions, u and v."""
    length = math.sqrt(max(x * x + y * y + z * z, 1e-60))
    v = 1.0 - math.acos(min(max(z / length, -1.0), 1.0)) / math.pi
    return 0.5 * (1.0 - math.atan2(x, y) / math.pi), v


@kernel(forceinline=True)
def _on_plane(lamps, i, x, y, z):
    """Place on the plane across a spot's axis, of a direction from it."""
    m, edge = lamps.to_cone, np.float64(lamps.cone[i, 0])
    a = m[i, 0, 0] * x + m[i, 0, 1] * y + m[i, 0, 2] * z
    b = m[i, 1, 0] * x + m[i, 1, 1] * y + m[i, 1, 2] * z
    c = m[i, 2, 0] * x + m[i, 2, 1] * y + m[i, 2, 2] * z
    scale = 0.5 * edge / (math.sqrt(max(1.0 - edge * edge, 1e-12)) * max(-c, 1e-12))
    return 0.5 + a * scale, 0.5 + b * scale


@kernel(forceinline=True)
def _place(lamps, i, px, py, pz, dx, dy, dz, far):
    """(u, v, whether u goes round) where a ray from p along d meets lamp i."""
    kind, size = lamps.kind[i], lamps.size
    x = px + dx * far - np.float64(lamps.position[i, 0])
    y = py + dy * far - np.float64(lamps.position[i, 1])
    z = pz + dz * far - np.float64(lamps.position[i, 2])
    by_direction = lamps.picture[i, 3] != 0
    if (kind == RECTANGLE or kind == ELLIPSE) and not by_direction:
        u = 0.5 + _dot(lamps.right, i, x, y, z) / np.float64(size[i, 0])
        return u, 0.5 + _dot(lamps.up, i, x, y, z) / np.float64(size[i, 1]), False
    if by_direction or kind != SPHERE or size[i, 0] == _ZERO:
        x, y, z = -dx, -dy, -dz
        if lamps.cone[i, 0] > PLANE_EDGE:
            u, v = _on_plane(lamps, i, x, y, z)
            return u, v, False
    right, up = _dot(lamps.right, i, x, y, z), _dot(lamps.up, i, x, y, z)
    u, v = _on_sphere(right, up, -_dot(lamps.forward, i, x, y, z))
    return u, v, True


@kernel(forceinline=True)
def _column(place, width, goes_round):
    """(a column, the next one, how far on the way to it)."""
    place = place * width - 0.5
    first = math.floor(place)
    part, k = place - first, np.int64(first)
    if goes_round:
        return k % width, (k + 1) % width, part
    return min(max(k, 0), width - 1), min(max(k + 1, 0), width - 1), part


@kernel(forceinline=True)
def tint_at(lamps, i, px, py, pz, dx, dy, dz, far):
    """(r, g, b), the factor of lamp i's radiance where a ray from p along d meets it."""
    first, width, height = lamps.picture[i, 0], lamps.picture[i, 1], lamps.picture[i, 2]
    if width == 0:
        return 1.0, 1.0, 1.0
    u, v, goes_round = _place(lamps, i, px, py, pz, dx, dy, dz, far)
    if not (abs(u) < 1e6 and abs(v) < 1e6):
        return 0.0, 0.0, 0.0
    a, b, s = _column(u, width, goes_round)
    c, d, t = _column(v, height, False)
    own, c, d = lamps.texels, first + c * width, first + d * width
    w, x, y, z = (1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t
    return (
        w * own[c + a, 0] + x * own[c + b, 0] + y * own[d + a, 0] + z * own[d + b, 0],
        w * own[c + a, 1] + x * own[c + b, 1] + y * own[d + a, 1] + z * own[d + b, 1],
        w * own[c + a, 2] + x * own[c + b, 2] + y * own[d + a, 2] + z * own[d + b, 2],
    )

"""What a spot's cone lets through."""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel

_ROUNDING = 1e-5  # of float32 samples on a lamp


@kernel(forceinline=True)
def _let_through(lamps, i, cosine):
    """What the cone of spot i lets through at an angle to its axis."""
    inside = cosine - np.float64(lamps.cone[i, 0])
    if inside <= 0.0:
        return 0.0
    t = min(inside * np.float64(lamps.cone[i, 1]), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel(forceinline=True)
def cone_factor(lamps, i, dx, dy, dz):
    """What a spot's cone lets through towards a point that sees the lamp along (dx, dy, dz)."""
    if np.float64(lamps.cone[i, 0]) < -1.5:
        return 1.0
    m = lamps.to_cone
    x = -(m[i, 0, 0] * dx + m[i, 0, 1] * dy + m[i, 0, 2] * dz)
    y = -(m[i, 1, 0] * dx + m[i, 1, 1] * dy + m[i, 1, 2] * dz)
    z = -(m[i, 2, 0] * dx + m[i, 2, 1] * dy + m[i, 2, 2] * dz)
    return _let_through(lamps, i, -z / math.sqrt(max(x * x + y * y + z * z, 1e-60)))


@kernel(forceinline=True)
def _most_stretched(m):
    """At least the square of how much the 3 x 3 matrix m stretches any vector, by Gershgorin's
    discs of m m^T: just so where it scales along axes."""
    most = 0.0
    for a in range(3):
        row = 0.0
        for b in range(3):
            row += abs(m[a, 0] * m[b, 0] + m[a, 1] * m[b, 1] + m[a, 2] * m[b, 2])
        most = max(most, row)
    return most


@kernel(forceinline=True)
def soft_cone_factor(lamps, i, dx, dy, dz, sine):
    """The mean of what the cone lets through along (dx, dy, dz), from a soft spot's middle, and of
    the most that it does from anywhere on the spot; 0 only where nothing comes through.

    sine: of the angle that the spot's radius fills, seen from the point
    """
    if np.float64(lamps.cone[i, 0]) < -1.5:
        return 1.0
    m = lamps.to_cone[i]
    x = -(m[0, 0] * dx + m[0, 1] * dy + m[0, 2] * dz)
    y = -(m[1, 0] * dx + m[1, 1] * dy + m[1, 2] * dz)
    z = -(m[2, 0] * dx + m[2, 1] * dy + m[2, 2] * dz)
    length = math.sqrt(max(x * x + y * y + z * z, 1e-60))
    aside = math.sqrt(dx * dx + dy * dy + dz * dz) * sine * math.sqrt(_most_stretched(m))
    aside = aside / length + _ROUNDING
    if aside >= 1.0:
        return 1.0
    cosine, along = max(min(-z / length, 1.0), -1.0), math.sqrt(1.0 - aside * aside)
    nearest = 1.0  # the cosine at the axis' side of the spot
    if cosine < along:
        nearest = cosine * along + math.sqrt(1.0 - cosine * cosine) * aside
    return 0.5 * (_let_through(lamps, i, cosine) + _let_through(lamps, i, nearest))

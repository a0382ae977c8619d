"""What a spot's cone lets through."""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel


@kernel(forceinline=True)
def cone_factor(lamps, i, dx, dy, dz):
    """What a spot's cone lets through towards a point that sees the lamp along (dx, dy, dz)."""
    edge = np.float64(lamps.cone[i, 0])
    if edge < -1.5:
        return 1.0
    m = lamps.to_cone
    x = -(m[i, 0, 0] * dx + m[i, 0, 1] * dy + m[i, 0, 2] * dz)
    y = -(m[i, 1, 0] * dx + m[i, 1, 1] * dy + m[i, 1, 2] * dz)
    z = -(m[i, 2, 0] * dx + m[i, 2, 1] * dy + m[i, 2, 2] * dz)
    inside = -z / math.sqrt(max(x * x + y * y + z * z, 1e-60)) - edge
    if inside <= 0.0:
        return 0.0
    t = min(inside * np.float64(lamps.cone[i, 1]), 1.0)
    return t * t * (3.0 - 2.0 * t)

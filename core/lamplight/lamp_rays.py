"""Shadow rays to lamps: where they start and end, and what they bring to their points."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..embree.accel import start_shadow_ray

# Columns of a point's light: (r, g, b) by the diffuse lobe, by the glossy one, and the luminance of
# all, were nothing between the lamps and the point. What follows is (r, g, b) of each light group.
UNOCCLUDED, COLUMNS = 6, 7


class LampRays(NamedTuple):
    """Shadow rays to lamps, float32 but point and lamp.

    origins, directions: (capacity, 3); reach: (capacity,), metres; point, lamp: int32 (capacity,)
    light: (capacity, COLUMNS), what each brings
    """

    origins: np.ndarray
    directions: np.ndarray
    reach: np.ndarray
    point: np.ndarray
    lamp: np.ndarray
    light: np.ndarray


@kernel(forceinline=True)
def aim(points, p, target, far, lifted, offset, rays, n):
    """Write ray n from point p along the unit vector ``target`` to a lamp ``far`` away."""
    wx, wy, wz = target
    x, y, z = np.float32(wx), np.float32(wy), np.float32(wz)
    if not start_shadow_ray(points, p, x, y, z, lifted, offset, rays.origins, n):
        return False
    if far < 1e15:
        wx = points.position[p, 0] + wx * far - np.float64(rays.origins[n, 0])
        wy = points.position[p, 1] + wy * far - np.float64(rays.origins[n, 1])
        wz = points.position[p, 2] + wz * far - np.float64(rays.origins[n, 2])
        far = math.sqrt(wx * wx + wy * wy + wz * wz)
        wx, wy, wz = wx / far, wy / far, wz / far
        # Not as far as a ceiling in whose plane the lamp lies.
        far -= max(1e-5 * far, np.float64(offset))
    rays.directions[n, 0], rays.directions[n, 1], rays.directions[n, 2] = wx, wy, wz
    rays.reach[n] = max(far, 0.0)
    return True


@kernel(forceinline=True)
def column_of(group, sums):
    """First column of a light group in sums; 0 where it has none."""
    if sums.shape[1] == COLUMNS or group < 0:
        return 0
    return COLUMNS + 3 * group


@kernel(forceinline=True)
def bring(column, color, light, n, sums, p):
    """Add a color of row n of light to point p, and to the columns of a light group."""
    sums[p, color] += light[n, color]
    sums[p, 3 + color] += light[n, 3 + color]
    if column > 0:
        sums[p, column + color] += light[n, color] + light[n, 3 + color]


@kernel
def add_rays(lamps, rays, n, blocked, sums):
    """Add what n rays bring to their points. blocked: uint8 (n,), a bit for each blocked color"""
    for k in range(n):
        p = rays.point[k]
        column = column_of(lamps.group[rays.lamp[k]], sums)
        sums[p, UNOCCLUDED] += rays.light[k, UNOCCLUDED]
        for color in range(3):
            if not (blocked[k] >> color) & 1:
                bring(column, color, rays.light, k, sums, p)

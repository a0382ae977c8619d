"""The shadow rays of the lanes, and the sums of what was seen."""

from __future__ import annotations

import numpy as np

from ._jit import kernel
from .embree_rays import ALL_COLORS, occluded_lanes
from .lanes import DIFFUSE, DX, GLOSSY, LANES, OX
from .pyramid import luminance

_ZERO = np.float32(0.0)
_LAST = 2 * LANES


@kernel
def _choose_rays(lanes, n):
    """ray: the lanes that carry light; returns how many."""
    numbers, m = lanes.numbers, 0
    for s in range(n):
        diffuse = numbers[DIFFUSE + s] + numbers[DIFFUSE + LANES + s] + numbers[DIFFUSE + _LAST + s]
        glossy = numbers[GLOSSY + s] + numbers[GLOSSY + LANES + s] + numbers[GLOSSY + _LAST + s]
        lanes.ray[m] = s
        m += diffuse + glossy > _ZERO
    return m


@kernel
def trace_lanes(traversal, lanes, n):
    """seen: what of the light of each lane reaches its point; returns how many rays that took.

    ray: which lanes they belong to
    """
    m = _choose_rays(lanes, n)
    lanes.seen[:n] = 0
    occluded_lanes(traversal, lanes.numbers, OX, DX, LANES, lanes.ray, m, lanes.seen)
    return m


@kernel(ordered=True)
def add_lanes(lanes, n, sums):
    """Add lanes 0 ... n - 1 to the sums of their points, in order."""
    numbers = lanes.numbers
    for s in range(n):
        p = lanes.point[s]
        dr, dg, db = (
            numbers[DIFFUSE + s],
            numbers[DIFFUSE + LANES + s],
            numbers[DIFFUSE + _LAST + s],
        )
        gr, gg, gb = numbers[GLOSSY + s], numbers[GLOSSY + LANES + s], numbers[GLOSSY + _LAST + s]
        r, g, b = dr + gr, dg + gg, db + gb
        sums.unoccluded[p, 0] += np.float64(r)
        sums.unoccluded[p, 1] += np.float64(g)
        sums.unoccluded[p, 2] += np.float64(b)
        seen = lanes.seen[s]
        if seen != 0:
            if seen != ALL_COLORS:
                red, green, blue = seen & 1, (seen >> 1) & 1, seen >> 2
                dr, dg, db = dr * red, dg * green, db * blue
                gr, gg, gb = gr * red, gg * green, gb * blue
                r, g, b = dr + gr, dg + gg, db + gb
            light = np.float64(luminance(r, g, b))
            sums.visible[p] += 1
            sums.seen[p] += light
            sums.seen_squared[p] += light * light
            sums.diffuse[p, 0] += np.float64(dr)
            sums.diffuse[p, 1] += np.float64(dg)
            sums.diffuse[p, 2] += np.float64(db)
            sums.glossy[p, 0] += np.float64(gr)
            sums.glossy[p, 1] += np.float64(gg)
            sums.glossy[p, 2] += np.float64(gb)

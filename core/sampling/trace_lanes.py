"""The shadow rays of the lanes, and the sums of what was seen."""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..bsdf.luminance import chroma, luminance
from ..embree.embree_rays import ALL_COLORS, blocked_aside, occluded_lanes
from ..machine.lanes import DIFFUSE, DX, DY, DZ, GLOSSY, LANES, OX, OY, OZ

_ZERO, _FOREVER = np.float32(0.0), np.float32(np.inf)
_LAST = 2 * LANES
# A free ray that brings more than this part of its point's light so far is asked again: one that
# slipped through an edge is alone in the dark, and else within the noise of a few samples.
_DOUBT = 0.6
_TOGETHER = 16  # rays of a point, so many of which go through the hierarchy at once


@kernel
def _choose_rays(lanes, n):
    """ray: the lanes that carry light; returns how many."""
    numbers, m = lanes.numbers, 0
    for s in range(n):
        diffuse = numbers[DIFFUSE + s] + numbers[DIFFUSE + LANES + s] + numbers[DIFFUSE + _LAST + s]
        glossy = numbers[GLOSSY + s] + numbers[GLOSSY + LANES + s] + numbers[GLOSSY + _LAST + s]
        lanes.ray[m] = s
        m += abs(diffuse + glossy) > _ZERO  # a world may have negative light
    return m


@kernel(forceinline=True)
def _light_of(numbers, s):
    """The luminance that lane s brings where nothing is in its way."""
    return luminance(
        numbers[DIFFUSE + s] + numbers[GLOSSY + s],
        numbers[DIFFUSE + LANES + s] + numbers[GLOSSY + LANES + s],
        numbers[DIFFUSE + _LAST + s] + numbers[GLOSSY + _LAST + s],
    )


@kernel
def _doubt(traversal, lanes, n, seen_before):
    """Ask again, beside it, the ray that brings most of the light of its point, where one does.

    seen_before: float64, the luminance that points have seen; lanes of a point follow each other
    """
    numbers, s = lanes.numbers, np.int64(0)
    while s < n:
        p, most, which = lanes.point[s], _ZERO, s
        total = seen_before[p]
        while s < n and lanes.point[s] == p:
            if lanes.seen[s] != 0:
                light = _light_of(numbers, s)
                total += np.float64(light)
                if light > most:
                    most, which = light, s
            s += 1
        if most > _DOUBT * total:
            x, y, z = numbers[OX + which], numbers[OY + which], numbers[OZ + which]
            dx, dy, dz = numbers[DX + which], numbers[DY + which], numbers[DZ + which]
            if blocked_aside(traversal, x, y, z, dx, dy, dz, _FOREVER):
                lanes.seen[which] = 0


@kernel
def trace_lanes(traversal, lanes, n, seen_before):
    """seen: what of the light of each lane reaches its point; returns how many rays that took.

    ray: which lanes they belong to; seen_before: float64, the luminance that points have seen
    """
    m = _choose_rays(lanes, n)
    lanes.seen[:n] = 0
    first = lanes.point[0]
    together = _TOGETHER if n >= _TOGETHER and lanes.point[_TOGETHER - 1] == first else 1
    own = OX, DX, LANES, lanes.ray, m, together, lanes.seen
    occluded_lanes(traversal, lanes.numbers, *own)
    if traversal.aside > 0.0:
        _doubt(traversal, lanes, n, seen_before)
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
            sums.hue[p] += np.float64(chroma(r, g, b))
            sums.diffuse[p, 0] += np.float64(dr)
            sums.diffuse[p, 1] += np.float64(dg)
            sums.diffuse[p, 2] += np.float64(db)
            sums.glossy[p, 0] += np.float64(gr)
            sums.glossy[p, 1] += np.float64(gg)
            sums.glossy[p, 2] += np.float64(gb)

"""Toon: a cap of constant brightness round an axis, with a rim that fades, as in Cycles.

    f cos_i = color i(angle) / (2 pi (1 - cos reach)),   reach = min(size + smooth, pi / 2)

The angle is that of wi to the normal (diffuse) or to the mirrored wo (glossy); i is 1 within the
size and falls in a line to 0 over the smooth rim. There is no cosine: what a surface shows does
not depend on how steeply light falls in. All numbers are of the square of the chord between two
unit vectors, 4 sin^2 of half their angle, for a cosine has no digits left where a cap is narrow.
As sheen (sheen.py) it is a Lambert closure of its own, whose Lobes.rough says what it is instead.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..unit_square.sphere_map import CELL_REACH
from .lambert_kinds import DIFFUSE_TOON, GLOSSY_TOON
from .luminance import luminance
from .microfacet import (
    HALF,
    INV_PI,
    MIN_ALPHA,
    ONE,
    PI,
    QUARTER,
    TWO,
    ZERO,
    basis,
    dot_xyz,
    to_world,
)

# Lobes.rough, before its kind: size, smooth (radians), the square of the chord to reach.
_NARROWEST = np.float32(1e-5)  # of Size, as in Cycles
_REACH = np.float32(CELL_REACH)
# Kept of a cell by whose corner the cap may reach in: a sun there must not be too bright.
_LEAST = np.float32(0.1)
# Of the samples at least these follow the cap itself.
_FOLLOW = np.float32(0.05)


@kernel(forceinline=True)
def is_toon(rough):
    """Whether a row of Lobes.rough is toon's."""
    return rough[3] == DIFFUSE_TOON or rough[3] == GLOSSY_TOON


def set_toon(lobes, matte: np.ndarray, glossy: np.ndarray, size, smooth) -> None:
    """Make toon of the Lambert lobes of points.

    matte, glossy: bool (n,), which; size, smooth: float32 (n,), of right angles
    """
    quarter = np.float32(math.pi / 2.0)
    for which, kind in ((matte, DIFFUSE_TOON), (glossy, GLOSSY_TOON)):
        full = np.clip(size[which], _NARROWEST, ONE) * quarter
        rim = np.clip(smooth[which], ZERO, ONE) * quarter
        reach = np.minimum(full + rim, quarter)
        chord2 = np.float32(4.0) * np.sin(HALF * reach) ** 2
        lobes.rough[which] = np.stack([full, rim, chord2, 0.0 * full + kind], -1)
        # Lamps are looked for along narrow lobes; none is a mirror, which shows no point lamp.
        lobes.alpha[which] = np.maximum(reach, TWO * MIN_ALPHA)
    lobes.glossy_color[glossy] = lobes.diffuse[glossy]


@kernel(forceinline=True)
def _axis(n, wo, rough):
    """The middle of the cap, a unit vector; is there one?"""
    if rough[3] == DIFFUSE_TOON:
        return n[0], n[1], n[2], True
    cos_o = dot_xyz(n, wo[0], wo[1], wo[2])
    twice = TWO * cos_o
    return twice * n[0] - wo[0], twice * n[1] - wo[1], twice * n[2] - wo[2], cos_o > ZERO


@kernel
def _intensity(n, wo, rough, wi_x, wi_y, wi_z):
    """i, and whether wi is within reach."""
    x, y, z, there = _axis(n, wo, rough)
    x, y, z = wi_x - x, wi_y - y, wi_z - z
    chord2 = x * x + y * y + z * z
    if not there or chord2 >= rough[2] or dot_xyz(n, wi_x, wi_y, wi_z) <= ZERO:
        return ZERO, there and chord2 < rough[2]
    angle = TWO * math.asin(min(HALF * math.sqrt(chord2), ONE))
    if angle < rough[0] or rough[1] <= ZERO:
        return ONE, True
    return max(ONE - (angle - rough[0]) / rough[1], ZERO), True


@kernel(forceinline=True)
def toon(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value with its Lambert lobe made toon: is_toon(at.rough)."""
    share, _ = _intensity(at.normal, at.wo, at.rough, wi_x, wi_y, wi_z)
    scale = share * INV_PI / at.rough[2]
    r, g, b = at.diffuse[0] * scale, at.diffuse[1] * scale, at.diffuse[2] * scale
    if at.rough[3] == DIFFUSE_TOON:
        return r, g, b, value[3], value[4], value[5]
    return ZERO, ZERO, ZERO, r, g, b


@kernel(forceinline=True)
def pdf_toon(at, wi_x, wi_y, wi_z):
    """The density of sample_toon, sr^-1; below the horizon too, where nothing is reflected."""
    _, within = _intensity(at.normal, at.wo, at.rough, wi_x, wi_y, wi_z)
    return INV_PI / at.rough[2] if within else ZERO


@kernel(forceinline=True)
def sample_toon(at, u1, u2):
    """A direction of the cap, all alike."""
    x, y, z, _ = _axis(at.normal, at.wo, at.rough)
    s, t = basis((x, y, z))
    chord2 = u1 * at.rough[2]
    r, phi = math.sqrt(chord2 * (ONE - QUARTER * chord2)), TWO * PI * u2
    own = r * math.cos(phi), r * math.sin(phi), ONE - HALF * chord2
    return to_world(s, t, (x, y, z), *own)


@kernel
def fill_toon(lobes, p, cells, radius, values):
    """Write light x toon in place of a Lambert lobe's values over cells; returns Products.follow.

    cells: ProductCells; radius: of a disc of a cell's solid angle; values: float32 (n,), above 0
    where a part of the cell is above the horizon
    """
    n, wo, rough = lobes.normal[p], lobes.wo[p], lobes.rough[p]
    x, y, z, there = _axis(n, wo, rough)
    albedo = luminance(lobes.diffuse[p, 0], lobes.diffuse[p, 1], lobes.diffuse[p, 2])
    spread = radius * radius
    scale = albedo * INV_PI / (rough[2] + spread)
    corner = _REACH * radius
    reach = TWO * math.asin(HALF * math.sqrt(rough[2]))
    width = max(reach - rough[0], ZERO) + TWO * corner
    for r in range(len(values)):
        if values[r] <= ZERO:
            continue
        dx, dy, dz = cells.x[r] - x, cells.y[r] - y, cells.z[r] - z
        chord = math.sqrt(dx * dx + dy * dy + dz * dz)
        left = reach + corner - TWO * math.asin(min(HALF * chord, ONE))
        values[r] = ZERO
        if there and left > ZERO:
            values[r] = scale * cells.light[r] * min(max(left / width, _LEAST), ONE)
    corners = corner * corner
    return max(_FOLLOW, corners / (rough[2] + corners))

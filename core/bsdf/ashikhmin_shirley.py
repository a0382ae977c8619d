"""The glossy lobe of Ashikhmin and Shirley [AshikhminShirley00], as in Cycles: without a Fresnel
curve and without the matte lobe under it.

    f cos_i = color cos_i norm (h . n)^e / ((wo . h) max(cos_i, cos_o))
    norm = sqrt((n_x + 1) (n_y + 1)) / (8 pi),   n = 2 / alpha^2 - 2,   e: n towards h

Cycles' own samples of it (not its light samples) mirror wo by facets that are turned away from it
to elsewhere, as if their cosine were positive: rough surfaces come out brighter there at grazing
angles (.43 in place of .32 at a roughness of 1 and a cosine of .3). That is left out.

Beckmann's facets of the same widths stand for it everywhere else: where samples go, what cells of
the product hold, which albedo a pass shows. Lobes.rough says that the value is this one.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .lambert_kinds import PHONG
from .lobes import Lobes
from .microfacet import HALF, MIN_ALPHA, ONE, QUARTER, ZERO, dot_xyz, half_vector

_TINY, _LEAST = np.float32(1e-12), np.float32(1e-6)
# Beyond it (h . n)^e is 0 in float32.
_DARK = np.float32(-80.0)


def set_ashikhmin_shirley(lobes: Lobes, which: np.ndarray) -> None:
    """Make it of the gloss of points, BECKMANN's as yet. which: bool (n,)

    What is as smooth as a mirror stays one. Lobes.rough becomes n_x (along the tangent), n_y, norm,
    PHONG.
    """
    wide = lobes.alpha[which].astype(np.float64)
    narrow = np.where(lobes.narrow[which] > 0.0, lobes.narrow[which], wide)
    along, across = 2.0 / wide**2 - 2.0, 2.0 / narrow**2 - 2.0
    norm = np.sqrt((along + 1.0) * (across + 1.0)) / (8.0 * math.pi)
    numbers = np.stack([along, across, norm, np.full(len(wide), PHONG)], -1)
    numbers[wide <= MIN_ALPHA] = 0.0
    lobes.rough[which] = numbers


@kernel(forceinline=True)
def _exponent(at, hx, hy, hz):
    """n towards h."""
    if at.narrow <= ZERO:
        return at.rough[0]
    m = at.glossy_normal
    along, up = dot_xyz(at.tangent, hx, hy, hz), dot_xyz(m, hx, hy, hz)
    along, whole = along * along, max(ONE - up * up, ZERO)
    if whole <= _TINY:
        return at.rough[0]
    along = min(along / whole, ONE)
    return at.rough[0] * along + at.rough[1] * (ONE - along)


@kernel
def ashikhmin_shirley(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value with its gloss made that of Ashikhmin and Shirley: rough[3] is PHONG"""
    dr, dg, db = value[0], value[1], value[2]
    m = at.glossy_normal
    cos_i, cos_n = dot_xyz(m, wi_x, wi_y, wi_z), dot_xyz(at.normal, wi_x, wi_y, wi_z)
    if cos_i <= ZERO or (cos_n <= ZERO and at.bump == ZERO):
        return dr, dg, db, ZERO, ZERO, ZERO
    hx, hy, hz, cos_h = half_vector(at.wo, wi_x, wi_y, wi_z)
    x, y, z = hx - m[0], hy - m[1], hz - m[2]
    chord2 = x * x + y * y + z * z
    sin2 = max(chord2 * (ONE - QUARTER * chord2), ZERO)
    power = ZERO
    if sin2 < ONE and chord2 < ONE + ONE:
        power = HALF * _exponent(at, hx, hy, hz) * np.log1p(-sin2)
    elif _exponent(at, hx, hy, hz) > ZERO:
        power = _DARK
    if power <= _DARK:
        return dr, dg, db, ZERO, ZERO, ZERO
    pump = max(cos_h, _LEAST) * max(cos_i, at.cos_o)
    scale = cos_i * at.rough[2] * math.exp(power) / max(pump, _LEAST)
    w = at.conductor_weight
    return dr, dg, db, w[0] * scale, w[1] * scale, w[2] * scale

"""Rough diffuse surfaces: a factor on the Lambert lobe [Fujii12], with later bounces [OpenPBR].

    f = A / pi + B / pi t',   t = wi . wo - cos_i cos_o,   t' = t / max(cos_i, cos_o) where t > 0
    A = 1 - k B / pi,   B = pi s / (pi + k s),   k = pi / 2 - 2 / 3,   s: the roughness

What leaves towards one side is E(c) = A + B / pi G(c) of a white surface; the rest is scattered
again: f_ms = pass (1 - E(cos_i)) (1 - E(cos_o)), coloured by the square of the albedo, as in Cycles
of Blender 5.2. Samples follow the Lambert lobe all the same: the factor is smooth.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .ashikhmin_shirley import ashikhmin_shirley
from .lambert_kinds import PHONG
from .microfacet import INV_PI, ONE, PI, ZERO
from .sheen import sheen
from .toon import is_toon, toon

_K = np.float32(math.pi / 2.0 - 2.0 / 3.0)
_TWO_THIRDS = np.float32(2.0 / 3.0)
_MEAN_G = np.float32((2.0 * math.pi - 5.6) / 3.0)  # as OpenPBR rounds it
_LEAST = np.float32(1e-5)  # Cycles takes less for Lambert's
_TINY = np.float32(1e-12)


@kernel(forceinline=True)
def _albedo(b, cosine):
    """E: of the light from one side, what leaves a white surface at once; b: B."""
    sine = math.sqrt(max(ONE - cosine * cosine, ZERO))
    both = sine * cosine
    g = sine * (math.acos(cosine) - _TWO_THIRDS - both)
    # sin^3 taken from 1, over the cosine: written so that nothing cancels at the horizon.
    g += _TWO_THIRDS * both * (ONE + sine + sine * sine) / (ONE + sine)
    return ONE + b * INV_PI * (g - _K)


@kernel
def set_rough(params, p, cos_o, out):
    """Write row p of Lobes.rough."""
    sigma = min(max(params.diffuse_roughness[p], ZERO), ONE)
    if sigma < _LEAST:
        return
    b = PI * sigma / (PI + _K * sigma)
    mean = ONE + b * INV_PI * (_MEAN_G - _K)
    later = (ONE - _albedo(b, min(max(cos_o, ZERO), ONE))) * mean / (ONE - mean)
    for c in range(3):
        color = min(max(params.base_color[p, c], ZERO), ONE)
        out.rough[p, c] = later * color * color / (ONE - color * (ONE - mean))
    out.rough[p, 3] = b


@kernel(forceinline=True)
def roughened(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value with its Lambert lobe rough, sheen or toon, or its gloss another one:
    at.rough[3] is not 0."""
    if at.rough[3] < ZERO:
        if at.rough[3] == PHONG:
            return ashikhmin_shirley(at, wi_x, wi_y, wi_z, value)
        if is_toon(at.rough):
            return toon(at, wi_x, wi_y, wi_z, value)
        return sheen(at, wi_x, wi_y, wi_z, value)
    n, wo, b = at.normal, at.wo, at.rough[3]
    cos_i = min(max(n[0] * wi_x + n[1] * wi_y + n[2] * wi_z, ZERO), ONE)
    cos_o = max(n[0] * wo[0] + n[1] * wo[1] + n[2] * wo[2], ZERO)
    t = wo[0] * wi_x + wo[1] * wi_y + wo[2] * wi_z - cos_i * cos_o
    if t > ZERO:
        t /= max(max(cos_i, cos_o), _TINY)
    single, left = ONE + b * (t - _K * INV_PI), ONE - _albedo(b, cos_i)
    return (
        value[0] * (single + at.rough[0] * left),
        value[1] * (single + at.rough[1] * left),
        value[2] * (single + at.rough[2] * left),
        value[3],
        value[4],
        value[5],
    )

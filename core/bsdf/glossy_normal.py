"""The normal that glossy light follows: the shading normal, where the surface allows it."""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .microfacet import HALF, ONE, TWO, dot


@kernel
def set_glossy_normal(geometric_normal, facing, as_turned, p, out):
    """Write the normal nearest to the shading normal whose mirrored wo clears the surface.
    as_turned: write the shading normal itself

    In the plane of both normals, n = (sin a, cos a) with the geometric normal at a = 0, the
    mirrored wo stands at height wo_x sin 2a + wo_z cos 2a. It must reach ``height``, so that
    a = (atan2(wo_x, wo_z) + acos(height / |wo_xz|)) / 2 at most. Cycles asks for the same height.
    """
    n, g, wo = out.normal[p], out.glossy_normal[p], out.wo[p]
    for c in range(3):
        g[c] = n[c]
    cos_o = dot(n, wo)
    wo_z = dot(geometric_normal, wo) * facing
    n_z = dot(geometric_normal, n) * facing
    height = min(np.float32(0.9) * wo_z, np.float32(0.01))
    side2 = ONE - n_z * n_z
    if not as_turned and TWO * cos_o * n_z - wo_z < height and side2 > np.float32(1e-12):
        side = ONE / math.sqrt(side2)
        wo_x = (cos_o - n_z * wo_z) * side
        length = math.sqrt(wo_x * wo_x + wo_z * wo_z)
        angle = HALF * (math.atan2(wo_x, wo_z) + math.acos(min(height / length, ONE)))
        sin_a, cos_a = math.sin(angle), math.cos(angle)
        for c in range(3):
            g_c = geometric_normal[c] * facing
            g[c] = sin_a * (n[c] - n_z * g_c) * side + cos_a * g_c
    out.cos_o[p] = dot(g, wo)

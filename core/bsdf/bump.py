"""What a matte surface reflects whose normal a map has turned: bump shadowing, as in Cycles.

Nothing comes from below the smooth surface, and grazing light is shadowed as by the facets of a GGX
surface that is as rough as the normal is turned [Estevez19]. Gloss is not shadowed: its normal is
turned back until it mirrors wo to above the face (glossy_normal.py).
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .microfacet import ONE, TWO, ZERO

_ROUGH = 0.125  # that surface's width squared over tan^2 of the turn


def turns(smooth: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Lobes.bump: float32 (n,). smooth, normal: float32 (n, 3), unit, on one side"""
    cos2 = np.clip((smooth * normal).sum(1), -1.0, 1.0).astype(np.float64) ** 2
    slope2 = (1.0 - cos2) / np.maximum(cos2, 1e-12)
    return np.clip(_ROUGH * slope2, 0.0, 1.0).astype(np.float32)


@kernel(forceinline=True)
def bump_gain(at, wi_x, wi_y, wi_z):
    """What is left of Lambert's light from wi; at: smooth and bump as of LobesAt."""
    cosine = at.smooth[0] * wi_x + at.smooth[1] * wi_y + at.smooth[2] * wi_z
    if cosine <= ZERO:
        return ZERO
    slope2 = at.bump * (ONE / (cosine * cosine) - ONE)
    return TWO / (ONE + math.sqrt(ONE + max(slope2, ZERO)))

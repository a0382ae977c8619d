"""Sheen: fibres that stand on a surface, as a factor on a Lambert lobe.

Microfibre [Zeltner22]: of the light from everywhere R is reflected to wo, by a cosine lobe under a
linear map of directions [Heitz16]. With wo in the plane of x and z, z = the normal:

    f cos_i = R / pi z (a / l)^2,   l = (a x + b z)^2 + (a y)^2 + z^2,   wi = (x, y, z)

a, b and R were measured in Cycles' pictures (docs/decisions/0029-sheen.md). Velvet [Ashikhmin00]:
an inverted Gaussian of facets. Lobes.rough has what either wants, and says which by its last
number. Samples follow the Lambert lobe.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from ._jit import kernel
from .microfacet import INV_PI, ONE, PI, QUARTER, TWO, ZERO, dot_xyz, half_vector
from .sheen_numbers import NUMBERS

# Lobes.rough[3]: (a, b) or (sigma) before it.
MICROFIBER, VELVET = np.float32(-1.0), np.float32(-2.0)
_SIDE = 32
_SMALL = np.float32(1e-5)
_TINY = np.float32(1e-12)


@functools.cache
def _table() -> np.ndarray:
    """float64 (cosines, roughnesses, 3): a, b, R."""
    numbers = np.array(NUMBERS.split(), np.float64) * 1e-4
    return np.moveaxis(numbers.reshape(3, _SIDE, _SIDE), 0, -1)


def microfiber(cosine: np.ndarray, roughness: np.ndarray) -> tuple[np.ndarray, ...]:
    """a, b and R, float32 (n,); cosine: of wo with the normal; roughness: 0 to 1"""
    table = _table()
    rows = np.sqrt(np.clip(cosine, 0.0, 1.0).astype(np.float64)) * (_SIDE - 1)
    columns = np.clip(roughness, 0.0, 1.0).astype(np.float64) * (_SIDE - 1)
    i, j = (np.minimum(x.astype(np.int64), _SIDE - 2) for x in (rows, columns))
    f, g = (rows - i)[:, None], (columns - j)[:, None]
    low = (1.0 - g) * table[i, j] + g * table[i, j + 1]
    high = (1.0 - g) * table[i + 1, j] + g * table[i + 1, j + 1]
    return tuple(np.float32(((1.0 - f) * low + f * high).T))


def set_sheen(lobes, fibers: np.ndarray, velvet: np.ndarray, roughness: np.ndarray) -> None:
    """Make the Lambert lobes of some points sheen: Lobes of n points, written to.

    fibers, velvet: bool (n,), by which model; roughness: float32 (n,)
    """
    cosine = np.einsum("ij,ij->i", lobes.normal[fibers], lobes.wo[fibers])
    a, b, share = microfiber(cosine, np.clip(roughness[fibers], 1e-3, 1.0))
    lobes.diffuse[fibers] *= share[:, None]
    lobes.rough[fibers] = np.stack([a, b, 0.0 * a, 0.0 * a + MICROFIBER], -1)
    lobes.rough[velvet] = 0.0
    lobes.rough[velvet, 0] = np.clip(roughness[velvet], 0.01, 1.0)
    lobes.rough[velvet, 3] = VELVET


@kernel(forceinline=True)
def _microfiber(at, wi_x, wi_y, wi_z):
    """The factor of Lambert's."""
    n, wo = at.normal, at.wo
    z, cos_o = dot_xyz(n, wi_x, wi_y, wi_z), dot_xyz(n, wo[0], wo[1], wo[2])
    sin_o = math.sqrt(max(ONE - cos_o * cos_o, _TINY))
    x = (dot_xyz(wo, wi_x, wi_y, wi_z) - z * cos_o) / sin_o
    a, b = at.rough[0], at.rough[1]
    y2 = max(ONE - z * z - x * x, ZERO)
    bent = a * x + b * z
    ratio = a / max(bent * bent + a * a * y2 + z * z, _TINY)
    return ratio * ratio


@kernel(forceinline=True)
def _velvet(at, wi_x, wi_y, wi_z):
    """The factor of Lambert's."""
    n, wo = at.normal, at.wo
    cos_i, cos_o = dot_xyz(n, wi_x, wi_y, wi_z), dot_xyz(n, wo[0], wo[1], wo[2])
    hx, hy, hz, half = half_vector(wo, wi_x, wi_y, wi_z)
    cos_h = dot_xyz(n, hx, hy, hz)
    if cos_i <= ZERO or cos_o <= ZERO or cos_h >= ONE - _SMALL or half <= _SMALL:
        return ZERO
    sin2 = ONE - cos_h * cos_h
    width = ONE / (at.rough[0] * at.rough[0])
    facets = math.exp(-cos_h * cos_h / sin2 * width) * width * INV_PI / (sin2 * sin2)
    seen = min(ONE, TWO * cos_h / half * min(cos_i, cos_o))
    return PI * QUARTER * facets * seen / (cos_i * cos_o)


@kernel(forceinline=True)
def sheen(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value with its Lambert lobe made sheen: at.rough[3] is below 0."""
    if at.rough[3] == MICROFIBER:
        gain = _microfiber(at, wi_x, wi_y, wi_z)
    else:
        gain = _velvet(at, wi_x, wi_y, wi_z)
    dr, dg, db, gr, gg, gb = value
    return dr * gain, dg * gain, db * gain, gr, gg, gb

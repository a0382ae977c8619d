"""Sheen: fibres that stand on a surface, as a factor on a Lambert lobe.

Microfibre [Zeltner22]: of the light from everywhere R is reflected to wo, by a cosine lobe under a
linear map of directions [Heitz16]. With wo in the plane of x and z, z = the normal:

    f cos_i = R / pi z (a / l)^2,   l = (a x + b z)^2 + (a y)^2 + z^2,   wi = (x, y, z)

a, b and R were measured in Cycles' pictures (docs/decisions/0029-sheen.md). Velvet [Ashikhmin00]:
an inverted Gaussian of facets. Lobes.rough has what either wants, and says which by its last
number; as in Cycles it counts as glossy, fibres as diffuse. Samples follow the light times the
lobe, as of all others: the cells of the product get the factor too; a few follow the fibres alone.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from .._jit import kernel
from .lambert_kinds import MICROFIBER, TRANSLUCENT_ROUND, VELVET
from .microfacet import (
    INV_PI,
    ONE,
    PI,
    QUARTER,
    TWO,
    ZERO,
    basis,
    cross,
    dot_xyz,
    half_vector,
    to_world,
)
from .sheen_numbers import NUMBERS

_SIDE = 32
_SMALL = np.float32(1e-5)
_LEAST = np.float32(0.02)  # of the factor over a cell
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
    lobes.glossy_color[velvet] = lobes.diffuse[velvet]


@kernel(forceinline=True)
def _microfiber(n, wo, a, b, wi_x, wi_y, wi_z, spread2):
    """The factor of Lambert's; spread2: mean square of z about that of wi."""
    z, cos_o = dot_xyz(n, wi_x, wi_y, wi_z), dot_xyz(n, wo[0], wo[1], wo[2])
    sin_o = math.sqrt(max(ONE - cos_o * cos_o, _TINY))
    x = (dot_xyz(wo, wi_x, wi_y, wi_z) - z * cos_o) / sin_o
    y2 = max(ONE - z * z - x * x, ZERO)
    bent = a * x + b * z
    ratio = a / max(bent * bent + a * a * y2 + z * z + spread2, _TINY)
    return ratio * ratio


@kernel(forceinline=True)
def _microfiber_at(at, wi_x, wi_y, wi_z):
    return _microfiber(at.normal, at.wo, at.rough[0], at.rough[1], wi_x, wi_y, wi_z, ZERO)


@kernel(forceinline=True)
def pdf_microfiber(at, wi_x, wi_y, wi_z):
    """The density of sample_microfiber, sr^-1: the lobe itself."""
    z = dot_xyz(at.normal, wi_x, wi_y, wi_z)
    return max(z, ZERO) * INV_PI * _microfiber_at(at, wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def sample_microfiber(at, u1, u2):
    """A direction by the lobe: one of Lambert's, under the inverse of the map."""
    n, wo = at.normal, at.wo
    cos_o = dot_xyz(n, wo[0], wo[1], wo[2])
    along = (wo[0] - cos_o * n[0], wo[1] - cos_o * n[1], wo[2] - cos_o * n[2])
    length2 = dot_xyz(along, along[0], along[1], along[2])
    s, t = basis(n)
    if length2 > _TINY:
        scale = ONE / math.sqrt(length2)
        s = (along[0] * scale, along[1] * scale, along[2] * scale)
        t = cross(n, s)
    a, b = max(at.rough[0], _SMALL), at.rough[1]
    r, phi = math.sqrt(u1), TWO * PI * u2
    z = math.sqrt(max(ONE - u1, _TINY))
    x, y = (r * math.cos(phi) - b * z) / a, r * math.sin(phi) / a
    scale = ONE / math.sqrt(x * x + y * y + z * z)
    return to_world(s, t, n, x * scale, y * scale, z * scale)


@kernel(forceinline=True)
def _velvet(n, wo, sigma, wi_x, wi_y, wi_z):
    """The factor of Lambert's."""
    cos_i, cos_o = dot_xyz(n, wi_x, wi_y, wi_z), dot_xyz(n, wo[0], wo[1], wo[2])
    hx, hy, hz, half = half_vector(wo, wi_x, wi_y, wi_z)
    cos_h = dot_xyz(n, hx, hy, hz)
    if cos_i <= ZERO or cos_o <= ZERO or cos_h >= ONE - _SMALL or half <= _SMALL:
        return ZERO
    sin2 = ONE - cos_h * cos_h
    width = ONE / (sigma * sigma)
    facets = math.exp(-cos_h * cos_h / sin2 * width) * width * INV_PI / (sin2 * sin2)
    seen = min(ONE, TWO * cos_h / half * min(cos_i, cos_o))
    return PI * QUARTER * facets * seen / (cos_i * cos_o)


@kernel(forceinline=True)
def sheen(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value with its Lambert lobe made sheen: at.rough[3] is below 0."""
    dr, dg, db, gr, gg, gb = value
    if at.rough[3] == MICROFIBER:
        gain = _microfiber_at(at, wi_x, wi_y, wi_z)
        return dr * gain, dg * gain, db * gain, gr, gg, gb
    gain = _velvet(at.normal, at.wo, at.rough[0], wi_x, wi_y, wi_z)
    return ZERO, ZERO, ZERO, dr * gain, dg * gain, db * gain


def diffuse_colors(lobes) -> np.ndarray:
    """float32 (n, 3): Cycles' Diffuse Color; nothing of what is glossy there."""
    kind = lobes.rough[:, 3:]
    return np.where((kind <= VELVET) & (kind > TRANSLUCENT_ROUND), ZERO, lobes.diffuse)


@kernel(forceinline=True)
def diffuse_color(lobes, p, c):
    """diffuse_colors of row p, channel c."""
    kind = lobes.rough[p, 3]
    return ZERO if TRANSLUCENT_ROUND < kind <= VELVET else lobes.diffuse[p, c]


@kernel
def add_sheen(lobes, p, cells, radius, values):
    """Give the Lambert lobe's values over cells, float32 (n,), row p's factor: its sum then is
    another.

    cells: ProductCells; radius: of a disc of a cell's solid angle
    """
    n, wo, rough = lobes.normal[p], lobes.wo[p], lobes.rough[p]
    n, wo = (n[0], n[1], n[2]), (wo[0], wo[1], wo[2])
    spread2 = QUARTER * radius * radius
    for r in range(len(values)):
        if values[r] <= ZERO:
            continue
        x, y, z = cells.x[r], cells.y[r], cells.z[r]
        if rough[3] == MICROFIBER:
            values[r] *= _microfiber(n, wo, rough[0], rough[1], x, y, z, spread2)
        else:  # no cell with a part above the horizon may be left out
            values[r] *= max(_velvet(n, wo, rough[0], x, y, z), _LEAST)

"""What is under a surface that light goes through: a medium, whose reflectance is the base color.

Artists give a color and how far light goes; a walk (random_walk.py) wants the mean free path and
the single-scattering albedo that reflect so. The methods are Cycles':

    VAN_DE_HULST  the Random Walk of Blender 5.2: the radius is the mean free path; albedo [Kulla17]
    LEGACY        that of versions before: a quarter of it, over pi; albedo [Wrenninge17]
    SKIN          so short that what a dipole [Jensen01] blurs is that wide; albedo [Wrenninge17]
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..data.rows import row_maxima, rows_of

VAN_DE_HULST, LEGACY, SKIN = 0, 1, 2
# Shorter ways, metres, are not walked: such a channel is Lambert's.
LEAST_RADIUS = np.float32(1e-8)
_MOST_ALBEDO = np.float32(0.999999)
# Walks of darker media would be long for nothing: they are as this one, and count for less.
_LEAST_ALBEDO = np.float32(0.2)
_MOST_ANISOTROPY = 0.9
_LEAST_IOR, _MOST_IOR = 1.01, 3.8
_HALVINGS = 12

# [Wrenninge17]: polynomials in g, from its power 0 on, and those in exponents.
_A = (1.8260523782, -1.28451056436, -1.79904629312, 9.19393289202)
_A += (-22.8215585862, 32.0234874259, -23.6264803333, 7.21067002658)
_B = (0.0, 31.1491581433, -201.847017512, 841.576016723)
_B += (-2018.09288505, 2731.71560286, -1935.41424244, 559.009054474)
_C = (1.09686102424, -0.394704063468, 1.05258115941, -8.83963712726)
_C += (28.8643230661, -46.8802913581, 38.5402837518, -12.7181042538)
_D = (0.496310210422, 0.360146581622, -2.15139309747, 17.8896899217)
_D += (-55.2984010333, 82.065982243, -58.5106008578, 15.8478295021)
_E = (0.0, 76.7316253952, -594.356773233, 2448.8834203)
_E += (-5576.68528998, 7116.60171912, -4763.54467887, 1303.5318055)
_F = (2.40602999408, -2.51814844609, 9.18494908356, -79.2191708682)
_F += (259.082868209, -403.613804597, 302.85712436, -87.4370473567)


class Media(NamedTuple):
    """What is under n points, as materials say.

    color: float32 (n, 3), what a half space of it is to reflect; radius: float32 (n, 3), metres
    anisotropy, ior, roughness: float32 (n,), the cosine's mean of what is scattered; of the surface
        that light enters through
    method: int8 (n,), one of those above
    """

    color: np.ndarray
    radius: np.ndarray
    anisotropy: np.ndarray
    ior: np.ndarray
    roughness: np.ndarray
    method: np.ndarray

    def at(self, which) -> Media:
        """Those of a slice, a mask or indices."""
        return Media(*rows_of(self, which))


class Medium(NamedTuple):
    """The same, as a walk wants it.

    extinction, albedo: float32 (n, 3), 1 / metres and of single scattering
    anisotropy, ior, alpha: float32 (n,), alpha of the surface's facets
    matte: float32 (n,), the share of light that enters as under a matte surface, not a glossy one
    length: float32 (n,), how far light gets in the depth, in mean free paths [dEon20, eq. 67]
    gain: float32 (n, 3), factor of what comes out
    """

    extinction: np.ndarray
    albedo: np.ndarray
    anisotropy: np.ndarray
    ior: np.ndarray
    alpha: np.ndarray
    matte: np.ndarray
    length: np.ndarray
    gain: np.ndarray


def walked(radius: np.ndarray) -> np.ndarray:
    """float32, 1 where light of a channel walks under the surface, 0 where it does not get far."""
    return (radius >= LEAST_RADIUS).astype(np.float32)


def medium_of(media: Media) -> Medium:
    """Media as walks want them."""
    g = np.clip(media.anisotropy, -_MOST_ANISOTROPY, _MOST_ANISOTROPY).astype(np.float32)
    ior = np.clip(media.ior, _LEAST_IOR, _MOST_IOR).astype(np.float32)
    color = np.clip(media.color, 0.0, 1.0).astype(np.float32)
    # Media that scatter backwards are told by [Kulla17] in all methods.
    new = (media.method == VAN_DE_HULST) | (g < 0.0)
    skin = media.method == SKIN
    path = np.where((media.method == VAN_DE_HULST)[:, None], 1.0, 0.25 / math.pi) * media.radius
    if skin.any():
        path[skin] = media.radius[skin] * dipole_widths(color[skin], ior[skin])
    extinction = 1.0 / np.maximum(path, 1e-16)
    extinction[~new] /= (1.0 - g[~new])[:, None]
    albedo = np.where(new[:, None], _albedo_of_hulst(color, g), _albedo_of_fits(color, g))
    albedo = np.clip(albedo, 0.0, _MOST_ALBEDO)
    dark = albedo < _LEAST_ALBEDO
    walked_albedo = np.where(dark, _LEAST_ALBEDO, albedo)
    return Medium(
        extinction.astype(np.float32),
        walked_albedo.astype(np.float32),
        g,
        ior,
        np.where(skin, 1.0, np.square(np.clip(media.roughness, 0.0, 1.0))).astype(np.float32),
        np.where(skin, 0.5, 0.0).astype(np.float32),
        _lengths(row_maxima(walked_albedo.astype(np.float64))).astype(np.float32),
        np.where(dark, albedo / _LEAST_ALBEDO, 1.0).astype(np.float32),
    )


def _lengths(albedo: np.ndarray) -> np.ndarray:
    return 1.0 / np.sqrt(1.0 - albedo ** (2.44294 - 0.0215813 * albedo + 0.578637 / albedo))


def _albedo_of_hulst(color: np.ndarray, g: np.ndarray) -> np.ndarray:
    """[Kulla17], after van de Hulst."""
    s = 4.09712 + 4.20863 * color
    s = np.square(s - np.sqrt(9.59217 + color * (41.6808 + 17.7126 * color)))
    return (1.0 - s) / (1.0 - g[:, None] * s)


def _albedo_of_fits(color: np.ndarray, g: np.ndarray) -> np.ndarray:
    """[Wrenninge17]; g: from 0 on."""
    g = np.maximum(g, 0.0)[:, None]

    def at(coefficients):
        return np.polynomial.polynomial.polyval(g.astype(np.float64), coefficients)

    b = 4.98511194385 + 0.127355959438 * np.exp(at(_B))
    e = 4.23190299701 + 0.00310603949088 * np.exp(at(_E))
    bright = np.power(color, 0.25)
    low = at(_A) * np.power(np.arctan(b * color), at(_C))
    high = at(_D) * np.power(np.arctan(e * color), at(_F))
    return low + bright * (high - low)


def dipole_widths(color: np.ndarray, ior: np.ndarray) -> np.ndarray:
    """The mean free path over the distance that a dipole blurs over, (n, 3) [Jensen01].

    Cycles finds the reduced albedo of a reflectance by halving an interval twelve times.
    """
    inverse = 1.0 / ior.astype(np.float64)
    inside = inverse * (0.710 - 1.440 * inverse) + 0.668 + 0.0636 * ior
    boundary = ((4.0 / 3.0) * (1.0 + inside) / (1.0 - inside))[:, None]
    low, high = np.zeros(color.shape), np.ones(color.shape)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        s = np.sqrt(3.0 * (1.0 - middle))
        reflected = 0.5 * middle * (1.0 + np.exp(-boundary * s)) * np.exp(-s)
        below = reflected < color
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    found = np.where(color < 1e-4, 0.0, np.where(color >= 0.995, _MOST_ALBEDO, middle))
    return np.sqrt(3.0 * (1.0 - found))

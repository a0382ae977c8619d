"""Radiance of the world in a direction, looked up as Cycles' Environment Texture does it.

A world direction d goes through ``world_to_map``; the result p finds its texel by
    equirectangular: u = 1/2 - atan2(p_y, p_x) / 2 pi,  v = 1/2 + asin(p_z / |p|) / pi
    mirror ball:     (u, v) = 1/2 + (p_x, p_z) / (4 s),  s = sqrt((1 - p_y) / 2), |p| = 1
Measured against Cycles of Blender 4.5 and 5.2: the texel in column j, row i has its centre at
((j + .5) / w, (i + .5) / h); the map repeats in u *and in v*, so that the half row at a pole is
blended with the row at the other pole; the zero vector is looked up at (0, 0); byte images in sRGB
are interpolated first and decoded afterwards; values below 0 stay, and take light away. Densities
are of magnitudes (luminance.magnitude), only the weights of samples have signs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..machine.prefetch import fetch
from ..scene import CLOSEST, LINEAR_SRGB, MIRROR_BALL, EnvironmentMap

_PROJECTION_EQUIRECTANGULAR, _PROJECTION_MIRROR_BALL = 0, 1
_LOOKUP_LINEAR, _LOOKUP_CLOSEST, _LOOKUP_LINEAR_SRGB = 0, 1, 2

_ZERO, _HALF, _ONE, _TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
_INFINITY = np.float32(np.inf)
_PI, _HALF_PI = np.float32(math.pi), np.float32(0.5 * math.pi)
_INV_PI, _INV_TWO_PI = np.float32(1.0 / math.pi), np.float32(0.5 / math.pi)
_TINY = np.float32(1e-30)
# Of a map's light, what is below 0 from where counts of samples must not follow a pixel's own luck.
_TAKEN = 0.005
_ENCODED_AT_ONCE = 1 << 20  # values: three more copies of an 8K map would take 1.2 GB


# A call that passes the lookup's arrays costs four times what the lookup does (85 against 21 ns).
_inline = kernel(forceinline=True)


class EnvironmentLookup(NamedTuple):
    """An EnvironmentMap as kernels take it.

    texels: float32 (h, w, 3), what is interpolated: linear radiance without strength, or its sRGB
        encoding where interpolation says so; row 0 looks along -z
    matrix: float32 (3, 4), world_to_map; strength: float32 (3,)
    projection: 0 equirectangular, 1 mirror ball
    interpolation: 0 linear, 1 closest, 2 linear in the sRGB encoding
    """

    texels: np.ndarray
    matrix: np.ndarray
    strength: np.ndarray
    projection: int
    interpolation: int


def srgb_encode(linear: np.ndarray) -> np.ndarray:
    """The sRGB encoding (IEC 61966-2-1) of linear values, float32; no clipping: a line below 0."""
    linear = np.ascontiguousarray(linear, np.float32)
    encoded = np.empty_like(linear)
    flat, out = linear.reshape(-1), encoded.reshape(-1)
    for first in range(0, flat.size, _ENCODED_AT_ONCE):
        part = flat[first : first + _ENCODED_AT_ONCE]
        root = np.maximum(part, np.float32(0.0)) ** np.float32(1.0 / 2.4)
        curve = np.float32(1.055) * root - np.float32(0.055)
        low = part <= np.float32(0.0031308)
        out[first : first + _ENCODED_AT_ONCE] = np.where(low, np.float32(12.92) * part, curve)
    return encoded


def takes_away(environment: EnvironmentMap) -> bool:
    """Whether much of a map's light is below 0: filters leave a tenth of it round some suns."""
    radiance = environment.radiance
    if radiance.min() >= 0.0:
        return False
    taken = -radiance.sum(dtype=np.float64, where=radiance < 0.0)
    return bool(taken > _TAKEN * np.abs(radiance).sum(dtype=np.float64))


def make_lookup(environment: EnvironmentMap) -> EnvironmentLookup:
    """The lookup of a map; shares its texels, except where they are interpolated as sRGB."""
    texels, interpolation = environment.radiance, _LOOKUP_LINEAR
    if environment.interpolation == CLOSEST:
        interpolation = _LOOKUP_CLOSEST
    elif environment.interpolation == LINEAR_SRGB:
        texels, interpolation = srgb_encode(texels), _LOOKUP_LINEAR_SRGB
    mirror_ball = environment.projection == MIRROR_BALL
    return EnvironmentLookup(
        texels=np.ascontiguousarray(texels),
        matrix=environment.world_to_map,
        strength=environment.strength,
        projection=_PROJECTION_MIRROR_BALL if mirror_ball else _PROJECTION_EQUIRECTANGULAR,
        interpolation=interpolation,
    )


@_inline
def fast_atan2(y, x):
    """atan2(y, x) of float32, absolute error below 6e-7 rad; 0 at (0, 0)."""
    ax, ay = abs(x), abs(y)
    t = min(ax, ay) / max(max(ax, ay), _TINY)
    s = t * t
    p = np.float32(0.00681178214)
    p = p * s + np.float32(-0.0336041878)
    p = p * s + np.float32(0.0796236359)
    p = p * s + np.float32(-0.132333402)
    p = p * s + np.float32(0.198078151)
    p = p * s + np.float32(-0.33317368)
    p = p * s + np.float32(0.999996112)
    angle = p * t
    if ay > ax:
        angle = _HALF_PI - angle
    if x < _ZERO:
        angle = _PI - angle
    return -angle if y < _ZERO else angle


@_inline
def srgb_decode(encoded):
    """Linear value of one float32 in sRGB encoding."""
    if encoded <= np.float32(0.04045):
        return encoded * np.float32(1.0 / 12.92)
    return ((encoded + np.float32(0.055)) * np.float32(1.0 / 1.055)) ** np.float32(2.4)


@_inline
def map_coordinates(lookup, x, y, z):
    """(u, v) in [0, 1] of a world direction, which need not be normalised."""
    m = lookup.matrix
    px = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]
    py = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
    pz = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
    horizontal2 = px * px + py * py
    length2 = horizontal2 + pz * pz
    if not (_ZERO < length2 < _INFINITY):  # NaN ends here as well, and never becomes an index
        return _ZERO, _ZERO
    if lookup.projection == _PROJECTION_EQUIRECTANGULAR:
        u = _HALF - fast_atan2(py, px) * _INV_TWO_PI
        v = _HALF + fast_atan2(pz, math.sqrt(horizontal2)) * _INV_PI
        return u, v
    inv_length = _ONE / math.sqrt(length2)
    y1 = py * inv_length
    # 1 - y of a unit vector; near +y the difference is all rounding, and u would leave [0, 1].
    below_one = _ONE - y1 if y1 < _ZERO else (px * px + pz * pz) / (length2 * (_ONE + y1))
    side = _TWO * math.sqrt(_HALF * below_one)
    scale = _HALF * inv_length / side if side > _ZERO else _HALF * inv_length
    return _HALF + px * scale, _HALF + pz * scale


@_inline
def eval_environment(lookup, x, y, z):
    """(r, g, b): radiance that arrives from world direction (x, y, z), strength included.

    x, y, z: float32; unit length is needed only where the map's matrix translates
    """
    u, v = map_coordinates(lookup, x, y, z)
    return eval_map(lookup, u, v)


@_inline
def eval_map(lookup, u, v):
    """(r, g, b): the map's radiance at (u, v) of map_coordinates, strength included."""
    texels, strength = lookup.texels, lookup.strength
    height, width = np.int32(texels.shape[0]), np.int32(texels.shape[1])
    if lookup.interpolation == _LOOKUP_CLOSEST:
        column, row = np.int32(u * np.float32(width)), np.int32(v * np.float32(height))
        i = np.uint32(row if row < height else 0)
        j = np.uint32(column if column < width else 0)
        return (
            texels[i, j, 0] * strength[0],
            texels[i, j, 1] * strength[1],
            texels[i, j, 2] * strength[2],
        )
    s, t = u * np.float32(width) + _HALF, v * np.float32(height) + _HALF
    column, row = np.int32(s), np.int32(t)  # of the texel to the right and above, 0 ... width
    s -= np.float32(column)
    t -= np.float32(row)
    right = np.uint32(column if column < width else 0)
    left = np.uint32(column - 1 if column > 0 else width - 1)
    top = np.uint32(row if row < height else 0)
    bottom = np.uint32(row - 1 if row > 0 else height - 1)
    w11 = s * t
    w10, w01 = s - w11, t - w11
    w00 = _ONE - s - w01
    r = w00 * texels[bottom, left, 0] + w10 * texels[bottom, right, 0]
    g = w00 * texels[bottom, left, 1] + w10 * texels[bottom, right, 1]
    b = w00 * texels[bottom, left, 2] + w10 * texels[bottom, right, 2]
    r += w01 * texels[top, left, 0] + w11 * texels[top, right, 0]
    g += w01 * texels[top, left, 1] + w11 * texels[top, right, 1]
    b += w01 * texels[top, left, 2] + w11 * texels[top, right, 2]
    if lookup.interpolation == _LOOKUP_LINEAR_SRGB:
        r, g, b = srgb_decode(r), srgb_decode(g), srgb_decode(b)
    return r * strength[0], g * strength[1], b * strength[2]


@_inline
def fetch_texels(lookup, u, v):
    """Ask for the texels that eval_map reads at (u, v)."""
    height, width = np.int32(lookup.texels.shape[0]), np.int32(lookup.texels.shape[1])
    row, column = np.int32(v * np.float32(height) + _HALF), np.int32(u * np.float32(width) + _HALF)
    corner = np.int64(row) * np.int64(width) + np.int64(column - 1)
    fetch(lookup.texels, 12 * corner)
    fetch(lookup.texels, 12 * (corner - np.int64(width)))


@kernel
def eval_environment_many(lookup, directions, out):
    """Write the radiance that arrives from each world direction.

    directions: float32 (n, 3); out: float32 (n, 3), written
    """
    for i in range(directions.shape[0]):
        r, g, b = eval_environment(lookup, directions[i, 0], directions[i, 1], directions[i, 2])
        out[i, 0] = r
        out[i, 1] = g
        out[i, 2] = b

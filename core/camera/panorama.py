"""Panoramic cameras: a place in the unit square -> direction (panorama_places.py: and back).

The projections are Cycles' (docs/decisions/0020-cameras.md). Directions are in the camera's own
axes: x to the right, y up, looking along -z. A panorama's square has (0, 0) at the bottom left.
"""

import numpy as np

from .._jit import kernel
from ..scene import PANORAMAS, Camera, Panorama

_KINDS = tuple(PANORAMAS)
(
    _EQUIRECTANGULAR,
    _CUBEMAP_FACE,
    _MIRRORBALL,
    _EQUIDISTANT,
    _EQUISOLID,
    _POLYNOMIAL,
    _CYLINDRICAL,
) = range(len(_KINDS))


def panorama_code(panorama: Panorama) -> tuple[int, np.ndarray]:
    """What kernels take: the kind's number, and the parameters, float64 (m,)."""
    return _KINDS.index(panorama.kind), np.array([*panorama.parameters, 0.0], np.float64)


@kernel
def _on_fisheye(theta, x, y, r):
    """theta from the axis, towards (x, y) of length r."""
    sine = np.sin(theta)
    if r > 0.0:
        return sine * x / r, sine * y / r, -np.cos(theta)
    return 0.0, sine, -np.cos(theta)


@kernel
def _fisheye(kind, p, u, v):
    """A direction inside the image circle, else zeros."""
    if kind == _EQUIDISTANT:
        x, y = 2.0 * u - 1.0, 2.0 * v - 1.0
        r = np.sqrt(x * x + y * y)
        return _on_fisheye(0.5 * r * p[0], x, y, r) if r <= 1.0 else (0.0, 0.0, 0.0)
    x, y = (u - 0.5) * p[1], (v - 0.5) * p[2]
    r = np.sqrt(x * x + y * y)
    if kind == _EQUISOLID:
        sine = 0.5 * r / p[3]
        inside = sine <= np.sin(0.25 * p[0])
        return _on_fisheye(2.0 * np.arcsin(sine), x, y, r) if inside else (0.0, 0.0, 0.0)
    theta = -(p[3] + r * (p[4] + r * (p[5] + r * (p[6] + r * p[7]))))
    inside = np.abs(theta) <= 0.5 * p[0]
    return _on_fisheye(theta, x, y, r) if inside else (0.0, 0.0, 0.0)


@kernel
def panorama_direction(kind, p, u, v):
    """(x, y, z), unit, that a place of the square looks along; zeros where the lens shows nothing.

    kind, p: of panorama_code
    """
    x, y, z = 0.0, 0.0, -1.0
    if kind == _EQUIRECTANGULAR:
        longitude, latitude = p[0] + (p[1] - p[0]) * u, p[2] + (p[3] - p[2]) * v
        x, y = np.sin(longitude) * np.cos(latitude), np.sin(latitude)
        z = -np.cos(longitude) * np.cos(latitude)
    elif kind == _CUBEMAP_FACE:
        x, y = np.tan(0.5 * np.pi * (u - 0.5)), np.tan(0.5 * np.pi * (v - 0.5))
    elif kind == _MIRRORBALL:
        # The ball's normal is (a, b, s); what it reflects towards the camera comes from behind it.
        a, b = 2.0 * u - 1.0, 2.0 * v - 1.0
        squared = 1.0 - a * a - b * b
        if squared < 0.0:
            return 0.0, 0.0, 0.0
        s = np.sqrt(squared)
        x, y, z = 2.0 * s * a, 2.0 * s * b, 1.0 - 2.0 * squared
    elif kind == _CYLINDRICAL:
        a, b, sine, cosine = u - 0.5, v - 0.5, np.sin(p[4]), np.cos(p[4])
        around = p[0] + (p[1] - p[0]) * (cosine * a - sine * b + 0.5)
        along = p[2] + (p[3] - p[2]) * (sine * a + cosine * b + 0.5)
        x, y = cosine * np.sin(around) + sine * along, cosine * along - sine * np.sin(around)
        z = -np.cos(around)
    else:
        return _fisheye(kind, p, u, v)
    length = np.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


@kernel
def _fill_directions(kind, p, u, v, out):
    for k in range(len(u)):
        out[k] = panorama_direction(kind, p, u[k], v[k])


def panorama_directions(panorama: Panorama, u, v) -> np.ndarray:
    """float64 (n, 3), unit, or zeros, of places of the square, float64 (n,)."""
    out = np.empty((len(u), 3))
    _fill_directions(*panorama_code(panorama), np.float64(u), np.float64(v), out)
    return out


def pixel_angle(camera: Camera) -> float:
    """Radians across a pixel in the middle of a PANORAMIC camera's square."""
    left, right, _, _ = camera.window
    half = 0.5 * (right - left) / camera.width
    before, after = panorama_directions(camera.panorama, [0.5 - half, 0.5 + half], [0.5, 0.5])
    return float(np.arccos(np.clip(before @ after, -1.0, 1.0)))

"""Panoramic cameras: a place in the unit square -> direction, and back.

The projections are Cycles' (docs/decisions/0020-cameras.md). Directions are in the camera's own
axes: x to the right, y up, looking along -z. A panorama's square has (0, 0) at the bottom left.
"""

import numpy as np

from ._jit import kernel
from .scene import PANORAMAS, Camera, Panorama

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
_NEWTON_STEPS = 20


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


def panorama_places(panorama: Panorama, directions) -> np.ndarray:
    """float64 (n, 2): the places of the square that look along unit directions (n, 3)."""
    x, y, z = np.asarray(directions, np.float64).T
    p, kind = panorama.parameters, panorama.kind
    if kind == "EQUIRECTANGULAR":
        u = (np.arctan2(x, -z) - p[0]) / (p[1] - p[0])
        v = (np.arcsin(np.clip(y, -1.0, 1.0)) - p[2]) / (p[3] - p[2])
    elif kind == "EQUIANGULAR_CUBEMAP_FACE":
        u, v = (np.arctan2(a, -z) * 2.0 / np.pi + 0.5 for a in (x, y))
    elif kind == "MIRRORBALL":
        s = np.sqrt(np.maximum(0.5 - 0.5 * z, 1e-30))
        u, v = 0.25 * x / s + 0.5, 0.25 * y / s + 0.5
    elif kind == "CENTRAL_CYLINDRICAL":
        sine, cosine = np.sin(p[4]), np.cos(p[4])
        side, height = cosine * x - sine * y, sine * x + cosine * y
        around = (np.arctan2(side, -z) - p[0]) / (p[1] - p[0]) - 0.5
        along = (height / np.maximum(np.hypot(side, z), 1e-30) - p[2]) / (p[3] - p[2]) - 0.5
        u, v = cosine * around + sine * along + 0.5, cosine * along - sine * around + 0.5
    else:
        u, v = _fisheye_places(panorama, x, y, np.arccos(np.clip(-z, -1.0, 1.0)))
    return np.stack([u, v], -1)


def _fisheye_places(panorama, x, y, theta):
    p, sine = panorama.parameters, np.hypot(x, y)
    x, y = (np.divide(a, sine, out=np.zeros_like(a), where=sine > 0.0) for a in (x, y))
    if panorama.kind == "FISHEYE_EQUIDISTANT":
        r = theta / p[0]
        return 0.5 + r * x, 0.5 + r * y
    if panorama.kind == "FISHEYE_EQUISOLID":
        r = 2.0 * p[3] * np.sin(0.5 * theta)
    else:
        r = _polynomial_radius(theta, *p[3:])
    return 0.5 + r * x / p[1], 0.5 + r * y / p[2]


def _polynomial_radius(theta, k0, k1, k2, k3, k4):
    """The r with k0 + k1 r + ... + k4 r^4 = -theta, near the straight part's."""
    r = (-theta - k0) / k1
    for _ in range(_NEWTON_STEPS):
        value = theta + k0 + r * (k1 + r * (k2 + r * (k3 + r * k4)))
        r = r - value / (k1 + r * (2.0 * k2 + r * (3.0 * k3 + r * 4.0 * k4)))
    return r


def space_axes(camera: Camera) -> np.ndarray:
    """float64 (4, 4): the axes of Cycles' camera space, columns in the camera's own axes.

    Right, up, away; of a panorama ahead, left, up; of a mirror ball right, towards the viewer, up.
    """
    axes = np.diag([1.0, 1.0, -1.0, 1.0])
    if camera.panorama is not None:
        mirrorball = camera.panorama.kind == "MIRRORBALL"
        ahead, left = ((1, 0, 0), (0, 0, 1)) if mirrorball else ((0, 0, -1), (-1, 0, 0))
        axes[:3, :3] = np.array([ahead, left, (0, 1, 0)], np.float64).T
    return axes


def pixel_angle(camera: Camera) -> float:
    """Radians across a pixel in the middle of a PANORAMIC camera's square."""
    left, right, _, _ = camera.window
    half = 0.5 * (right - left) / camera.width
    before, after = panorama_directions(camera.panorama, [0.5 - half, 0.5 + half], [0.5, 0.5])
    return float(np.arccos(np.clip(before @ after, -1.0, 1.0)))

"""Panoramic cameras: a direction -> its place in the unit square, and the axes that nodes see.

The way back of panorama.py, without kernels: the exporters load without numba.
"""

from __future__ import annotations

import numpy as np

from ..scene import Camera, Panorama

_NEWTON_STEPS = 20


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

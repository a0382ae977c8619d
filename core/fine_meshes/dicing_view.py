"""How large what is diced is to be: pixels of a camera, or lengths in an object's own space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..camera.panorama import panorama_directions
from ..scene import ORTHOGRAPHIC, PANORAMIC, Camera

# Of View.kind.
OWN_SPACE, ORTHO, AHEAD = 0, 1, 2
_NEAR = np.float32(1e-12)
_ZERO, _HALF, _ONE, _TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)


class View(NamedTuple):
    """What kernels measure edges by.

    kind: OWN_SPACE, ORTHO or AHEAD
    matrix: float32 (3, 4), object space to the camera's space; OWN_SPACE: not used
    sides: float32 (4, 3), outward normals of the sides that the camera sees up to, from its eye;
        ORTHO: [0] is (half the width, half the height, 0) of the frame and [1] its middle
    pixel: float32, metres to a pixel (AHEAD: at a distance of 1 m); OWN_SPACE: 1
    rate: float32, pixels (OWN_SPACE: lengths) to an edge
    offscreen: float32, how fast pixels grow outside of the frame; at most 1: they do not
    """

    kind: int
    matrix: np.ndarray
    sides: np.ndarray
    pixel: np.float32
    rate: np.float32
    offscreen: np.float32


def own_space(length: float) -> View:
    """Edges of a length, in the object's space."""
    nothing = np.zeros((3, 4), np.float32), np.zeros((4, 3), np.float32)
    return View(OWN_SPACE, *nothing, _ONE, np.float32(length), _ONE)


def camera_view(camera: Camera, object_to_world: np.ndarray, rate: float, offscreen: float) -> View:
    """Edges of a rate of pixels, as Cycles counts them: of what is straight ahead, however far.

    object_to_world: float64 (4, 4)
    """
    to_camera = np.linalg.inv(camera.camera_to_world) @ object_to_world
    left, right, bottom, top = camera.window
    width, height = (right - left) / camera.width, (top - bottom) / camera.height
    kind, sides, pixel = AHEAD, np.zeros((4, 3)), min(width, height)
    if camera.kind == ORTHOGRAPHIC:
        kind = ORTHO
        sides[0] = (right - left) / 2, (top - bottom) / 2, 0.0
        sides[1] = (left + right) / 2, (bottom + top) / 2, 0.0
    elif camera.kind == PANORAMIC:
        pixel, offscreen = _angle_of_pixel(camera), 1.0  # in all directions
    else:
        sides[:] = (1.0, 0.0, right), (-1.0, 0.0, -left), (0.0, 1.0, top), (0.0, -1.0, -bottom)
        sides /= np.linalg.norm(sides, axis=1, keepdims=True)
        middle = (left + right) / 2, (bottom + top) / 2
        pixel /= np.sqrt(1.0 + middle[0] ** 2 + middle[1] ** 2)
    own = to_camera[:3].astype(np.float32), sides.astype(np.float32)
    return View(kind, *own, *map(np.float32, (pixel, rate, offscreen)))


def _angle_of_pixel(camera: Camera) -> float:
    """Radians across a pixel in the middle of the frame: the mean along x and along y."""
    left, right, bottom, top = camera.window
    half = 0.5 * (right - left) / camera.width, 0.5 * (top - bottom) / camera.height
    u, v = (np.array([0.5 - size, 0.5 + size]) for size in half)
    across = panorama_directions(camera.panorama, u, np.full(2, 0.5))
    upwards = panorama_directions(camera.panorama, np.full(2, 0.5), v)
    steps = [np.linalg.norm(ends[1] - ends[0]) for ends in (across, upwards)]
    return float(np.mean(steps))


@kernel
def pixel_at(view, x, y, z):
    """Metres to a pixel at a place in the object's space; infinite is never."""
    if view.kind == OWN_SPACE:
        return _ONE
    m = view.matrix
    px = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]
    py = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
    pz = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
    if view.kind == ORTHO:
        return view.pixel * (_ONE + _beside_frame(view, px, py, pz) * (view.offscreen - _ONE))
    far = np.sqrt(px * px + py * py + pz * pz)
    if view.offscreen > _ONE:
        far += _beside_cone(view.sides, px, py, pz, far) * (view.offscreen - _ONE)
    return view.pixel * max(far, _NEAR)


@kernel
def _beside_frame(view, px, py, pz):
    """How far it is outside of an orthographic frame, in its size."""
    size, middle = view.sides[0], view.sides[1]
    if view.offscreen <= _ONE:
        return _ZERO
    dx = max(abs(px - middle[0]) - size[0], _ZERO)
    dy = max(abs(py - middle[1]) - size[1], _ZERO)
    dz = max(pz, _ZERO)
    across = np.sqrt((size[0] * size[0] + size[1] * size[1]) * _HALF)
    return np.sqrt(dx * dx + dy * dy + dz * dz) / max(across, _NEAR)


@kernel
def _beside_cone(sides, px, py, pz, far):
    """Metres from what the camera sees, whose eye is far away: to the sides that it is outside of,
    or behind the eye to this."""
    found, behind, outside = _ZERO, False, 0
    for k in range(4):
        a, b, c = sides[k, 0], sides[k, 1], sides[k, 2]
        d = a * px + b * py + c * pz
        if d > _ZERO:
            outside += 1
            # Along the side, away from the eye: it lies beside the cone, not behind its tip.
            if c * (a * px + b * py) - (a * a + b * b) * pz >= _ZERO:
                found = max(found, d)
            else:
                behind = True
    if outside == 4:
        return far
    if behind:
        return min(found, far) if found > _ZERO else far
    return found


@kernel
def squared_length(view, dx, dy, dz):
    """The square of a length: in world space, where pixels are of a camera."""
    if view.kind != OWN_SPACE:
        m = view.matrix
        dx, dy, dz = (
            m[0, 0] * dx + m[0, 1] * dy + m[0, 2] * dz,
            m[1, 0] * dx + m[1, 1] * dy + m[1, 2] * dz,
            m[2, 0] * dx + m[2, 1] * dy + m[2, 2] * dz,
        )
    return dx * dx + dy * dy + dz * dz


@kernel
def _longest(points, ends, view):
    found = np.float32(0.0)
    for row in range(len(ends)):
        p, q = points[ends[row, 0]], points[ends[row, 1]]
        dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        x, y, z = (p[0] + q[0]) * _HALF, (p[1] + q[1]) * _HALF, (p[2] + q[2]) * _HALF
        found = max(found, np.sqrt(squared_length(view, dx, dy, dz)) / pixel_at(view, x, y, z))
    return found


def longest_edge(points: np.ndarray, ends: np.ndarray, view: View) -> float:
    """In pixels of a view. points: (n, 3); ends: int32 (e, 2), rows of these"""
    return float(_longest(points.astype(np.float32), ends, view))

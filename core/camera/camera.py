"""A place in the picture, on the lens and in the shutter's time -> ray.

As Cycles: a perspective camera's lens lies in its plane z = 0, and rays through one place of the
picture meet at the plane of focus; a panorama's lies across each ray, and they meet on a sphere.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..scene import ORTHOGRAPHIC, PANORAMIC, PERSPECTIVE, Camera, CameraMotion
from .bake_rays import bake_rays
from .lens import aperture_point
from .panorama import panorama_code, panorama_direction
from .panorama_places import panorama_places, space_axes

_PLANE = -1  # in place of a panorama's kind


class CameraRays(NamedTuple):
    """Rays of a camera, world space.

    origins: float32 (n, 3), on the near clipping plane; directions: float32 (n, 3), unit, but zeros
    where a panorama shows nothing; reach: float32 (n,), metres to the far plane, 0 there
    """

    origins: np.ndarray
    directions: np.ndarray
    reach: np.ndarray


class SurfaceRays(NamedTuple):
    """Rays of which it is known where they end: CameraRays, and the hits of an Accel."""

    origins: np.ndarray
    directions: np.ndarray
    reach: np.ndarray
    hits: tuple[np.ndarray, np.ndarray, np.ndarray]


class _View(NamedTuple):
    """What kernels know of a camera.

    path: float64 (k, 16), three rows of the matrix and the window, at evenly spaced times
    panorama, parameters: of panorama_code, or _PLANE; mirrorball: whether it is one
    lens: (radius, focus, blades, rotation, 1 / ratio), radius 0 = sharp
    """

    path: np.ndarray
    size: tuple[float, float]
    orthographic: bool
    panorama: int
    parameters: np.ndarray
    mirrorball: bool
    lens: tuple[float, float, float, float, float]
    near: float
    far: float


def _view_of(camera: Camera) -> _View:
    if camera.motion is None:
        matrices, windows = [camera.camera_to_world], [camera.window]
    else:
        matrices, windows = camera.motion.matrices, camera.motion.windows
    poses = np.asarray(matrices, np.float64)[:, :3].reshape(-1, 12)
    kind, parameters = _PLANE, np.zeros(1)
    if camera.kind == PANORAMIC:
        kind, parameters = panorama_code(camera.panorama)
    lens = (0.0, 1.0, 0.0, 0.0, 1.0)
    if camera.lens is not None:
        radius, focus, blades, rotation, ratio = camera.lens
        lens = float(radius), float(focus), float(blades), float(rotation), 1.0 / float(ratio)
    return _View(
        path=np.ascontiguousarray(np.concatenate([poses, np.asarray(windows, np.float64)], 1)),
        size=(float(camera.width), float(camera.height)),
        orthographic=camera.kind == ORTHOGRAPHIC,
        panorama=kind,
        parameters=parameters,
        mirrorball=camera.kind == PANORAMIC and camera.panorama.kind == "MIRRORBALL",
        lens=lens,
        near=float(camera.clip_start),
        far=float(camera.clip_end),
    )


@kernel
def _pose_at(path, time, pose):
    """Write the path's row at a time from 0 to 1, float64 (16,)."""
    place = time * (len(path) - 1)
    first = min(int(place), max(len(path) - 2, 0))
    part, last = place - first, min(first + 1, len(path) - 1)
    for c in range(16):
        pose[c] = path[first, c] + part * (path[last, c] - path[first, c])


@kernel
def _plane_ray(view, x, y, lens_x, lens_y, ray):
    """Write origin, direction, start and reach of a ray through (x, y) of the window."""
    focus = view.lens[1]
    ray[0], ray[1], ray[2] = lens_x, lens_y, 0.0
    if view.orthographic:
        ray[0], ray[1] = x + lens_x, y + lens_y
        dx, dy, dz = -lens_x / focus, -lens_y / focus, -1.0
    else:
        dx, dy, dz = x - lens_x / focus, y - lens_y / focus, -1.0
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    ray[3], ray[4], ray[5] = dx / length, dy / length, dz / length
    # An orthographic ray is cut along its plane, a perspective one as if it came from the centre.
    straight = length if view.orthographic else np.sqrt(x * x + y * y + 1.0)
    ray[6] = view.near * straight
    ray[7] = (view.far - view.near) * (1.0 if view.orthographic else straight)


@kernel
def _panorama_ray(view, u, v, lens_x, lens_y, ray):
    """Likewise, of a place of a panorama's square."""
    dx, dy, dz = panorama_direction(view.panorama, view.parameters, u, v)
    ray[:] = 0.0
    if dx == 0.0 and dy == 0.0 and dz == 0.0:
        return
    ray[3], ray[4], ray[5] = dx, dy, dz
    ray[6], ray[7] = view.near, view.far - view.near
    if lens_x == 0.0 and lens_y == 0.0:
        return
    # The lens' axes: towards the camera's axis (a mirror ball's: its x), and across.
    ax, ay, az, side = 0.0, 0.0, -1.0, 1.0
    if view.mirrorball:
        ax, az, side = 1.0, 0.0, -1.0
    along = ax * dx + ay * dy + az * dz
    if np.abs(along) > 0.9999999:
        ax, ay, az = az, 0.0, ax
        along = ax * dx + ay * dy + az * dz
    ax, ay, az = ax - along * dx, ay - along * dy, az - along * dz
    length = np.sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax / length, ay / length, az / length
    across = side * lens_y
    ray[0] = ax * lens_x + (dy * az - dz * ay) * across
    ray[1] = ay * lens_x + (dz * ax - dx * az) * across
    ray[2] = az * lens_x + (dx * ay - dy * ax) * across
    focus = view.lens[1]
    dx, dy, dz = focus * dx - ray[0], focus * dy - ray[1], focus * dz - ray[2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    ray[3], ray[4], ray[5] = dx / length, dy / length, dz / length


@kernel
def _fill_rays(view, x, y, lens_uv, times, pose, ray, rays):
    """Write rays. lens_uv: float64 (n, 2) or (0, 2) for the lens' centre; times: float64 (n,) or
    (0,) for a camera that stands still; pose, ray: float64 (16,), (8,), scratch"""
    _pose_at(view.path, 0.0, pose)
    lens_x = lens_y = 0.0
    for k in range(len(x)):
        if len(times):
            _pose_at(view.path, times[k], pose)
        if len(lens_uv):
            radius, _, blades, rotation, narrow = view.lens
            lens_x, lens_y = aperture_point(lens_uv[k, 0], lens_uv[k, 1], blades, rotation)
            lens_x, lens_y = radius * narrow * lens_x, radius * lens_y
        px = pose[12] + (pose[13] - pose[12]) * (x[k] / view.size[0])
        py = pose[14] + (pose[15] - pose[14]) * (y[k] / view.size[1])
        if view.panorama == _PLANE:
            _plane_ray(view, px, py, lens_x, lens_y, ray)
        else:
            _panorama_ray(view, px, py, lens_x, lens_y, ray)
        rays.reach[k] = ray[7]
        size = 0.0
        for a in range(3):
            size += (
                pose[4 * a] * ray[3] + pose[4 * a + 1] * ray[4] + pose[4 * a + 2] * ray[5]
            ) ** 2
        # The axes are askew under a parent that is scaled unevenly, and between two poses.
        size = np.sqrt(size) if size > 0.0 else 1.0
        for a in range(3):
            m0, m1, m2, place = pose[4 * a], pose[4 * a + 1], pose[4 * a + 2], pose[4 * a + 3]
            direction = (m0 * ray[3] + m1 * ray[4] + m2 * ray[5]) / size
            origin = place + m0 * ray[0] + m1 * ray[1] + m2 * ray[2]
            rays.directions[k, a] = direction
            rays.origins[k, a] = origin + ray[6] * direction


def rays_through(camera: Camera, x, y, lens_uv=None, times=None) -> CameraRays | SurfaceRays:
    """The rays through points of the frame: x, y float64 (n,), pixels, y up; centres are at .5.

    lens_uv: float64 (n, 2), numbers in [0, 1) that choose points of the lens; None: its centre
    times: float64 (n,), parts of the shutter's time, 0 to 1; None: camera.camera_to_world
    """
    if camera.bake is not None:
        return SurfaceRays(*bake_rays(camera.bake, camera, x, y))
    if times is None and camera.motion is not None:
        camera = _standing(camera)
    n = len(x)
    rays = CameraRays(
        np.empty((n, 3), np.float32), np.empty((n, 3), np.float32), np.empty(n, np.float32)
    )
    lens_uv = np.empty((0, 2)) if lens_uv is None or camera.lens is None else lens_uv
    times = np.empty(0) if times is None or camera.motion is None else times
    _fill_rays(_view_of(camera), x, y, lens_uv, times, np.empty(16), np.empty(8), rays)
    return rays


def shutter_times(motion: CameraMotion, u: np.ndarray) -> np.ndarray:
    """Times from 0 to 1, as much light comes in: float64 (n,) of numbers u in [0, 1)."""
    return np.interp(u, np.linspace(0.0, 1.0, len(motion.times)), motion.times)


def _standing(camera: Camera) -> Camera:
    """The camera in the middle of its motion."""
    return dataclasses.replace(camera, motion=None)


def camera_rays(camera: Camera, x0: int, y0: int, nx: int, ny: int) -> CameraRays:
    """``rays_through`` the centres of nx x ny pixels from (x0, y0) up, row by row."""
    columns, rows = pixel_grid(x0, y0, nx, ny)
    return rays_through(camera, columns + 0.5, rows + 0.5)


def pixel_grid(x0: int, y0: int, nx: int, ny: int) -> tuple[np.ndarray, np.ndarray]:
    """Column and row in the frame of nx x ny pixels from (x0, y0) up, row by row: int64 (n,)."""
    rows, columns = np.divmod(np.arange(nx * ny), nx)
    return columns + x0, rows + y0


def frame_places(camera: Camera, positions: np.ndarray) -> np.ndarray:
    """float64 (n, 2): where positions (n, 3) are in the frame, 0 to 1 from its lower left corner;
    NaN where they are behind a camera that looks one way."""
    axes = space_axes(camera)
    to_camera = np.linalg.inv(camera.camera_to_world @ axes)
    seen = positions @ to_camera[:3, :3].T + to_camera[:3, 3]
    if camera.kind == PANORAMIC:
        seen /= np.maximum(np.linalg.norm(seen, axis=1), 1e-30)[:, None]
        places = panorama_places(camera.panorama, seen @ axes[:3, :3].T)
    elif camera.kind == PERSPECTIVE:
        places = seen[:, :2] / np.where(seen[:, 2:] > 0.0, seen[:, 2:], np.nan)
    else:
        places = seen[:, :2]
    left, right, bottom, top = camera.window
    return (places - (left, bottom)) / (right - left, top - bottom)


def view_depth(camera: Camera, positions: np.ndarray) -> np.ndarray:
    """Metres, float32 (n,), of world positions (n, 3), as the Depth pass has them.

    Along the camera's axis; PANORAMIC: from the camera.
    """
    to_world = np.asarray(camera.camera_to_world, np.float64)
    away = to_world[:3, 3] - positions
    if camera.kind == PANORAMIC:
        return np.linalg.norm(away, axis=-1).astype(np.float32)
    return (away @ np.linalg.inv(to_world)[2, :3]).astype(np.float32)


def view_distance(camera: Camera, positions: np.ndarray) -> np.ndarray:
    """Metres, float32 (n,), from the camera to positions (n, 3); ORTHOGRAPHIC: their depth."""
    if camera.kind == ORTHOGRAPHIC:
        return np.abs(view_depth(camera, positions))
    away = np.asarray(camera.camera_to_world, np.float64)[:3, 3] - positions
    return np.linalg.norm(away, axis=-1).astype(np.float32)

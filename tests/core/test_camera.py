"""camera.py: rays go through pixel centres. (tests/addon compares with Cycles' cameras.)"""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera.camera import camera_rays, rays_through, shutter_times, view_depth
from iwis.core.scene import CameraMotion
from support.scenes import camera_above, camera_at

ASKEW = np.array([[0.8, 0.3, 0.1], [0.0, 0.9, 0.4], [0.6, 0.3, 0.9]])

CAMERAS = {
    "perspective": camera_at((3.0, -2.0, 1.5), (0.0, 0.5, 0.2), width=8, height=6, half=0.7),
    "orthographic": camera_above(width=8, height=6, half=2.0, z=5.0),
}


def _project(camera, points):
    """Pixel coordinates (n, 2) of world points, y up: a camera read backwards."""
    local = (points - camera.camera_to_world[:3, 3]) @ camera.camera_to_world[:3, :3]
    if camera.kind == "PERSPECTIVE":
        local = local / -local[:, 2:]
    left, right, bottom, top = camera.window
    x = (local[:, 0] - left) / (right - left) * camera.width
    y = (local[:, 1] - bottom) / (top - bottom) * camera.height
    return np.stack([x, y], -1)


@pytest.mark.parametrize("name", CAMERAS)
def test_every_point_of_a_ray_projects_to_its_pixels_centre(name):
    """Near and far, for all pixels of the frame, row by row from the bottom."""
    camera = CAMERAS[name]
    origins, directions, _ = camera_rays(camera, 0, 0, 8, 6)
    y, x = np.mgrid[:6, :8] + 0.5
    expected = np.stack([x.ravel(), y.ravel()], -1)
    for distance in (0.5, 20.0):
        pixels = _project(camera, origins.astype(np.float64) + distance * directions)
        np.testing.assert_allclose(pixels, expected, atol=1e-4)  # float32 rays, 8 pixels wide


@pytest.mark.parametrize("name", CAMERAS)
def test_rays_start_on_the_near_plane_and_are_unit(name):
    """clip_start metres along the axis, whatever the pixel."""
    camera = dataclasses.replace(CAMERAS[name], clip_start=0.75)
    origins, directions, _ = camera_rays(camera, 0, 0, 8, 6)
    np.testing.assert_allclose(view_depth(camera, origins), 0.75, atol=2e-6)  # float32, 5 m
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, atol=2e-7)  # float32
    assert origins.dtype == directions.dtype == np.float32


@pytest.mark.parametrize("name", CAMERAS)
def test_rays_reach_to_the_far_plane(name):
    """At the frame's sides as well, where a perspective camera's go farther."""
    camera = dataclasses.replace(CAMERAS[name], clip_start=0.2, clip_end=30.0)
    rays = camera_rays(camera, 0, 0, 8, 6)
    ends = rays.origins + rays.reach[:, None] * rays.directions
    np.testing.assert_allclose(view_depth(camera, ends), 30.0, rtol=1e-5)  # float32


@pytest.mark.parametrize("name", CAMERAS)
def test_rays_of_a_part_are_those_of_the_whole(name):
    """A tile's rays are the frame's, bit for bit: borders and tiles change nothing."""
    camera = CAMERAS[name]
    whole = [a.reshape(6, 8, -1) for a in camera_rays(camera, 0, 0, 8, 6)]
    part = [a.reshape(2, 3, -1) for a in camera_rays(camera, 4, 3, 3, 2)]
    for a, b in zip(whole, part, strict=True):
        np.testing.assert_array_equal(a[3:5, 4:7], b)


def test_shifted_windows_move_the_picture():
    """Lens shift is in the window: a window moved by two pixels shows the frame moved by two."""
    camera = CAMERAS["perspective"]
    left, right, bottom, top = camera.window
    step = 2.0 * (right - left) / camera.width
    shifted = dataclasses.replace(camera, window=(left + step, right + step, bottom, top))
    _, before, _ = camera_rays(camera, 2, 0, 4, 6)
    _, after, _ = camera_rays(shifted, 0, 0, 4, 6)
    np.testing.assert_allclose(after, before, atol=1e-7)  # float32


def test_view_depth_is_along_the_axis():
    """Not along the ray: all points of a plane across the axis are equally deep."""
    camera = CAMERAS["orthographic"]
    positions = np.float32([[0, 0, 4], [1.5, -1, 4], [0, 0, 6]])
    np.testing.assert_allclose(view_depth(camera, positions), [1.0, 1.0, -1.0], atol=1e-6)


def _moving(camera):
    """It goes a metre to the right and turns by a right angle about z, in 90 steps."""
    turns = np.linspace(0.0, 0.5 * np.pi, 91)
    matrices = np.tile(np.eye(4), (91, 1, 1))
    matrices[:, 0, 0] = matrices[:, 1, 1] = np.cos(turns)
    matrices[:, 1, 0] = np.sin(turns)
    matrices[:, 0, 1] = -np.sin(turns)
    matrices[:, 0, 3] = np.linspace(0.0, 1.0, 91)
    matrices = matrices @ camera.camera_to_world
    windows = np.tile(camera.window, (91, 1)) * np.linspace(1.0, 2.0, 91)[:, None]
    motion = CameraMotion(matrices, windows, np.linspace(0.0, 1.0, 5))
    return dataclasses.replace(
        camera, motion=motion, camera_to_world=matrices[45], window=tuple(windows[45])
    )


@pytest.mark.parametrize("name", CAMERAS)
def test_rays_at_a_time_are_those_of_the_camera_then(name):
    """At the ends, in the middle, and between two places of the table."""
    camera = _moving(CAMERAS[name])
    x, y = np.array([0.5, 3.25, 7.0]), np.array([0.5, 2.0, 5.5])
    for time in (0.0, 0.5, 1.0, 0.3, 0.7023):
        turn, scale = 0.5 * np.pi * time, 1.0 + time
        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        matrix[0, 3] = time
        still = dataclasses.replace(
            CAMERAS[name],
            camera_to_world=matrix @ CAMERAS[name].camera_to_world,
            window=tuple(scale * edge for edge in CAMERAS[name].window),
        )
        rays = rays_through(camera, x, y, times=np.full(3, time))
        for a, b in zip(rays, rays_through(still, x, y), strict=True):
            # a degree a step: 1 - cos of half of it, 4e-5, on 5 m
            np.testing.assert_allclose(a, b, atol=3e-4)


def test_without_a_time_a_moving_camera_is_in_its_middle():
    """camera_to_world and window say where: the Depth pass, and one point a pixel."""
    camera = _moving(CAMERAS["perspective"])
    still = dataclasses.replace(camera, motion=None)
    for a, b in zip(camera_rays(camera, 0, 0, 8, 6), camera_rays(still, 0, 0, 8, 6), strict=True):
        np.testing.assert_array_equal(a, b)


def test_shutter_times_are_where_the_light_comes_in():
    """Half of the light in the first tenth: half of the numbers give times in it."""
    motion = CameraMotion(np.zeros((2, 4, 4)), np.zeros((2, 4)), np.array([0.0, 0.1, 1.0]))
    found = shutter_times(motion, np.array([0.0, 0.25, 0.5, 0.75]))
    np.testing.assert_allclose(found, [0.0, 0.05, 0.1, 0.55])


@pytest.mark.parametrize("name", CAMERAS)
def test_rays_of_a_camera_with_slanted_axes_are_unit(name):
    """As under a parent that is scaled unevenly: along the slanted way, from the near plane on,
    and what lies in a plane along its x and y has one depth."""
    camera, askew = CAMERAS[name], np.eye(4)
    askew[:3, :3] = ASKEW / np.linalg.norm(ASKEW, axis=0)
    straight = dataclasses.replace(camera, camera_to_world=np.eye(4))
    slanted = dataclasses.replace(camera, camera_to_world=askew)
    rays, own = camera_rays(straight, 0, 0, 8, 6), camera_rays(slanted, 0, 0, 8, 6)
    np.testing.assert_allclose(np.linalg.norm(own.directions, axis=1), 1.0, rtol=1e-6)  # float32
    expected = rays.directions @ askew[:3, :3].T
    expected /= np.linalg.norm(expected, axis=1)[:, None]
    np.testing.assert_allclose(own.directions, expected, atol=1e-6)
    plane = np.array([[0.0, 0.0, -2.0], [1.0, 0.5, -2.0], [-3.0, 2.0, -2.0]]) @ askew[:3, :3].T
    np.testing.assert_allclose(view_depth(slanted, plane), 2.0, rtol=1e-6)

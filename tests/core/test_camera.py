"""core/camera.py: rays go through pixel centres. (tests/addon compares with Cycles' cameras.)"""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera import camera_rays, view_depth
from support.scenes import camera_above, camera_at

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

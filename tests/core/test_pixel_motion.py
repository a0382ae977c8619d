"""The Vector pass: pixels that things move from one frame to the next."""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera.camera import frame_places, rays_through
from iwis.core.data.object_motion import PixelMotion
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, PANORAMIC, SHADOW_RAYS, Panorama
from support.scenes import (
    camera_above,
    camera_at,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
)
from support.shapes import shapes_of

PANORAMAS = {
    "EQUIRECTANGULAR": (-np.pi, np.pi, -np.pi / 2, np.pi / 2),
    "FISHEYE_EQUIDISTANT": (np.pi,),
    "MIRRORBALL": (),
}
FILTERS = pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
STILL = np.eye(4)


def shift(x, y, z=0.0):
    """A matrix."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def two_floors(camera, before=STILL, later=STILL, moves=(STILL, STILL), shapes=(), **fields):
    """One on the left stands, one on the right goes from ``before`` to ``later``."""
    left, right = floor(0.3), floor(0.3)
    left[0][:, 0] -= 0.5
    right[0][:, 0] += 0.5
    scene = make_scene([left, right], [diffuse()] * 2, constant_world(), camera, **fields)
    row = np.array([-1, 0], np.int32)
    matrices = np.array([[before], [later]])
    motion = PixelMotion(row, matrices, shapes, np.array(moves), np.zeros((2, 4)))
    return dataclasses.replace(scene, pixel_motion=motion)


def vectors(scene, pixel_filter="CENTER"):
    """The pass of a picture."""
    settings = {"stop_rule": "FIXED", "max_samples": 64, "pixel_filter": pixel_filter}
    return make_picture(scene, **settings)[0]["vector"]


@FILTERS
def test_what_moves_has_vectors(pixel_filter):
    """From here to before, and from later to here; .1 m are a pixel, the whole one or a part."""
    scene = two_floors(camera_above(18, 18), shift(-0.2, 0.1), shift(0.5, 0.3))
    found = vectors(scene, pixel_filter)
    np.testing.assert_allclose(found[9, 13], (-2.0, 1.0, -5.0, -3.0), atol=1e-4)
    moved = np.unique(np.round(found.reshape(-1, 4), 3), axis=0)
    assert len(moved) == 2 and not moved[1].any()


def test_a_moving_camera_moves_all_the_other_way():
    """And nothing of a world without an end that a parallel camera sees."""
    scene = two_floors(camera_above(18, 18), moves=(shift(0.1, 0.0), shift(0.0, -0.3)))
    found = vectors(scene)
    for column in (4, 13):
        np.testing.assert_allclose(found[9, column], (-1.0, 0.0, 0.0, -3.0), atol=1e-4)
    assert not found[0, 0].any()


def test_shapes_are_followed():
    """A floor whose right half is raised and pulled: each of its points for itself."""
    scene = two_floors(camera_above(18, 18))

    def pulled(vertices, t):
        x, y, z = vertices.T
        return np.stack([x, y + 0.8 * t * (x - 0.2), z], -1)

    shapes = shapes_of(scene.mesh, [1], pulled, steps=3)
    motion = scene.pixel_motion._replace(shapes=(shapes,))
    found = vectors(dataclasses.replace(scene, pixel_motion=motion))
    x = (np.arange(18) + 0.5) / 10 - 0.9
    inside = np.abs(x - 0.5) < 0.3
    by = np.stack([0 * x, -4.0 * (x - 0.2), 0 * x, -4.0 * (x - 0.2)], -1)
    np.testing.assert_allclose(found[9, inside], by[inside], atol=1e-3)
    assert not found[9, x < 0.1].any()


def test_the_world_turns_with_a_perspective_camera():
    """A pan by an angle moves the middle of the picture by its tangent, at any distance."""
    camera = camera_at((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), 20, 20, half=0.5)
    turn, angle = np.eye(4), 0.1
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    about = shift(0.0, -4.0) @ turn @ shift(0.0, 4.0)
    scene = two_floors(camera, moves=(about, shift(50.0, 0.0)))
    middle = vectors(scene)[10:12, 9:11].mean(axis=(0, 1))
    # To the left the camera looks then: what it has seen was to its right. A move alone: nothing.
    np.testing.assert_allclose(middle, (20.0 * np.tan(angle), 0.0, 0.0, 0.0), atol=0.03)


def test_what_is_behind_a_camera_has_no_place():
    """No number and no warning of one: such rays do not count."""
    scene = two_floors(camera_at((0.0, -4.0, 1.0), (0.0, 0.0, 0.0)), shift(0.0, -50.0))
    found = vectors(scene)
    assert np.isfinite(found).all()


@pytest.mark.parametrize("kind", sorted(PANORAMAS))
def test_places_in_the_frame_are_those_that_rays_go_through(kind):
    """The way back of a camera's rays, in the frame's units."""
    camera = dataclasses.replace(
        camera_at((1.0, -4.0, 2.0), (0.0, 0.0, 0.5), 20, 16),
        kind=PANORAMIC,
        window=(0.0, 1.0, 0.1, 1.1),
        panorama=Panorama(kind, PANORAMAS[kind]),
    )
    x, y = np.float64([4.3, 9.5, 12.7]), np.float64([7.1, 5.5, 9.9])
    rays = rays_through(camera, x, y)
    looks = rays.directions.any(axis=1)
    places = frame_places(camera, rays.origins + 3.0 * rays.directions.astype(np.float64))
    np.testing.assert_allclose(places[looks, 0] * 20, x[looks], atol=1e-3)
    np.testing.assert_allclose(places[looks, 1] * 16, y[looks], atol=1e-3)
    assert looks.any()


@FILTERS
def test_holdouts_have_none_and_asking_changes_no_pixel(pixel_filter):
    """Of all other layers, to the last bit."""
    flags = np.array([0, HOLDOUT], np.int32) | CAMERA_RAYS | SHADOW_RAYS
    scene = two_floors(camera_above(18, 18), shift(-0.2, 0.1), object_flags=flags)
    settings = {"stop_rule": "FIXED", "max_samples": 16, "pixel_filter": pixel_filter}
    asked, _ = make_picture(scene, **settings)
    plain, _ = make_picture(dataclasses.replace(scene, pixel_motion=None), **settings)
    assert not asked["vector"].any()
    for name in plain:
        np.testing.assert_array_equal(asked[name], plain[name])

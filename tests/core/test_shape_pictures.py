"""Pictures of meshes that change their shape while the shutter is open."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import AskedPasses, UvMaps
from support.scenes import (
    black,
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    quad,
    varied_scene,
)
from support.shapes import SLICES, bent, mesh_at, shapes_of, shift, standing, standing_camera


@pytest.fixture(scope="module")
def room():
    """The varied scene, of which a box bends and moves and a sphere bends, in other steps."""
    scene = varied_scene()
    shapes = shapes_of(scene.mesh, [1], bent), shapes_of(scene.mesh, [2], bent, steps=3)
    return dataclasses.replace(scene, motion=standing(shapes, [1], [shift]))


@pytest.mark.slow
def test_uv_stays_on_what_stretches():
    """A floor that is 1 + t as wide, t of -.5 to .5: the mean of x / (1 + t) is x log 3."""
    camera = standing_camera(camera_above(16, 8))
    scene = make_scene([floor(4.0)], [diffuse()], constant_world(), camera)
    shapes = shapes_of(scene.mesh, [0], lambda p, t: p * (1.0 + t, 1.0, 1.0), steps=3)
    corners = scene.mesh.vertices[scene.mesh.triangles][..., :2].astype(np.float32)
    maps = UvMaps(np.arange(len(corners), dtype=np.int32), corners, np.array([False]))
    scene = dataclasses.replace(scene, motion=standing([shapes]), asked=AskedPasses(uv=maps))
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 128}
    uv = make_picture(scene, **settings)[0]["uv"]
    middle = (np.arange(16) + 0.5) / 16 * 1.8 - 0.9
    # 8 x 16 passes at drawn times in sixteenths: x / (1 + t) differs by .13 x from one to the next.
    np.testing.assert_allclose(uv[..., 0].mean(axis=0), middle * np.log(3.0), atol=0.03)
    np.testing.assert_allclose(uv[..., 2], 1.0, atol=1e-6)


@pytest.mark.slow
def test_a_bright_square_that_grows_is_spread_as_its_time():
    """Its right edge goes from -.6 to .6: a place shines for the time after the edge is there."""
    camera = standing_camera(camera_above(48, 8))
    square = quad((-0.7875, -2.0, 0.0), (0.7875, 0.0, 0.0), (0.0, 4.0, 0.0))  # from a pixel's edge
    scene = make_scene([square], [black(emission=(1.0,) * 3)], constant_world((0.0,) * 3), camera)

    def grow(vertices, t):
        right = vertices[:, :1] > -0.1
        return vertices + right * np.array([1.2 * t, 0.0, 0.0])

    scene = dataclasses.replace(scene, motion=standing([shapes_of(scene.mesh, [0], grow, steps=3)]))
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 512}
    found = make_picture(scene, **settings)[0]["combined"][..., 0].mean(axis=0)
    middle = (np.arange(48) + 0.5) / 48 * 1.8 - 0.9
    wanted = np.where(middle > -0.7875, np.clip((0.6 - middle) / 1.2, 0.0, 1.0), 0.0)
    # A slice of 64 more or less is .016; a column's 8 x 128 passes have a standard error of .0135.
    np.testing.assert_allclose(found, wanted, atol=0.05)
    assert found.sum() == pytest.approx(wanted.sum(), rel=0.01)


@pytest.mark.slow
def test_shadows_of_changing_shapes_are_the_mean_over_the_time():
    """The floor under a bending box has the mean of the pictures of boxes that stand in slices."""
    camera = standing_camera(camera_above(24, 24))
    parts = [floor(1.2), box((-0.2, -0.2, 0.3), (0.2, 0.2, 0.6))]
    still = make_scene(parts, [diffuse(), diffuse()], constant_world(), camera)
    shapes = shapes_of(still.mesh, [1], lambda p, t: bent(p, 2.0 * t))
    shapes = shapes._replace(normal_index=np.full_like(shapes.normal_index, -1))
    scene = dataclasses.replace(still, motion=standing([shapes]))
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "threads": 2}
    found = make_picture(scene, max_samples=1024, **settings)[0]["combined"]
    wanted = 0.0
    for number in range(2, SLICES, 4):
        one = dataclasses.replace(still, mesh=mesh_at(scene, number))
        wanted = wanted + make_picture(one, max_samples=128, **settings)[0]["combined"] / 16.0
    difference = (found - wanted)[..., 0]
    assert abs(difference.mean()) < 0.003 * wanted[..., 0].mean()
    # 16 places in the second mean, up to .06 m apart, .075 m a pixel; the noise of 1024 samples.
    assert np.abs(difference).mean() < 0.015


def test_pictures_do_not_depend_on_tiles_or_threads(room):
    """To the last bit, as without motion."""
    own = dataclasses.replace(room, camera=standing_camera(room.camera))
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 16}
    one = make_picture(own, tile_px=64, **settings)[0]["combined"]
    two = make_picture(own, tile_px=8, **{**settings, "threads": 2})[0]["combined"]
    np.testing.assert_array_equal(one, two)


def test_center_shows_the_middle(room):
    """One point a pixel: as if nothing had changed."""
    settings = {"max_samples": 8, "stop_rule": "FIXED"}
    found = make_picture(room, **settings)[0]["combined"]
    still = make_picture(dataclasses.replace(room, motion=None), **settings)[0]["combined"]
    np.testing.assert_array_equal(found, still)

"""The ambient-occlusion pass (core/passes/ambient_occlusion.py)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import AskedPasses
from support.scenes import (
    camera_at,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    quad,
    sphere,
)

FILTERS = ("CENTER", "BOX")


def _pass(parts, reach, pixel_filter="CENTER", **settings):
    """float32 (8, 8, 3) and the shadow rays, of a metre of the floor, seen from under a roof."""
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), 8, 8, 0.6)
    scene = make_scene(parts, [diffuse()] * len(parts), constant_world(), camera)
    scene = dataclasses.replace(scene, asked=AskedPasses(occlusion_distance=reach))
    settings = {"max_samples": 256, "stop_rule": "FIXED"} | settings
    layers, stats = make_picture(scene, pixel_filter=pixel_filter, **settings)
    return layers["ambient_occlusion"], stats.shadow_rays


@pytest.mark.parametrize("pixel_filter", FILTERS)
@pytest.mark.parametrize(("reach", "expected"), [(0.5, 1.0), (2.0, 0.25), (1e4, 0.0)])
def test_roof_hides_what_is_within_reach(pixel_filter, reach, expected):
    """Under an endless roof at 1 m rays of 2 m meet it within 60 degrees: sin^2 of that, .75."""
    shown, _ = _pass([floor(1.0), floor(500.0, 1.0)], reach, pixel_filter)
    # 64 points of Sobol's sequence a pixel or more, scrambled: a standard error of .02.
    np.testing.assert_allclose(shown, expected, atol=0.08)
    assert abs(shown.mean() - expected) < 0.005


def test_wall_hides_half():
    """At the foot of an endless wall."""
    wall = quad((-500.0, -0.45, 0.0), (1000.0, 0.0, 0.0), (0.0, 0.0, 500.0))
    shown, _ = _pass([floor(1.0), wall], 1e5)
    nearest, farthest = shown[0].mean(), shown[-1].mean()
    assert abs(min(nearest, farthest) - 0.5) < 0.06 and max(nearest, farthest) < 0.6


@pytest.mark.parametrize("pixel_filter", FILTERS)
@pytest.mark.parametrize("offset", [0.0, 0.1])
def test_rays_below_the_face_go_through_it(pixel_filter, offset):
    """A floor alone is open whatever its normals say, as in Cycles: 60 degrees off it were .75."""
    vertices, triangles, normals = floor(1.0)
    tilted = np.broadcast_to(np.float32([0.75**0.5, 0.0, 0.5]), normals.shape)
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), 8, 8, 0.6)
    offset = np.float32([offset])
    own = constant_world(), camera
    scene = make_scene([(vertices, triangles, tilted)], [diffuse()], *own, terminator_offset=offset)
    scene = dataclasses.replace(scene, asked=AskedPasses(occlusion_distance=10.0))
    layers, _ = make_picture(scene, max_samples=64, pixel_filter=pixel_filter)
    assert (layers["ambient_occlusion"] == 1.0).all()


def test_coarse_smooth_balls_are_open_where_their_patches_are():
    """Rays below the facet start from the smooth patch as well, as Cycles': a ball is open.

    Without an offset those rays end in the ball.
    """
    camera = camera_at((0.0, -4.0, 0.6), (0.0, 0.0, 0.0), 32, 32, 0.5)
    ball = [sphere(rings=8, smooth=True)], [diffuse()], constant_world(), camera
    means = []
    for offset in (0.0, 0.1):
        scene = make_scene(*ball, terminator_offset=np.float32([offset]))
        scene = dataclasses.replace(scene, asked=AskedPasses(occlusion_distance=10.0))
        shown = make_picture(scene, max_samples=64, pixel_filter="CENTER")[0]["ambient_occlusion"]
        means.append(shown[shown > 0.0].mean())
    assert means[0] < 0.996 and means[1] > 0.9999


def test_nothing_is_traced_that_is_not_wanted():
    """Without the pass its layer is black and no ray is spent; with it 64 a point are."""
    parts = [floor(1.0)]
    shown, rays = _pass(parts, 0.0)
    _, more = _pass(parts, 1.0)
    assert not shown.any() and more - rays == 64 * 64


@pytest.mark.parametrize("pixel_filter", FILTERS)
def test_same_picture_whatever_the_tiles(pixel_filter):
    """Each pixel's rays are its own."""
    parts = [floor(1.0), floor(500.0, 1.0)]
    small, whole = (_pass(parts, 2.0, pixel_filter, tile_px=size)[0] for size in (8, 64))
    np.testing.assert_array_equal(small, whole)

"""The ambient-occlusion pass (core/passes/ambient_occlusion.py)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import AskedPasses
from support.scenes import camera_at, constant_world, diffuse, floor, make_picture, make_scene, quad

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

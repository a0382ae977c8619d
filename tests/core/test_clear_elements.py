"""Points and strands that let light through: a ray passes once by their two faces."""

import dataclasses

import numpy as np
import pytest

import iwis.core.see_through.ray_masks as ray_masks
from iwis.core.data.program import Closure, Program
from iwis.core.scene import BLACK, GGX, ROUND
from support.programs import with_programs
from support.scenes import (
    box,
    camera_at,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    sphere,
)

_ONE = np.ones(3, np.float32)
_TINT = np.float32([0.9, 0.5, 0.2])
_PANE = Program(ops=(), closures=(Closure(BLACK, GGX, _ONE, {}),), transparent=_TINT)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("is_point", [True, False])
def test_camera_sees_through_a_point_by_its_front_alone(pixel_filter, is_point):
    """A ball of glass tints once as a point, and twice as a mesh."""
    camera = camera_at((0.0, 0.0, 3.0), (0.0, 0.01, 0.0), 6, 6, 0.1)
    scene = make_scene([sphere()], [diffuse()], constant_world(), camera)
    offset = np.float32([ROUND if is_point else 0.0])
    scene = with_programs(dataclasses.replace(scene, terminator_offset=offset), _PANE)
    world = make_picture(scene, max_samples=8, pixel_filter=pixel_filter)[0]["environment"]
    expected = _TINT if is_point else _TINT**2
    np.testing.assert_allclose(world, np.broadcast_to(expected, world.shape), atol=1e-5)


@pytest.mark.parametrize("way", ["by Embree's filter", "hit by hit"])
def test_shadow_of_an_element_is_that_of_one_face(way, monkeypatch):
    """Under a slab that is one, as wide as the sky: its color once, of which .5 is reflected."""
    if way == "hit by hit":
        monkeypatch.setattr(ray_masks, "can_filter", lambda: False)
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), 6, 6, 0.6)
    slab = box((-500.0, -500.0, 1.0), (500.0, 500.0, 1.1))
    half = diffuse((0.5, 0.5, 0.5))
    scene = make_scene([floor(1.0), slab], [half, diffuse()], constant_world(), camera)
    offset = np.float32([0.0, ROUND])
    scene = with_programs(dataclasses.replace(scene, terminator_offset=offset), None, _PANE)
    light = make_picture(scene, max_samples=2048, stop_rule="FIXED")[0]["combined"][..., :3]
    expected = 0.5 * _TINT if way == "by Embree's filter" else 0.5 * _TINT.mean() * _ONE
    # 36 pixels of 2048 rays: .002 of 1, of which three; two grids keep half a step of 255 each.
    np.testing.assert_allclose(light.mean((0, 1)), expected, atol=0.5 * (3 * 0.002 + 1 / 255))

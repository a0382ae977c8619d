"""Spots with a radius whose nodes vary: by direction or by the place on their ball."""

import math

import bpy
import pytest

from support.above import look_from_above
from support.exported_lamps import dress, exported, nodes_of


@pytest.fixture
def scene(scene):
    """Empty but for a camera."""
    look_from_above(scene)
    return scene


def add_spot(**settings):
    """A spot with a ball of 0.3 m."""
    light = bpy.data.lights.new("Lamp", "SPOT")
    light.use_soft_falloff, light.shadow_soft_size = False, 0.3
    for name, value in settings.items():
        setattr(light, name, value)
    obj = bpy.data.objects.new("Lamp", light)
    bpy.context.scene.collection.objects.link(obj)
    return obj


@pytest.mark.parametrize("angle", [40.0, 175.0], ids=["plane", "sphere"])
@pytest.mark.parametrize("output", ["UV", "Normal"])
def test_the_uv_map_of_a_spot_with_a_radius_is_by_direction(scene, angle, output):
    """As in Cycles; other coordinates are where on its ball a ray begins, which is all around."""
    obj = add_spot(spot_size=math.radians(angle))
    dress(obj, "ShaderNodeTexCoord", output)
    row, warnings = exported()
    _, width, height, by_direction = row["picture"]
    assert by_direction == (output == "UV")
    on_plane = by_direction and angle < 90.0
    assert width == (height if on_plane else 2 * height)
    assert not any("Lamp" in line for line in warnings)


def test_a_spot_that_asks_for_its_uv_map_and_places_says_so(scene):
    """A picture is of one or the other."""
    obj = add_spot()
    noise = dress(obj)
    tree, _ = nodes_of(obj)
    mix, place = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["UV"], mix.inputs[0])
    tree.links.new(place.outputs["Object"], mix.inputs[1])
    tree.links.new(mix.outputs[0], noise.inputs["Vector"])
    assert any("its UV map is by direction" in line for line in exported()[1])
    obj.data.shadow_soft_size = 0.0  # all of it is in one place
    assert not any("its UV map is by direction" in line for line in exported()[1])

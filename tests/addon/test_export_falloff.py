"""Light Falloff of lights: tables by the distance."""

import bpy
import numpy as np
import pytest

from iwis.core.data.lamps import falloff_knots
from iwis.iwis_addon.export import export_scene
from support.above import look_from_above
from support.exported_lamps import exported


@pytest.fixture
def scene(scene):
    """Empty but for a camera."""
    look_from_above(scene)
    return scene


def add_light(kind, **settings):
    """A light object; settings: of the light."""
    light = bpy.data.lights.new("Lamp data", kind)
    obj = bpy.data.objects.new("Lamp", light)
    for key, value in settings.items():
        setattr(light, key, value)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _falls_off(obj, output, **inputs):
    """Have a light's strength come from a Light Falloff node."""
    if bpy.app.version < (5, 0):
        obj.data.use_nodes = True
    tree = obj.data.node_tree
    emission = tree.nodes["Emission"]
    node = tree.nodes.new("ShaderNodeLightFalloff")
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    tree.links.new(node.outputs[output], emission.inputs["Strength"])
    return tree, emission


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA"])
def test_light_falloff_is_a_table_by_distance(scene, kind):
    """Of rows for each doubling: radiance x factor is Strength x distance; quadratic is none."""
    obj = add_light(kind, energy=5.0)
    plain, _ = exported()
    tree, emission = _falls_off(obj, "Linear", Strength=3.0)
    row, warnings = exported()
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[]).lamps
    light = row["radiance"][0] * lamps.falloffs[row["falloff"], :, 0]
    np.testing.assert_allclose(light, 3.0 * plain["radiance"][0] * falloff_knots(), rtol=1e-5)
    assert not row["picture"].any() and not any("Lamp" in line for line in warnings)
    falloff = tree.nodes["Light Falloff"]
    tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
    assert exported()[0]["falloff"] == -1


def test_a_beam_falls_off_and_a_sun_does_not(scene):
    """An area of spread 0 has a table; a sun shines with Strength, as in Cycles."""
    _falls_off(add_light("AREA", energy=5.0, spread=0.0), "Constant", Smooth=2.0)
    row, warnings = exported()
    assert row["falloff"] == 0 and not any("Lamp" in line for line in warnings)
    bpy.data.objects.remove(bpy.data.objects["Lamp"])
    _falls_off(add_light("SUN", energy=2.0, angle=0.0), "Constant", Strength=3.0, Smooth=2.0)
    row, warnings = exported()
    assert row["falloff"] == -1 and not any("Lamp" in line for line in warnings)
    np.testing.assert_allclose(row["radiance"], 6.0)

"""export/lamps/lamp_pictures.py: the nodes of Blender's lights."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import ExportCache, export_scene
from iwis.iwis_addon.export.lamps import lamp_pictures
from support.above import look_from_above
from support.exported_lamps import add_light, dress, exported, nodes_of


@pytest.fixture
def scene(scene):
    """Empty but for a camera."""
    look_from_above(scene)
    return scene


def test_nodes_of_a_lamp_multiply_its_strength(scene):
    """Color and Strength of its Emission, by constants and by RGB, Value and Light Falloff."""
    tree, emission = nodes_of(add_light("SUN", angle=0.0, energy=2.0))
    emission.inputs["Color"].default_value = (0.5, 0.25, 1.0, 1.0)
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    falloff.inputs["Strength"].default_value = 3.0
    tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
    row, warnings = exported()
    np.testing.assert_allclose(row["radiance"], (3.0, 1.5, 6.0))
    assert not any("Lamp" in line for line in warnings)


@pytest.mark.parametrize("kind", ["AREA", "POINT", "SPOT"])
def test_nodes_that_vary_are_a_picture(scene, kind):
    """Its mean luminance is 1 and a part of the radiance; a lamp without nodes has none."""
    obj = add_light(kind, energy=5.0)
    plain, _ = exported()
    assert not plain["picture"].any()
    dress(obj, "ShaderNodeTexCoord", "UV")
    lines = []
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps
    first, width, height, _ = lamps.picture[0]
    assert first == 0 and len(lamps.texels) == width * height > 0
    luminance = lamps.texels @ np.float32([0.2126, 0.7152, 0.0722])
    assert luminance.mean() == pytest.approx(1.0, rel=1e-4) and luminance.std() > 0.01
    # Red and green rise from 0 to 1; a spot's and an area's in even steps, blue is 0.
    np.testing.assert_allclose(
        lamps.radiance[0] / plain["radiance"], 0.5 * (0.2126 + 0.7152), rtol=1e-3
    )
    assert not any("Lamp" in line for line in lines)


def test_copies_of_a_lamp_have_a_picture_each(scene):
    """For nodes may ask where they are."""
    for x in (10.0, 20.0):
        obj = add_light("AREA", f"Lamp {x}", energy=5.0)
        obj.location.x = x
        dress(obj, "ShaderNodeNewGeometry", "Position")
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[]).lamps
    assert lamps.picture[1, 0] == lamps.picture[0, 1] * lamps.picture[0, 2]
    red = [part.mean() for part in np.split(lamps.texels[:, 0], 2)] * lamps.radiance[:, 0]
    assert red[1] == pytest.approx(2.0 * red[0], rel=1e-3)


def test_a_picture_is_made_anew_where_its_lamp_has_changed(scene, monkeypatch):
    """From frame to frame: not for another thing that moves, nor for the camera unless asked."""
    made, original = [], lamp_pictures.lamp_picture

    def counted(*given):
        made.append(given)
        return original(*given)

    monkeypatch.setattr(lamp_pictures, "lamp_picture", counted)
    obj, cache = add_light("AREA", energy=5.0), ExportCache()
    dress(obj, "ShaderNodeTexCoord", "UV")

    def count():
        made.clear()
        lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[], cache=cache).lamps
        return len(made), lamps

    (first, before), (again, after) = count(), count()
    assert (first, again) == (1, 0)
    np.testing.assert_array_equal(before.texels, after.texels)
    bpy.context.scene.camera.location.x += 1.0
    assert count()[0] == 0
    obj.location.x += 1.0
    assert count()[0] == 1
    dress(obj, "ShaderNodeCameraData", "View Vector")
    assert count()[0] == 1
    bpy.context.scene.camera.location.x += 1.0
    assert count()[0] == 1


def test_a_black_picture_is_no_lamp(scene):
    """As one of no strength."""
    obj = add_light("AREA", energy=5.0)
    dress(obj)
    _, emission = nodes_of(obj)
    emission.inputs["Strength"].default_value = 0.0
    row, warnings = exported()
    assert row is None and not any("Lamp" in line for line in warnings)


def test_an_image_that_is_missing_is_told(scene):
    """Pink, as in Cycles."""
    node = dress(add_light("AREA", energy=5.0), "ShaderNodeTexImage")
    node.image = bpy.data.images.new("Gone", 4, 4)
    node.image.source, node.image.filepath = "FILE", "//not-there.png"
    lines = []
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps
    assert len(lamps.kind) == 1
    assert any('object "Lamp", light "Lamp data"' in line and "Gone" in line for line in lines)

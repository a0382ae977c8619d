"""export/lamps/lamps.py: Blender's lights in Cycles' units, and what is told of them."""

import math

import bpy
import numpy as np
import pytest

import iwis
from iwis.core.data.lamps import (
    BEAM,
    BY_CAMERA,
    BY_DIFFUSE,
    BY_GLOSSY,
    DISC,
    ELLIPSE,
    NOT_BY_BSDF,
    RECTANGLE,
    ROUND_BEAM,
    SPHERE,
    SUN,
)
from iwis.iwis_addon.export import export_scene
from support.above import look_from_above
from support.exported_lamps import add_light, dress, exported, nodes_of


@pytest.fixture
def scene(scene):
    """Empty but for a camera."""
    look_from_above(scene)
    return scene


FOUR_PI = 4.0 * math.pi
STRENGTHS = {
    "point": ("POINT", {}, SPHERE, 80.0 / FOUR_PI),
    "point, watts a steradian": ("POINT", {"normalize": False}, SPHERE, 80.0 / math.pi),
    "ball": ("POINT", {"shadow_soft_size": 0.5}, SPHERE, 80.0 / (FOUR_PI * math.pi * 0.25)),
    "soft": ("POINT", {"use_soft_falloff": True}, DISC, 80.0 / FOUR_PI),
    "exposed": ("POINT", {"exposure": -2.0}, SPHERE, 20.0 / FOUR_PI),
    "sun": ("SUN", {"angle": 0.0}, SUN, 80.0),
    "wide sun": ("SUN", {"angle": 0.4}, SUN, 80.0 / (math.pi * math.sin(0.2) ** 2)),
    "sky": ("SUN", {"angle": 0.4, "normalize": False}, SUN, 80.0),
    "square": ("AREA", {"size": 2.0}, RECTANGLE, 80.0 / (math.pi * 4.0)),
    "panel": ("AREA", {"size": 2.0, "normalize": False}, RECTANGLE, 80.0 / math.pi),
    "disk": ("AREA", {"shape": "DISK", "size": 2.0}, ELLIPSE, 80.0 / math.pi**2),
    "beam": ("AREA", {"size": 2.0, "spread": 0.0}, BEAM, 20.0),
    "round beam": (
        "AREA",
        {"shape": "ELLIPSE", "size": 2.0, "size_y": 1.0, "spread": 0.0},
        ROUND_BEAM,
        80.0 / (0.5 * math.pi),
    ),
}


@pytest.mark.parametrize("name", STRENGTHS)
def test_strength_is_cycles(scene, name):
    """Radiance, intensity or irradiance; tests/parity has the pictures."""
    kind, settings, expected, radiance = STRENGTHS[name]
    if kind == "POINT":
        settings = {"use_soft_falloff": False} | settings
    add_light(kind, energy=80.0, color=(1.0, 0.5, 0.25), **settings)
    row, warnings = exported()
    assert row["kind"] == expected
    np.testing.assert_allclose(row["radiance"], radiance * np.array([1, 0.5, 0.25]), rtol=1e-6)
    assert row["seen_by"] == BY_DIFFUSE | BY_GLOSSY and row["shadow"]
    assert not any("Lamp" in line for line in warnings)


@pytest.mark.parametrize(("kind", "strength"), [("OBJECT", 0.5), ("VIEW_LAYER", 3.0)])
def test_nodes_read_properties(scene, kind, strength):
    """Of the object before its light, and of the scene: it was dark, and nothing told so."""
    obj = add_light("SUN", energy=2.0, angle=0.0)
    obj["number"], obj.data["number"], scene["number"] = 0.5, 0.1, 3.0
    if bpy.app.version < (5, 0):
        obj.data.use_nodes = True
    tree = obj.data.node_tree
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = kind, "number"
    tree.links.new(node.outputs["Fac"], tree.nodes["Emission"].inputs["Strength"])
    row, _ = exported()
    np.testing.assert_allclose(row["radiance"], 2.0 * strength, rtol=1e-6)


def test_frame_size_and_flags(scene):
    """An area under rotation and scale, without shadow, unseen by glossy rays."""
    obj = add_light("AREA", shape="RECTANGLE", size=2.0, size_y=1.0, use_shadow=False)
    obj.rotation_euler, obj.scale = (math.pi / 2, 0.0, 0.0), (3.0, 0.5, 7.0)
    obj.visible_glossy = False
    bpy.context.view_layer.update()
    row, _ = exported()
    np.testing.assert_allclose(row["position"], (1.0, 2.0, 3.0))
    np.testing.assert_allclose(row["forward"], (0.0, 1.0, 0.0), atol=1e-6)
    np.testing.assert_allclose(row["up"], (0.0, 0.0, 1.0), atol=1e-6)
    np.testing.assert_allclose(row["size"], (6.0, 0.5))
    assert row["seen_by"] == BY_DIFFUSE and not row["shadow"]
    obj.visible_camera = True
    assert exported()[0]["seen_by"] == BY_DIFFUSE | BY_CAMERA
    obj.data.cycles.use_multiple_importance_sampling = False
    obj.data.update_tag()
    assert exported()[0]["seen_by"] == BY_DIFFUSE | BY_CAMERA | NOT_BY_BSDF
    assert row["radiance"][0] == pytest.approx(10.0 / (math.pi * 3.0))


@pytest.mark.parametrize("shape", ["RECTANGLE", "ELLIPSE"])
@pytest.mark.parametrize("turn", [(0.7, 0.0, 0.0), (0.6, 0.3, 0.2)])
def test_area_under_an_uneven_scale_has_sides_at_right_angles(scene, shape, turn):
    """A rectangle in its own plane, an ellipse across the axis, whose column Cycles takes."""
    obj = add_light("AREA", shape=shape, size=2.0, size_y=1.0)
    obj.parent = bpy.data.objects.new("Parent", None)
    scene.collection.objects.link(obj.parent)
    obj.parent.scale, obj.rotation_euler = (1.0, 1.0, 0.5), turn
    bpy.context.view_layer.update()
    row, warnings = exported()
    assert warnings == []
    frame = np.stack([row["right"], row["up"], row["forward"]])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-6)  # float32 matrices
    sides = np.array(obj.matrix_world)[:3, :3]
    sides /= np.linalg.norm(sides, axis=0)
    np.testing.assert_allclose(row["axis"], -sides[:, 2], atol=1e-6)
    if shape == "ELLIPSE":
        np.testing.assert_array_equal(row["forward"], row["axis"])
    else:
        np.testing.assert_allclose(row["forward"] @ sides[:, :2], 0.0, atol=1e-6)
        assert 0.5 < row["forward"] @ row["axis"] < 0.99


def test_instances_of_a_lamp_are_lamps(scene):
    """A collection of one light, instanced twice; hidden ones are not there."""
    lamps = bpy.data.collections.new("Lamps")
    obj = add_light("POINT")
    scene.collection.objects.unlink(obj)
    lamps.objects.link(obj)
    for x in (10.0, 20.0):
        empty = bpy.data.objects.new("Empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", lamps
        empty.location.x = x
        scene.collection.objects.link(empty)
    add_light("POINT", "Hidden").hide_render = True
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[]).lamps
    places = sorted(map(tuple, lamps.position))
    assert places[-2:] == [(11.0, 2.0, 3.0), (21.0, 2.0, 3.0)]


def test_what_a_lamp_cannot_do_is_told(scene):
    """Light that falls off in two ways, negative: by object and light."""
    obj = add_light("POINT", energy=-5.0)
    row, warnings = exported()
    assert row is None and any('"Lamp", light "Lamp data": negative' in line for line in warnings)
    obj.data.energy = 5.0
    tree, emission = nodes_of(obj)
    falloff, place = (tree.nodes.new(f"ShaderNode{name}") for name in ("LightFalloff", "TexCoord"))
    power = tree.nodes.new("ShaderNodeMath")
    power.operation = "POWER"
    tree.links.new(falloff.outputs["Linear"], power.inputs[0])
    tree.links.new(place.outputs["UV"], power.inputs[1])
    tree.links.new(power.outputs[0], emission.inputs["Strength"])
    row, warnings = exported()
    told = [line for line in warnings if line.startswith('object "Lamp", light "Lamp data"')]
    assert row is not None and len(told) == 1
    assert "changes with the distance otherwise in one place" in told[0]
    tree.links.clear()
    row, warnings = exported()
    assert row is None and any("nothing is linked" in line for line in warnings)


def test_a_sun_with_nodes_shines_with_their_mean(scene):
    """And says so."""
    dress(add_light("SUN", energy=5.0))
    row, warnings = exported()
    assert not row["picture"].any() and 1.0 < row["radiance"].max() < 5e6
    assert any("mean" in line and '"Lamp data"' in line for line in warnings)


@pytest.mark.parametrize("kind", ["no energy", "no size", "portal"])
def test_lamps_without_light_are_left_out(scene, kind):
    """As in Cycles, without a word."""
    obj = add_light("AREA", energy=0.0 if kind == "no energy" else 10.0)
    if kind == "no size":
        obj.scale.x = 0.0
    if kind == "portal":
        obj.data.cycles.is_portal = True
    bpy.context.view_layer.update()
    row, warnings = exported()
    assert row is None and not any("Lamp" in line for line in warnings)


def test_a_scene_without_world_needs_no_warning_with_a_lamp(scene):
    """The world is not all that lights it."""
    scene.world = None
    assert any("no world" in line for line in exported()[1])
    add_light("SUN")
    assert not any("world" in line for line in exported()[1])


def test_a_render_under_a_lamp_alone(cube_scene):
    """From end to end: under a sun of irradiance pi a floor has the radiance of its albedo."""
    cube_scene.world = None
    add_light("SUN", energy=math.pi, angle=0.0)
    layers = iwis.render(cube_scene)
    combined = layers["combined"][..., :3]
    lit = np.median(combined[combined > 0.0])
    assert 0.3 < lit <= 1.0 and np.isfinite(combined).all()

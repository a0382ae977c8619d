"""Meshes that glow become lamps."""

import bpy
import numpy as np
import pytest

from iwis.core.data.lamps import (
    MESH,
    falloff_knots,
)
from iwis.iwis_addon.export import export_scene
from support.above import look_from_above
from support.exported_lamps import exported


@pytest.fixture
def scene(scene):
    """Empty but for a camera."""
    look_from_above(scene)
    return scene


def add_emitter(strength):
    """A glowing square of side 2, three times as large along x; the Emission node."""
    bpy.ops.mesh.primitive_plane_add(size=2.0, location=(1.0, 2.0, 3.0))
    bpy.context.object.scale.x = 3.0
    material = bpy.data.materials.new("Glow")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = 1.0, 0.5, 0.0, 1.0
    emission.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    bpy.context.view_layer.update()
    return emission


def test_a_mesh_that_glows_is_a_lamp(scene):
    """Its radiance is colour x strength, its faces are there in world space, and nothing is warned;
    a world is not missed."""
    scene.world = None
    add_emitter(4.0)
    row, warnings = exported()
    assert row["kind"] == MESH and warnings == []
    np.testing.assert_allclose(row["position"], [1.0, 2.0, 3.0])
    lines = []
    faces = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps.faces
    np.testing.assert_allclose(faces.radiance[:4], [[4.0, 2.0, 0.0]] * 4)
    np.testing.assert_allclose(_light(faces)[0], (48.0, 24.0, 0.0), rtol=1e-6)


def _light(faces):
    """float (2, 3): radiance times area of all fronts, and of all backs."""
    a, b, c = faces.corners.swapaxes(0, 1).astype(float)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.einsum("f,fsc->sc", area, faces.radiance.reshape(-1, 2, 3))


def _faces_over_a_floor(emission, name, output, by="Strength"):
    """What shines where the output of a new node is linked to the Emission node; the warnings."""
    bpy.context.scene.world = bpy.data.worlds.new("Grey")
    bpy.ops.mesh.primitive_plane_add(size=9.0)
    tree = emission.id_data
    node = tree.nodes.new(name)
    tree.links.new(node.outputs[output], emission.inputs[by])
    bpy.context.view_layer.update()
    lines = []
    return export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps.faces, lines


@pytest.mark.parametrize("strength", [0.0, -1.0])
def test_a_mesh_that_does_not_glow_is_no_lamp(scene, strength):
    """Strength 0 and less."""
    add_emitter(strength)
    assert exported()[0] is None


def test_emission_that_varies_shines_where_it_is(scene):
    """A checker of five by five squares: dark ones are no faces, the others have their radiance but
    for parts across an edge. All light is 12 or 13 squares of 25."""
    emission = add_emitter(4.0)
    faces, warnings = _faces_over_a_floor(emission, "ShaderNodeTexChecker", "Fac", "Strength")
    assert warnings == []
    light = _light(faces)
    whole = _light(faces._replace(radiance=np.float32(faces.radiance == 1.0)))
    assert (whole[:, 0] > 0.9 * light[:, 0]).all() and faces.radiance.max() == 1.0
    squares = light[0, 0] / 12.0 * 25.0
    assert min(abs(squares - 12.0), abs(squares - 13.0)) < 0.05
    np.testing.assert_allclose(light, np.outer(light[:, 0], (1.0, 0.5, 0.0)), rtol=1e-5)


@pytest.mark.parametrize(
    ("node", "output", "front", "back"),
    [
        ("ShaderNodeNewGeometry", "Backfacing", 0.0, 12.0),
        ("ShaderNodeLightPath", "Is Camera Ray", 0.0, 0.0),
        ("ShaderNodeLightPath", "Is Shadow Ray", 0.0, 0.0),
    ],
)
def test_emission_by_side_and_ray(scene, node, output, front, back):
    """It shines on the side where it does; what the camera alone sees lights nothing."""
    faces, warnings = _faces_over_a_floor(add_emitter(1.0), node, output)
    assert warnings == []
    np.testing.assert_allclose(_light(faces)[:, 0], (front, back), rtol=1e-5)
    assert len(faces.power) == (4 if back else 0)  # nothing is cut that is the same all over


def test_emission_by_direction_is_warned(scene):
    """Layer Weight: a lamp shines alike in all directions; the warning names the material."""
    _, warnings = _faces_over_a_floor(add_emitter(1.0), "ShaderNodeLayerWeight", "Fresnel")
    assert len(warnings) == 1 and 'material "Glow"' in warnings[0]
    assert "depends on where it is seen from" in warnings[0]


def test_emission_by_distance_is_a_table(scene):
    """Light Falloff: radiance x factor is Strength x the square of the distance, on both sides; a
    material of its own is a lamp of its own."""
    _add_constant_light(add_emitter(4.0), 2.0)
    add_emitter(4.0)
    lines = []
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps
    assert lines == [] and sorted(lamps.falloff.tolist()) == [-1, 0]
    (row,) = np.flatnonzero(lamps.falloff == 0)
    first, end, _ = lamps.span[row]
    light = lamps.faces.radiance[2 * first, 0] * lamps.falloffs[0, :, 0]
    np.testing.assert_allclose(light, 2.0 * falloff_knots().astype(float) ** 2, rtol=1e-5)
    radiance = lamps.faces.radiance[2 * first : 2 * end][lamps.faces.radiance[2 * first :, 0] > 0.0]
    assert (radiance == radiance[0]).all() and len(radiance) == 4


def _add_constant_light(emission, strength):
    tree = emission.id_data
    node = tree.nodes.new("ShaderNodeLightFalloff")
    node.inputs["Strength"].default_value = strength
    tree.links.new(node.outputs["Constant"], emission.inputs["Strength"])
    bpy.ops.mesh.primitive_plane_add(size=9.0)  # what is lit
    bpy.context.view_layer.update()


def test_emission_that_falls_off_in_two_ways_is_warned(scene):
    """The distance to the power of a coordinate."""
    emission = add_emitter(1.0)
    tree = emission.id_data
    power, place = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeTexCoord")
    power.operation = "POWER"
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    tree.links.new(falloff.outputs["Linear"], power.inputs[0])
    tree.links.new(place.outputs["UV"], power.inputs[1])
    tree.links.new(power.outputs[0], emission.inputs["Strength"])
    _, warnings = _faces_over_a_floor(emission, "ShaderNodeRGB", "Color", "Color")
    assert len(warnings) == 1 and 'material "Glow"' in warnings[0]
    assert "changes with the distance otherwise in one place" in warnings[0]

"""Nodes that ask what is near, as they are exported: Ambient Occlusion, Bevel."""

import bpy
import pytest

from iwis.iwis_addon.export import export_scene
from support.material_builds import Build, exported, program_of


@pytest.fixture
def build(scene):
    return Build()


def _occlusion(build, **values):
    return build.node("ShaderNodeAmbientOcclusion", "Near", **values)


def _settings(build, node):
    """Of the one operation of its kind, behind a color."""
    diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Color", node.outputs["Color"])])
    program = program_of(build.surface(diffuse))
    (op,) = (op for op in program.ops if op.kind == node.bl_idname)
    return op.settings


def test_options_are_read(build):
    node = _occlusion(build, samples=5, inside=True, only_local=True, Distance=0.4)
    found = _settings(build, node)
    assert found == {"samples": 5, "inside": True, "only_local": True, "everywhere": False}


@pytest.mark.parametrize(("linked", "value"), [(False, 0.0), (True, 0.0), (True, 0.3)])
def test_distance_of_zero_is_the_worlds(build, linked, value):
    """However it is made, as in Cycles."""
    node = _occlusion(build, Distance=0.5 if linked else value)
    if linked:
        number = build.node("ShaderNodeValue")
        number.outputs[0].default_value = value
        build.link(number.outputs[0], node.inputs["Distance"])
    assert _settings(build, node)["everywhere"] == (value == 0.0)


def test_a_clear_material_says_what_its_shadow_is(build):
    node = _occlusion(build)
    mix = build.node("ShaderNodeMixShader", links=[(0, node.outputs["AO"])])
    build.link(build.node("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    build.link(build.node("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[2])
    _, (warning,) = exported(build.surface(mix))
    assert 'material "M"' in warning and "for its shadow nothing is near" in warning


def test_a_material_that_shines_says_how_it_lights(build):
    """And a scene tells how far nodes look, where the world is to say it."""
    node = _occlusion(build)
    emission = build.node("ShaderNodeEmission", links=[("Color", node.outputs["Color"])])
    build.surface(emission)
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.data.materials.append(build.material)
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.camera_add()
    bpy.context.scene.camera = bpy.context.object
    bpy.context.scene.world = bpy.data.worlds.new("W")
    bpy.context.scene.world.light_settings.distance = 2.5
    warnings = []
    found = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=warnings)
    assert found.shaders.near_distance == 2.5
    told = [line for line in warnings if "depends on what is near" in line]
    assert len(told) == 1 and 'object "Plane", material "M"' in told[0]


def test_bevel_has_its_samples_and_a_normal_if_linked(build):
    """Nothing is warned of; shadows ask for no normal."""
    node = build.node("ShaderNodeBevel", samples=7, Radius=0.2)
    diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Normal", node.outputs[0])])
    build.surface(diffuse)
    (op,) = program_of(build).ops
    assert op.settings["samples"] == 7 and set(op.inputs) == {"Radius"}
    assert exported(build)[1] == []
    coordinates = build.node("ShaderNodeTexCoord")
    build.link(coordinates.outputs["Normal"], node.inputs["Normal"])
    assert {"Radius", "Normal"} <= set(program_of(build).ops[-1].inputs)

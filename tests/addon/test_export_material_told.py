"""Materials of the open file: nothing is dropped without a word, and nothing turns black."""

import bpy
import numpy as np
import pytest

from iwis.core.scene import BLACK, DIFFUSE, PRINCIPLED
from iwis.iwis_addon.export.shaders.material import export_materials, export_shaders
from support.material_builds import Build, only, program_of


@pytest.fixture
def build(scene):
    return Build()


@pytest.mark.parametrize(
    ("users", "where"),
    [([], ""), (["A"], 'object "A", '), (["A", "B", "C"], 'object "A" and 2 more, ')],
)
def test_warnings_name_objects(build, users, where):
    """The first object that has the material, and how many more."""
    build.surface(build.node("ShaderNodeBsdfRayPortal", "Hole"))
    warnings = []
    export_materials([build.material], warnings, [users])
    assert len(warnings) == 1
    assert warnings[0].startswith(f'{where}material "M", node "Hole": ')


OTHERS = {
    "ShaderNodeBsdfRayPortal": DIFFUSE,
    "ShaderNodeEeveeSpecular": DIFFUSE,
    "ShaderNodeVolumeScatter": DIFFUSE,
}


@pytest.mark.parametrize("kind", OTHERS)
def test_unsupported_shader_is_never_black_without_a_word(build, kind):
    """The nearest supported meaning, and one warning with the names of material and node."""
    row, warnings = only(build.surface(build.node(kind, "Strange")))
    assert row["model"] == OTHERS[kind]
    assert max(row["base_color"]) > 0.0
    assert len(warnings) == 1 and warnings[0].startswith('material "M", node "Strange": ')


if bpy.app.version >= (5, 2):

    def test_principled_input_left_out_is_told(build):
        node = build.node("ShaderNodeBsdfPrincipled", "P", Thin_Wall=True)
        row, warnings = only(build.surface(node))
        assert row["model"] == PRINCIPLED
        assert len(warnings) == 1 and "Thin Wall" in warnings[0] and 'node "P"' in warnings[0]


def test_volume_and_what_is_no_displacement_are_told(build):
    """Both are left out."""
    node = build.node("ShaderNodeBsdfDiffuse")
    build.link(build.node("ShaderNodeVolumeScatter").outputs[0], build.output.inputs["Volume"])
    other = build.node("ShaderNodeShaderToRGB")
    build.link(other.outputs[0], build.output.inputs["Displacement"])
    warnings = only(build.surface(node))[1]
    assert len(warnings) == 2 and "Volume" in warnings[0] and "Displacement" in warnings[1]


def test_constant_normal_of_a_displacement(build):
    """Its socket shows no value: Blender 5 leaves a node of the constant before it."""
    normal = build.node("ShaderNodeCombineXYZ", X=0.6, Y=-0.6, Z=0.5)
    height = build.node("ShaderNodeDisplacement", links=[("Normal", normal.outputs[0])])
    build.link(build.node("ShaderNodeTexNoise").outputs[0], height.inputs["Height"])
    build.link(height.outputs[0], build.output.inputs["Displacement"])
    material = build.surface(build.node("ShaderNodeBsdfDiffuse")).material
    material.displacement_method = "DISPLACEMENT"
    warnings = []
    (moved,) = export_shaders([material], warnings).displacements
    assert warnings == []
    np.testing.assert_allclose(moved.program.ops[-1].inputs["Normal"], [0.6, -0.6, 0.5])


@pytest.mark.parametrize("method", ["BUMP", "BOTH"])
def test_displacement_is_bump(build, method):
    """It turns the normal of what has none of its own, and what a Bump node begins with."""
    height = build.node("ShaderNodeDisplacement")
    build.link(build.node("ShaderNodeTexNoise").outputs[0], height.inputs["Height"])
    bump, mix = build.node("ShaderNodeBump"), build.node("ShaderNodeMixShader")
    build.link(build.node("ShaderNodeTexMagic").outputs[1], bump.inputs["Height"])
    plain = build.node("ShaderNodeBsdfDiffuse")
    bumped = build.node("ShaderNodeBsdfGlossy", links=[("Normal", bump.outputs[0])])
    for number, shader in enumerate((plain, bumped), 1):
        build.link(shader.outputs[0], mix.inputs[number])
    material = build.surface(mix).material
    assert all(closure.normal is None for closure in program_of(build).closures[:1])
    build.link(height.outputs[0], build.output.inputs["Displacement"])
    material.displacement_method = method
    assert only(build)[1] == []
    program = program_of(build)
    own, other = (closure.normal for closure in program.closures)
    assert program.ops[own.op].kind == program.ops[other.op].kind == "ShaderNodeBump"
    assert program.ops[other.op].inputs["Normal"] == own


def test_even_displacement_turns_nothing(build):
    build.link(build.node("ShaderNodeDisplacement").outputs[0], build.output.inputs["Displacement"])
    assert only(build.surface(build.node("ShaderNodeBsdfDiffuse")))[1] == []
    assert program_of(build) is None


def test_texture_without_image(build):
    """Pink as in Cycles, and a warning."""
    texture = build.node("ShaderNodeTexImage")
    node = build.node("ShaderNodeBsdfDiffuse", links=[("Color", texture.outputs["Color"])])
    row, warnings = only(build.surface(node))
    assert row["base_color"] == [1.0, 0.0, 1.0] and len(warnings) == 1


def test_other_link_leaves_the_value_beneath(build):
    """A node that is not supported: the socket's own value, and a warning."""
    wave = build.node("ShaderNodeShaderToRGB", "Lamp")
    node = build.node(
        "ShaderNodeBsdfDiffuse", Color=(0.5, 0.25, 0, 1), links=[("Color", wave.outputs[0])]
    )
    row, warnings = only(build.surface(node))
    assert row["base_color"] == [0.5, 0.25, 0.0]
    assert len(warnings) == 1 and 'node "Lamp"' in warnings[0] and '"Color"' in warnings[0]


def test_nothing_linked_is_black_with_a_word(build):
    """Cycles renders both black; the warning says why."""
    row, warnings = only(build)
    assert row["model"] == BLACK and len(warnings) == 1
    build.tree.nodes.clear()
    row, warnings = only(build)
    assert row["model"] == BLACK and len(warnings) == 1

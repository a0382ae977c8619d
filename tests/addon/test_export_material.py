"""Materials of the open file: what each node means."""

import bpy
import numpy as np
import pytest

from iwis.core.data.program import Ref
from iwis.core.nodes.color import blackbody
from iwis.core.scene import BECKMANN, BLACK, DIFFUSE, GGX, GLOSSY, MULTI_GGX, PRINCIPLED
from iwis.iwis_addon.export.images.blackbody import blackbody_settings
from iwis.iwis_addon.export.shaders.material import export_materials, export_shaders
from support.material_builds import Build, about, exported, only, program_of


@pytest.fixture
def build(scene):
    return Build()


def test_default_cube():
    """Blender's start-up file: a Principled BSDF, without a warning."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    rows, warnings = exported(bpy.data.objects["Cube"].active_material)
    assert warnings == []
    assert rows[0]["model"] == PRINCIPLED and rows[0]["distribution"] == MULTI_GGX
    assert rows[0]["base_color"] == about([0.8] * 3)
    assert rows[0]["roughness"] == 0.5 and rows[0]["emission"] == [0.0] * 3
    assert rows[0]["ior"] == about(1.5 if bpy.app.version >= (5, 0) else 1.45)


def test_empty_slot_is_cycles_default(build):
    """No material: from Blender 5 on what a new Principled BSDF is, a diffuse grey before."""
    rows, warnings = exported(None)
    kind = "ShaderNodeBsdfPrincipled" if bpy.app.version >= (5, 0) else "ShaderNodeBsdfDiffuse"
    row, _ = only(build.surface(build.node(kind)))
    assert warnings == [] and rows[0] == row
    assert row["base_color"] == about([0.8] * 3)


def test_no_materials(scene):
    """A scene without any: a table of no rows."""
    assert exported() == ([], [])


def test_pass_index(build):
    build.material.pass_index = 7
    assert export_materials([None, build.material], [])[1].tolist() == [0.0, 7.0]


def test_principled_values(build):
    """Each supported input arrives; emission carries its strength."""
    node = build.node(
        "ShaderNodeBsdfPrincipled",
        distribution="GGX",
        Base_Color=(0.1, 0.2, 0.3, 1),
        Metallic=0.25,
        Roughness=0.75,
        IOR=2.0,
        Specular_IOR_Level=0.8,
        Specular_Tint=(0.5, 0.6, 0.7, 1),
        Emission_Color=(1, 0.5, 0.25, 1),
        Emission_Strength=4.0,
    )
    row, warnings = only(build.surface(node))
    assert warnings == []
    assert row == {
        "model": PRINCIPLED,
        "distribution": GGX,
        "base_color": about([0.1, 0.2, 0.3]),
        "metallic": 0.25,
        "roughness": 0.75,
        "ior": 2.0,
        "specular_level": about(0.8),
        "specular_tint": about([0.5, 0.6, 0.7]),
        "emission": [4.0, 2.0, 1.0],
        "diffuse_roughness": 0.0,
    }


def test_holdout(build):
    """Of a mixture, its share; without a warning."""
    hole = build.node("ShaderNodeHoldout")
    grey = build.node("ShaderNodeBsdfDiffuse")
    links = [(1, grey.outputs[0]), (2, hole.outputs[0])]
    mix = build.node("ShaderNodeMixShader", links=links)
    mix.inputs[0].default_value = 0.25
    warnings = []
    program = export_shaders([build.surface(mix).material], warnings).programs[0]
    assert warnings == [] and program.transparent is None
    assert program.holdout.tolist() == [0.25] * 3
    assert program.closures[0].params["base_color"].tolist() == about([0.6] * 3)


def test_rough_diffuse(build):
    """Its roughness arrives, and it is never added to a smooth one by its colour."""
    rough = build.node("ShaderNodeBsdfDiffuse", Color=(1, 0.5, 0, 1), Roughness=0.5)
    row, warnings = only(build.surface(rough))
    assert (row["model"], row["diffuse_roughness"], warnings) == (DIFFUSE, 0.5, [])
    smooth = build.node("ShaderNodeBsdfDiffuse", Color=(1, 0.5, 0, 1))
    links = [(0, rough.outputs[0]), (1, smooth.outputs[0])]
    material = build.surface(build.node("ShaderNodeAddShader", links=links)).material
    closures = export_shaders([material], []).programs[0].closures
    assert sorted(float(c.params["diffuse_roughness"]) for c in closures) == [0.0, 0.5]


@pytest.mark.parametrize("kind", ["ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic"])
@pytest.mark.parametrize(
    ("name", "distribution"), [("GGX", GGX), ("MULTI_GGX", MULTI_GGX), ("BECKMANN", BECKMANN)]
)
def test_glossy(build, kind, name, distribution):
    """Both names that Blender has for the node, and each distribution that is supported."""
    node = build.node(kind, distribution=name, Color=(0.5, 0.25, 1, 1), Roughness=0.5)
    row, warnings = only(build.surface(node))
    assert warnings == []
    assert (row["model"], row["distribution"]) == (GLOSSY, distribution)
    assert row["base_color"] == [0.5, 0.25, 1.0] and row["roughness"] == 0.5


def test_emission_and_its_sums(build):
    """Emission alone is black with light; Add and Mix with a surface keep both, exactly; warned."""
    light = build.node("ShaderNodeEmission", Color=(1, 0.5, 0, 1), Strength=2.0)
    row, warnings = only(build.surface(light))
    assert (row["model"], row["emission"], warnings) == (BLACK, [2.0, 1.0, 0.0], [])
    grey = build.node("ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5, 1))
    links = [(0, light.outputs[0]), (1, grey.outputs[0])]
    row, warnings = only(build.surface(build.node("ShaderNodeAddShader", links=links)))
    assert (row["model"], row["base_color"], warnings) == (DIFFUSE, [0.5] * 3, [])
    assert row["emission"] == [2.0, 1.0, 0.0]
    mix = build.node("ShaderNodeMixShader", links=[(1 + i, output) for i, output in links])
    mix.inputs[0].default_value = 0.25
    row, warnings = only(build.surface(mix))
    assert (row["base_color"], row["emission"]) == ([0.125] * 3, [1.5, 0.75, 0.0])
    assert warnings == []


def test_mix_of_surfaces(build):
    """Two diffuse are one; a share of 0 or 1 takes one side; else there are two closures."""
    red = build.node("ShaderNodeBsdfDiffuse", Color=(1, 0, 0, 1))
    blue = build.node("ShaderNodeBsdfDiffuse", Color=(0, 0, 1, 1))
    gloss = build.node("ShaderNodeBsdfGlossy", Color=(0, 1, 0, 1))
    mix = build.node(
        "ShaderNodeMixShader", "Mix", links=[(1, red.outputs[0]), (2, blue.outputs[0])]
    )
    mix.inputs[0].default_value = 0.25
    assert only(build.surface(mix))[0]["base_color"] == [0.75, 0.0, 0.25]
    build.link(gloss.outputs[0], mix.inputs[2])
    row, warnings = only(build)
    assert row["model"] == DIFFUSE and row["base_color"] == [1.0, 0.0, 0.0]  # for mode PAPER
    assert warnings == []
    first, second = program_of(build).closures
    assert (first.model, second.model) == (DIFFUSE, GLOSSY)
    np.testing.assert_allclose([first.weight, second.weight], [[0.75] * 3, [0.25] * 3])
    mix.inputs[0].default_value = 1.0
    row, warnings = only(build)
    assert row["model"] == GLOSSY and warnings == []


def test_metallic_node_is_a_principled_metal(build):
    """The Metallic BSDF with its F82 curve; indices give the same reflectance along the normal."""
    node = build.node(
        "ShaderNodeBsdfMetallic", Base_Color=(0.9, 0.6, 0.3, 1), Edge_Tint=(0.5, 1, 1, 1)
    )
    row, warnings = only(build.surface(node))
    assert warnings == [] and row["model"] == PRINCIPLED and row["metallic"] == 1.0
    assert row["base_color"] == about([0.9, 0.6, 0.3]) and row["specular_tint"] == [0.5, 1.0, 1.0]


def test_normal_becomes_part_of_a_program(build):
    """A normal that is turned makes a program, without a warning."""
    bump = build.node("ShaderNodeBump")
    bump_height = next(s for s in bump.inputs if s.name == "Height")
    build.link(build.node("ShaderNodeTexNoise").outputs[0], bump_height)
    node = build.node("ShaderNodeBsdfDiffuse", links=[("Normal", bump.outputs[0])])
    warnings = []
    found = export_shaders([build.surface(node).material], warnings)
    assert warnings == [] and found.programs[0].closures[0].normal is not None


def test_blackbody_of_no_number():
    """As of a temperature of 0: a broken texel must not end a render."""
    broken = np.float32([np.nan, np.inf, -np.inf, 0.0])
    colors = blackbody(None, blackbody_settings(), {"Temperature": broken})["Color"]
    assert np.isfinite(colors).all()
    np.testing.assert_array_equal(colors[0], colors[3])


@pytest.mark.parametrize("kelvin", (0.0, 800.0, 1500.0, 6500.0, 12000.0, 1e6))
def test_blackbody(build, kelvin):
    """As bright at each temperature; red below that of the sun, blue above; no warning."""
    node = build.node("ShaderNodeBlackbody", Temperature=kelvin)
    row, warnings = only(
        build.surface(build.node("ShaderNodeBsdfDiffuse", links=[("Color", node.outputs[0])]))
    )
    red, green, blue = row["base_color"]
    assert warnings == [] and min(red, green, blue) >= 0.0
    assert (red > green > blue or kelvin <= 800.0) if kelvin < 6000.0 else blue > 0.98 * red
    assert 0.2126 * red + 0.7152 * green + 0.0722 * blue == pytest.approx(1.0, abs=0.16)


def test_bump_map_correction(build):
    """Off, even a plain surface is a program: its glossy light follows the smooth normal."""
    material = build.surface(build.node("ShaderNodeBsdfPrincipled")).material
    assert export_shaders([material], []).programs == (None,)
    material.cycles.use_bump_map_correction = False
    assert not export_shaders([material], []).programs[0].corrects_bumps


def test_transparent_shadows(build):
    """Off, what lets light through throws its whole shadow; of what does not it means nothing."""
    pane = build.surface(build.node("ShaderNodeBsdfTransparent")).material
    assert not export_shaders([pane], []).programs[0].throws_whole_shadow
    pane.use_transparent_shadow = False
    assert export_shaders([pane], []).programs[0].throws_whole_shadow
    plain = build.surface(build.node("ShaderNodeBsdfDiffuse")).material
    plain.use_transparent_shadow = False
    assert export_shaders([plain], []).programs == (None,)


def test_constants_are_found_through_links(build):
    """RGB and Value nodes, through a reroute and a muted node: exact, so no warning."""
    rgb = build.node("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    muted = build.node("ShaderNodeGamma", links=[("Color", rgb.outputs[0])])
    muted.mute = True
    reroute = build.node("NodeReroute", links=[(0, muted.outputs[0])])
    value = build.node("ShaderNodeValue")
    value.outputs[0].default_value = 0.3
    node = build.node(
        "ShaderNodeBsdfPrincipled",
        links=[("Base Color", reroute.outputs[0]), ("Roughness", value.outputs[0])],
    )
    build.link(rgb.outputs[0], node.inputs["Metallic"])
    row, warnings = only(build.surface(node))
    assert warnings == []
    assert row["base_color"] == about([0.1, 0.2, 0.3]) and row["roughness"] == about(0.3)
    assert row["metallic"] == about(0.2126 * 0.1 + 0.7152 * 0.2 + 0.0722 * 0.3)  # luminance


def test_node_group(build):
    """A shader in a group, its color an input of the group: the value at the group's node."""
    group = bpy.data.node_groups.new("Paint", "ShaderNodeTree")
    group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inside = build.node("NodeGroupInput", tree=group)
    diffuse = build.node("ShaderNodeBsdfDiffuse", tree=group, links=[("Color", inside.outputs[0])])
    build.node("NodeGroupOutput", tree=group, links=[(0, diffuse.outputs[0])])
    node = build.node("ShaderNodeGroup", node_tree=group)
    node.inputs["Tint"].default_value = (0.25, 0.5, 0.75, 1)
    row, warnings = only(build.surface(node))
    assert (row["model"], row["base_color"], warnings) == (DIFFUSE, [0.25, 0.5, 0.75], [])


@pytest.mark.parametrize("floating", [False, True])
def test_texture_is_a_program_and_its_row_the_mean(build, floating):
    """An image is looked up at each point; the row, for mode PAPER, has its mean."""
    image = bpy.data.images.new("Tiles", 2, 2, float_buffer=floating)
    image.pixels[:] = [0.5, 0.0, 1.0, 1.0] * 2 + [1.0, 0.0, 1.0, 1.0] * 2
    texture = build.node("ShaderNodeTexImage", "Tex", image=image)
    node = build.node("ShaderNodeBsdfDiffuse", links=[("Color", texture.outputs["Color"])])
    row, warnings = only(build.surface(node))
    assert warnings == []
    assert export_shaders([build.material], []).programs[0] is not None
    # Floats: halfway between .5 and 1. Bytes are interpolated before they are decoded: Simpson's
    # rule over what lies between 128 / 255 and 1 gives .5505.
    red = 0.75 if floating else 0.5505
    assert row["base_color"] == pytest.approx([red, 0.0, 1.0], abs=2e-3)  # 144 points


def test_material_without_nodes(scene):
    """Its viewport color, diffuse; from Blender 5 on a material always has nodes."""
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = (0.5, 0.25, 0.125, 1)
    rows, warnings = exported(material)
    assert warnings == []
    if bpy.app.version < (5, 0):
        assert (rows[0]["model"], rows[0]["base_color"]) == (DIFFUSE, [0.5, 0.25, 0.125])
    else:
        assert rows[0]["model"] == PRINCIPLED


def test_coat_lies_over_the_rest(build):
    """Its own closure, first; what is under it gets the weight that the coat leaves."""
    node = build.node("ShaderNodeBsdfPrincipled", Coat_Weight=0.5, Coat_Roughness=0.2, Coat_IOR=1.6)
    assert only(build.surface(node))[1] == []
    coat, base = program_of(build).closures
    np.testing.assert_allclose(coat.weight, [0.5] * 3)
    np.testing.assert_allclose([coat.params["roughness"], coat.params["ior"]], [0.2, 1.6])
    assert not coat.params["base_color"].any() and isinstance(base.weight, Ref)
    assert coat.distribution == MULTI_GGX  # whatever the node's own, as in Cycles

"""Bake Unsupported: Cycles' values in place of what IWIS does not know, or a line that says why."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.bake_unsupported import bake_unsupported
from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.shaders.program_nodes import HANDLERS


def _material(name, kind="ShaderNodeWavelength", output=0, target="Base Color"):
    """A Principled BSDF that a node feeds; wavelengths are those of waves."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = material.node_tree
    node = tree.nodes.new(kind)
    if kind == "ShaderNodeWavelength":
        waves, range_ = tree.nodes.new("ShaderNodeTexWave"), tree.nodes.new("ShaderNodeMapRange")
        range_.inputs["To Min"].default_value, range_.inputs["To Max"].default_value = 440.0, 620.0
        waves.inputs["Scale"].default_value = 0.5
        tree.links.new(waves.outputs["Fac"], range_.inputs["Value"])
        tree.links.new(range_.outputs[0], node.inputs[0])
    tree.links.new(node.outputs[output], tree.nodes["Principled BSDF"].inputs[target])
    return material


@pytest.fixture
def plane(scene, monkeypatch):
    """A plane; wavelengths are a node that is warned of."""
    monkeypatch.delitem(HANDLERS, "ShaderNodeWavelength")
    bpy.ops.mesh.primitive_plane_add(size=2.0)
    bpy.ops.object.camera_add(location=(0.0, 0.0, 5.0))
    scene.camera = bpy.context.object
    return bpy.data.objects["Plane"]


def _warnings():
    lines = []
    export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    return [line for line in lines if "material" in line]


def _source(material, target="Base Color"):
    return material.node_tree.nodes["Principled BSDF"].inputs[target].links[0].from_node


def _pixels(image):
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[..., :3]


def test_a_pattern_becomes_an_image(scene, plane):
    """Colours of wavelengths, 0 to 1; the export has no warning any more; engine, selection and the
    surface are as before, and the image is kept with the file."""
    material = _material("M")
    plane.data.materials.append(material)
    bpy.context.view_layer.update()
    assert len(_warnings()) == 1
    engine, selected = scene.render.engine, list(bpy.context.selected_objects)
    assert bpy.ops.iwis.bake_unsupported(size=64, samples=4) == {"FINISHED"}
    assert _warnings() == []
    texture = _source(material)
    assert texture.bl_idname == "ShaderNodeTexImage" and texture.image.packed_file is not None
    seen = _pixels(texture.image)
    assert seen.min() >= 0.0 and seen.max() <= 1.0 and np.ptp(seen) > 0.5
    # Waves that a pixel's own noise does not have: its neighbours are like it.
    assert np.abs(np.diff(seen[..., 0])).mean() < 0.3 * seen[..., 0].std()
    assert scene.render.engine == engine and list(bpy.context.selected_objects) == selected
    surface = material.node_tree.get_output_node("CYCLES").inputs["Surface"].links[0]
    assert surface.from_node.bl_idname == "ShaderNodeBsdfPrincipled"
    assert bake_unsupported(bpy.context) == ([], [])


def test_a_vector_keeps_its_sign(plane, monkeypatch):
    """Places in the plane's space, -1 to 1 along x and y, of a node that is warned of."""
    material = _material("M", "ShaderNodeTexCoord", "Object", target="Normal")
    monkeypatch.delitem(HANDLERS, "ShaderNodeTexCoord")
    plane.data.materials.append(material)
    done, problems = bake_unsupported(bpy.context, 16, 1)
    assert len(done) == 1 and problems == []
    decoded = _source(material, "Normal")
    image = decoded.inputs[0].links[0].from_node.image
    middles = (np.arange(16) + 0.5) / 8.0 - 1.0
    vectors = _pixels(image) * 2.0 - 1.0
    # One sample of a texel is within half of it, 1/16, of its middle.
    np.testing.assert_allclose(vectors[..., 0], np.tile(middles, (16, 1)), atol=0.07)
    np.testing.assert_allclose(vectors[..., 1].T, np.tile(middles, (16, 1)), atol=0.07)


def test_a_material_of_two_objects_is_baked_for_each(plane):
    """Each has a material of its own afterwards, and other slots keep theirs."""
    material, plain = _material("M"), bpy.data.materials.new("Plain")
    bpy.ops.mesh.primitive_cube_add(location=(3.0, 0.0, 0.0))
    cube = bpy.context.object
    for obj in (plane, cube):
        obj.data.materials.append(material)
        obj.data.materials.append(plain)
    done, problems = bake_unsupported(bpy.context, 16, 1)
    assert len(done) == 2 and problems == []
    own = {obj.material_slots[0].material for obj in (plane, cube)}
    assert len(own) == 2 and {_source(m).bl_idname for m in own} == {"ShaderNodeTexImage"}
    assert {obj.material_slots[1].material for obj in (plane, cube)} == {plain}
    assert not [image for image in bpy.data.images if "Scratch" in image.name]


def _without_uv(plane, material):
    plane.data.uv_layers.remove(plane.data.uv_layers[0])


def _hidden(plane, material):
    plane.hide_set(True)


def _with_empty_slot(plane, material):
    plane.data.materials.append(None)


def _in_group(plane, material):
    group = bpy.data.node_groups.new("Deep", "ShaderNodeTree")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
    wave, out = group.nodes.new("ShaderNodeWavelength"), group.nodes.new("NodeGroupOutput")
    group.links.new(wave.outputs[0], out.inputs[0])
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_without_uv, "no UV map"),
        (_hidden, "hidden"),
        (_with_empty_slot, "slot is empty"),
        (_in_group, 'group "Deep"'),
    ],
)
def test_what_cannot_be_baked_says_why(plane, spoil, words):
    """Object, material and what to do; nothing is changed."""
    material = _material("M")
    plane.data.materials.append(material)
    spoil(plane, material)
    before = _source(material).bl_idname
    done, problems = bake_unsupported(bpy.context, 16, 1)
    assert done == [] and len(problems) == 1 and words in problems[0]
    assert 'object "Plane"' in problems[0] and 'material "M' in problems[0]
    assert _source(material).bl_idname == before

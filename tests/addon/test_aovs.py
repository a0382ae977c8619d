"""AOVs, values that nodes of materials and worlds write into passes, beside Cycles'."""

import bpy
import numpy as np
import pytest

from iwis.core.exr import read_exr_layers
from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.shaders.program_nodes import HANDLERS
from iwis.iwis_addon.job import RenderJob
from iwis.operators.save_film import film_layers
from support.compositor import sockets_by_engine
from support.cycles_render import use_cycles
from support.iwis_render import by_pass, render_iwis
from support.material_builds import Build


def add_aov(name, kind="COLOR"):
    """A pass of the view layer."""
    aov = bpy.context.view_layer.aovs.add()
    aov.name, aov.type = name, kind
    return aov


def writes(build, name, tree=None, color=None, value=None):
    """An AOV Output node; color, value: outputs that feed it."""
    node = build.node("ShaderNodeOutputAOV", tree=tree, aov_name=name)
    for socket, output in (("Color", color), ("Value", value)):
        if output is not None:
            build.link(output, node.inputs[socket], tree)
    return node


@pytest.fixture
def told_scene(cube_scene):
    """A cube whose noise and places are written, one of them by a node in a group, on a floor that
    writes a constant; a hole."""
    scene = cube_scene
    cube, floor = bpy.data.objects["Cube"], bpy.data.objects["Plane"]
    told = Build("Told")
    told.surface(told.node("ShaderNodeBsdfDiffuse"))
    places = told.node("ShaderNodeTexCoord")
    noise = told.node("ShaderNodeTexNoise", Scale=2.0)
    writes(told, "tone", color=noise.outputs["Color"], value=noise.outputs["Color"])
    group = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector")
    entry = told.node("NodeGroupInput", tree=group)
    writes(told, "place", tree=group, color=entry.outputs[0])
    outer = told.node("ShaderNodeGroup", node_tree=group)
    told.link(places.outputs["Generated"], outer.inputs[0])
    plain = Build("Plain")
    plain.surface(plain.node("ShaderNodeBsdfDiffuse"))
    node = writes(plain, "tone")
    node.inputs["Color"].default_value, node.inputs["Value"].default_value = (2, -1, 0.5, 1), 3.5
    node = writes(plain, "not asked for")
    for obj, build in ((cube, told), (floor, plain)):
        obj.data.materials.clear()
        obj.data.materials.append(build.material)
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.9, -1.2, 0.25))
    bpy.context.object.is_holdout = True
    bpy.context.object.data.materials.append(plain.material)
    add_aov("tone")
    add_aov("place")
    add_aov("height", "VALUE")
    height = told.node("ShaderNodeSeparateXYZ", links=[("Vector", places.outputs["Object"])])
    writes(told, "height", value=height.outputs["Z"])
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 256
    return scene


@pytest.mark.slow
def test_values_are_those_of_cycles(told_scene, tmp_path):
    """Within the noise of 32 and 256 rays a pixel at edges, a quarter of this picture: .04 of a
    value's range in a pixel."""
    ours = by_pass(render_iwis(told_scene, tmp_path))
    use_cycles(told_scene, samples=256, filter_width=1.5)
    told_scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(tmp_path / "cycles.exr"))
    for name, channels in (("tone", 4), ("place", 4), ("height", 1)):
        a, b = ours[name], theirs[name]
        assert a.shape == b.shape == (48, 64, channels)
        span = np.ptp(b)
        assert abs(a.mean() - b.mean()) < 2e-3 * span
        assert np.sqrt(((a - b) ** 2).mean()) < 0.02 * span
        assert span > 0.4


def test_sockets_are_those_of_cycles(cube_scene):
    """One for each AOV whose name is its own."""
    add_aov("tone")
    add_aov("height", "VALUE")
    add_aov("Combined")
    found = sockets_by_engine(cube_scene)
    assert found["IWIS"]["tone"] == found["CYCLES"]["tone"] == "RGBA"
    assert found["IWIS"]["height"] == found["CYCLES"]["height"] == "VALUE"
    assert "Combined" not in found["IWIS"]


def test_a_kept_film_has_them(told_scene, tmp_path):
    """Save Film writes them under Blender's names."""
    told_scene.iwis.keep_film, told_scene.iwis.max_samples = True, 8
    render_iwis(told_scene, tmp_path)
    layers, letters = film_layers(RenderJob.current.films)
    assert letters["ViewLayer.tone"] == "RGBA" and letters["ViewLayer.height"] == "X"
    assert layers["ViewLayer.tone"][..., 0].max() == pytest.approx(2.0, abs=0.01)


def test_asking_changes_no_pixel(told_scene, tmp_path):
    """Of Combined, to the last bit; not asked for, nothing is exported."""
    told_scene.iwis.max_samples = 8
    asked = render_iwis(told_scene, tmp_path)["ViewLayer.Combined"]
    for _ in range(3):
        bpy.ops.scene.view_layer_remove_aov()
    plain = render_iwis(told_scene, tmp_path)
    assert not {"ViewLayer.tone", "ViewLayer.height"} & set(plain)
    np.testing.assert_array_equal(asked, plain["ViewLayer.Combined"])
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
    assert scene.shaders is None


def test_what_is_not_known_is_told(cube_scene, monkeypatch):
    """A node without a meaning here: its input's own value, and a line."""
    monkeypatch.delitem(HANDLERS, "ShaderNodeWavelength")
    build = Build("Odd")
    build.surface(build.node("ShaderNodeBsdfDiffuse"))
    odd = build.node("ShaderNodeWavelength")
    writes(build, "tone", value=odd.outputs[0])
    bpy.data.objects["Cube"].data.materials.append(build.material)
    add_aov("tone", "VALUE")
    world = cube_scene.world.node_tree
    tone = world.nodes.new("ShaderNodeOutputAOV")
    tone.aov_name = "tone"
    world.links.new(world.nodes.new("ShaderNodeBevel").outputs[0], tone.inputs["Value"])
    lines = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    (aov,) = scene.shaders.aovs
    assert aov.channels == 1 and any(program is not None for program in aov.programs)
    assert any("Odd" in line and "Wavelength" in line for line in lines)
    told = f'world "{cube_scene.world.name}", node "Bevel"'
    assert any(line.startswith(told) for line in lines), lines


@pytest.fixture
def sky_scene(cube_scene):
    """A world that writes directions, in a group, and a number, seen beside a cube and through a
    blue pane that Cycles does not count as opaque (Alpha Threshold)."""
    scene = cube_scene
    bpy.data.objects.remove(bpy.data.objects["Plane"])
    sky, group = scene.world.node_tree, bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    pane = Build("Pane")
    places = pane.node("ShaderNodeTexCoord", tree=group)
    writes(pane, "place", tree=group, color=places.outputs["Generated"])
    pane.node("ShaderNodeGroup", tree=sky, node_tree=group)
    places = pane.node("ShaderNodeTexCoord", tree=sky)
    parts = pane.node(
        "ShaderNodeSeparateXYZ", tree=sky, links=[("Vector", places.outputs["Generated"])]
    )
    writes(pane, "height", tree=sky, value=parts.outputs["X"])
    clear = pane.node("ShaderNodeBsdfTransparent")
    clear.inputs["Color"].default_value = 0.5, 0.6, 0.9, 1.0
    pane.surface(clear)
    bpy.ops.mesh.primitive_plane_add(size=1.5, location=(0.7, -0.5, 1.5))
    bpy.context.object.data.materials.append(pane.material)
    add_aov("place")
    add_aov("height", "VALUE")
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 256
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("pixel_filter", ["BLACKMAN_HARRIS", "CENTER"])
@pytest.mark.parametrize("hidden", ["", "film", "camera"])
def test_a_world_writes_where_cycles_sees_it(sky_scene, tmp_path, pixel_filter, hidden):
    """Beside objects and behind panes, which do not tint it; not where it is hidden. Rays differ
    at edges alone: a hundredth of the values' range."""
    scene = sky_scene
    scene.iwis.pixel_filter = pixel_filter
    scene.render.film_transparent = hidden == "film"
    scene.world.cycles_visibility.camera = hidden != "camera"
    ours = by_pass(render_iwis(scene, tmp_path))
    use_cycles(scene, samples=64, filter_width=1.5 if pixel_filter == "BLACKMAN_HARRIS" else 0.01)
    scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(tmp_path / "cycles.exr"))
    for name, channels in (("place", 4), ("height", 1)):
        a, b = ours[name], theirs[name]
        assert a.shape == b.shape == (32, 48, channels)
        assert abs(a.mean() - b.mean()) < 2e-3
        assert np.sqrt(((a - b) ** 2).mean()) < 0.02
        assert b.any() == (hidden == "")

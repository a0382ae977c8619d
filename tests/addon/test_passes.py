"""The passes have Cycles' names, in the compositor and in files, on either side of Blender 5.0."""

import bpy
import numpy as np
import pytest

import iwis
from iwis.core.film import LAYERS
from iwis.iwis_addon.passes import DENOISING_DATA, OWN_FLAGS, TABLE
from support.compositor import empty_tree
from support.cycles_render import render_cycles
from support.iwis_render import render_iwis

IS_5 = bpy.app.version >= (5, 0, 0)
# Name -> (name in 4.5, channels), as Blender's documentation and Cycles' files have them.
EXPECTED = {
    "Combined": ("Combined", 4),
    "Depth": ("Depth", 1),
    "Mist": ("Mist", 1),
    "Position": ("Position", 3),
    "Normal": ("Normal", 3),
    "Vector": ("Vector", 4),
    "UV": ("UV", 3),
    "Object Index": ("IndexOB", 1),
    "Material Index": ("IndexMA", 1),
    "Diffuse Direct": ("DiffDir", 3),
    "Diffuse Color": ("DiffCol", 3),
    "Glossy Direct": ("GlossDir", 3),
    "Glossy Color": ("GlossCol", 3),
    "Emission": ("Emit", 3),
    "Environment": ("Env", 3),
    "Ambient Occlusion": ("AO", 3),
    "IWIS Samples": ("IWIS Samples", 1),
    "IWIS Error": ("IWIS Error", 1),
    "IWIS Unoccluded": ("IWIS Unoccluded", 3),
    "IWIS Visibility": ("IWIS Visibility", 1),
    "Shadow Catcher": ("Shadow Catcher", 3),
    "Debug Sample Count": ("Debug Sample Count", 1),
}


def expected_channels():
    return {(new if IS_5 else old): count for new, (old, count) in EXPECTED.items()}


def ask_for_all(view_layer):
    for row in TABLE:
        if row.flag:
            setattr(view_layer.iwis if row.owned else view_layer, row.flag, True)


def sockets(scene):
    """Names of the enabled outputs of a new Render Layers node."""
    node = empty_tree(scene).nodes.new("CompositorNodeRLayers")
    node.scene = scene
    scene.view_layers[0].update_render_passes()
    return {output.name for output in node.outputs if output.enabled}


def test_table_covers_the_film():
    """Every layer of the film is a pass, once; every flag of the add-on is used."""
    assert sorted(row.layer for row in TABLE) == sorted(LAYERS)
    assert len({row.name for row in TABLE}) == len(TABLE)
    assert {row.flag for row in (*TABLE, *DENOISING_DATA) if row.owned} == set(OWN_FLAGS)


def test_names_and_channels():
    """The table says what this Blender calls its passes."""
    assert {row.name: len(row.channel_ids) for row in TABLE} == expected_channels()


def test_compositor_shows_what_is_asked_for(scene):
    """By default Combined, its Alpha, and the samples; with every flag on, all of the table."""
    names = sockets(scene)
    assert {"Image", "Alpha", "IWIS Samples"} <= names
    assert "IWIS Error" not in names
    ask_for_all(scene.view_layers[0])
    scene.view_layers[0].update_render_passes()
    assert set(expected_channels()) - {"Combined"} <= sockets(scene)


def test_toggling_an_own_pass_updates_the_compositor(scene):
    """The add-on's flags tell Blender by themselves, as its own do."""
    sockets(scene)
    tree = scene.compositing_node_group if IS_5 else scene.node_tree
    scene.view_layers[0].iwis.use_pass_visibility = True
    names = {output.name for output in tree.nodes[0].outputs if output.enabled}
    assert "IWIS Visibility" in names


def test_file_has_the_default_passes(cube_scene, tmp_path):
    """Combined and IWIS Samples need no setting."""
    layers = render_iwis(cube_scene, tmp_path)
    assert {"ViewLayer.Combined", "ViewLayer.IWIS Samples"} == set(layers)


@pytest.mark.slow
def test_file_has_every_pass_with_its_channels(cube_scene, tmp_path):
    """A multilayer EXR has all passes, and their values are what they say."""
    ask_for_all(cube_scene.view_layers[0])
    bpy.data.objects["Cube"].pass_index = 7
    cube_scene.iwis.pixel_filter = "CENTER"  # pixels show the world or an object, not both
    layers = render_iwis(cube_scene, tmp_path)
    assert {name: pixels.shape[2] for name, pixels in layers.items()} == {
        f"ViewLayer.{name}": count for name, count in expected_channels().items()
    }
    index = layers["ViewLayer.Object Index" if IS_5 else "ViewLayer.IndexOB"]
    assert set(index.ravel()) == {0.0, 7.0}
    samples = layers["ViewLayer.IWIS Samples"]
    assert samples.max() <= cube_scene.iwis.max_samples
    ratio = layers["ViewLayer.Debug Sample Count"]
    assert (ratio * cube_scene.iwis.max_samples == samples).all()
    hit = layers["ViewLayer.Depth"][..., 0] < 1e9
    assert hit.any() and not hit.all()
    assert (samples[~hit] == 0).all() and (samples[hit] > 0).all()
    seen = layers["ViewLayer.Environment" if IS_5 else "ViewLayer.Env"]
    assert (seen[~hit] == 1.0).all() and (seen[hit] == 0.0).all()


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_ambient_occlusion_has_the_normals_of_what_is_diffuse(scene, metallic, pixel_filter):
    """As in Cycles: where there is gloss alone, its normal map says nothing, and all is open.

    A floor of which rays that go below it see another one, a metre lower.
    """
    material = bpy.data.materials.new("Tilted")
    if not IS_5:
        material.use_nodes = True
    tree = material.node_tree
    principled = tree.nodes["Principled BSDF"]
    principled.inputs["Metallic"].default_value = metallic
    tilt = tree.nodes.new("ShaderNodeNormalMap")
    tilt.inputs["Color"].default_value = (0.9, 0.5, 0.7, 1.0)
    tree.links.new(tilt.outputs["Normal"], principled.inputs["Normal"])
    bpy.ops.mesh.primitive_plane_add(size=20.0)
    bpy.context.object.data.materials.append(material)
    bpy.ops.mesh.primitive_plane_add(size=60.0, location=(0.0, 0.0, -1.0))
    bpy.ops.object.camera_add(location=(0.0, 0.0, 3.0))
    scene.camera = bpy.context.object
    scene.iwis.pixel_filter = pixel_filter
    scene.view_layers[0].use_pass_ambient_occlusion = True
    seen = iwis.render(scene)["ambient_occlusion"]
    assert (seen == 1.0).all() if metallic else 0.5 < seen.mean() < 0.95


def test_the_pass_uv_tells_what_has_a_map(cube_scene):
    """1 on the cube, 0 on a floor without one, as in Cycles, whether or not others have one."""
    cube_scene.view_layers[0].use_pass_uv = True
    cube_scene.iwis.pixel_filter = "CENTER"
    bpy.ops.mesh.primitive_plane_add(size=40.0, calc_uvs=False, location=(0.0, 0.0, -1.5))
    bpy.context.object.pass_index = 7
    layers = iwis.render(cube_scene)
    shown = layers["uv"][..., 2]
    bare = layers["object_index"][..., 0] == 7.0
    assert bare.any() and not shown[bare].any()
    assert shown[shown.shape[0] // 2, shown.shape[1] // 2] == 1.0


@pytest.mark.parametrize("asked", [False, True])
def test_with_the_pass_shadow_catcher_the_picture_has_none(cube_scene, asked):
    """As in Cycles: who composites by the pass would have the shadow twice."""
    cube_scene.objects["Cube"].is_shadow_catcher = True
    cube_scene.view_layers[0].iwis.use_pass_shadow_catcher = asked
    alpha = iwis.render(cube_scene)["combined"][..., 3]
    middle = alpha[alpha.shape[0] // 2, alpha.shape[1] // 2]
    assert middle == (0.0 if asked else 1.0) and alpha[0, 0] == 1.0


@pytest.mark.slow
def test_ambient_occlusion_is_that_of_cycles(cube_scene, tmp_path):
    """A cube on a floor, rays of 1.5 m: 3 by 3 pixels agree to .1, all of them to .01.

    64 rays a pixel in either: standard errors of .06 a pixel at the most, .02 of nine.
    """
    bpy.ops.mesh.primitive_plane_add(size=20.0, location=(0.0, 0.0, -1.0))
    world = cube_scene.world
    world.light_settings.distance = 1.5
    cube_scene.iwis.pixel_filter = "CENTER"
    cube_scene.view_layers[0].use_pass_ambient_occlusion = True
    name = "Ambient Occlusion" if IS_5 else "AO"
    ours = render_iwis(cube_scene, tmp_path)[f"ViewLayer.{name}"][..., 0]
    theirs = render_cycles(cube_scene, tmp_path, ("ambient_occlusion",), samples=64)[name][..., 0]
    h, w = (size // 3 * 3 for size in ours.shape)
    blocks = [p[:h, :w].reshape(h // 3, 3, w // 3, 3).mean(axis=(1, 3)) for p in (ours, theirs)]
    assert ours.min() < 0.6 and ours.max() == 1.0
    np.testing.assert_allclose(*blocks, atol=0.1)
    assert abs(blocks[0].mean() - blocks[1].mean()) < 0.01

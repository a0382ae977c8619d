"""What the shading menu of a 3D view has it show: lamps, a world's stand-in, a pass."""

import itertools
import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from iwis.core.denoising.denoise import DATA_LAYERS
from iwis.core.film import LAYERS
from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.images.texture_size import TextureSize
from iwis.iwis_addon.export.same import same
from iwis.iwis_addon.export.view_shading import AS_RENDERED, StudioLight, ViewShading
from iwis.iwis_addon.export.worlds import studio_light
from iwis.iwis_addon.export.worlds.studio_light import read_studio_light
from iwis.iwis_addon.export.worlds.world import read_world
from iwis.iwis_addon.view_overlay import colored_layer
from iwis.iwis_addon.view_picture import shown_pixels
from iwis.iwis_addon.view_shading import PASSES, view_shading
from support.view_space import view_space

VIEW_PASSES = [each for rows in PASSES.values() for each in rows]


@pytest.fixture
def shading(cube_scene):
    return view_space().shading


@pytest.fixture
def hdri(cube_scene, tmp_path):
    """The path of a map with another color everywhere."""
    pixels = np.random.default_rng(1).random((4, 8, 4)).astype(np.float32)
    pixels[..., 3] = 1.0
    image = bpy.data.images.new("Studio", 8, 4, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = str(tmp_path / "studio.hdr"), "HDR"
    image.save()
    bpy.data.images.remove(image)
    return str(tmp_path / "studio.hdr")


def export(view=AS_RENDERED, live=True):
    """(scene, warnings) as a window exports it, or as a render."""
    graph, lines = bpy.context.evaluated_depsgraph_get(), []
    own = {"live": LiveExport(), "view": view} if live else {}
    return export_scene(graph, warnings=lines, cache=ExportCache(), **own), lines


def test_the_menu_as_blender_has_it_changes_nothing(shading):
    """A new view shows what a render does."""
    assert view_shading(shading) == AS_RENDERED


def test_what_is_chosen_is_read(shading):
    """Blender's part and IWIS' own; the studio light is one of those for worlds, with its file."""
    shading.use_scene_lights_render = shading.use_scene_world_render = False
    shading.studio_light, shading.studiolight_rotate_z = "sunset.exr", 0.5
    shading.studiolight_intensity, shading.studiolight_background_alpha = 2.0, 0.25
    shading.iwis.render_pass = "NORMAL"
    found = view_shading(shading)
    assert found.studio.path.endswith("sunset.exr")
    assert found == ViewShading(False, StudioLight(found.studio.path, 0.5, 2.0, 0.25), "normal")


def test_passes_have_cycles_keys_and_words(shading):
    """And layers that are there; in false color are those that the window always has."""
    rna = shading.cycles.bl_rna.properties["render_pass"].enum_items
    cycles = {item.identifier: (item.name, item.description) for item in rna}
    own = shading.iwis.bl_rna.properties["render_pass"].enum_items
    for item in own:
        if not item.name.startswith(("IWIS", "Cryptomatte")):
            name, text = cycles[item.identifier]
            assert (name, text.lower()) == (item.name, item.description.lower())
    assert {item.identifier for item in own} == {row.key for row in VIEW_PASSES}
    mattes = {f"crypto_{kind}" for kind in ("object", "material", "asset")}
    assert {row.layer for row in VIEW_PASSES} <= {*LAYERS, *DATA_LAYERS, *mattes}
    assert [row.layer for row in VIEW_PASSES if row.colors] == ["samples", "error", "visibility"]


def test_a_pass_in_false_color_is_drawn_over_the_picture(shading):
    """Of its own view, before what the scene has every view show; the picture stays."""
    scene = bpy.context.scene
    assert colored_layer(scene, shading) == ""
    scene.iwis.viewport.overlay = "SAMPLES"
    assert colored_layer(scene, shading) == "samples"
    shading.iwis.render_pass = "VISIBILITY"
    assert colored_layer(scene, shading) == "visibility"
    assert view_shading(shading).shown == ""


@pytest.mark.parametrize("rotation", [0.0, 0.7])
def test_the_studio_light_is_turned_as_by_a_mapping(cube_scene, hdri, rotation):
    """Texels, matrix and strength are those of a world with a Mapping of type Vector, which is
    compared with Cycles."""
    tree = cube_scene.world.node_tree
    nodes = (f"ShaderNode{kind}" for kind in ("TexCoord", "Mapping", "TexEnvironment"))
    coordinates, mapping, texture = (tree.nodes.new(kind) for kind in nodes)
    mapping.vector_type = "VECTOR"
    mapping.inputs["Rotation"].default_value = 0.0, 0.0, rotation
    texture.image = bpy.data.images.load(hdri)
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.5
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    graph = bpy.context.evaluated_depsgraph_get()
    expected, lines = read_world(graph, []), []
    found = read_studio_light(graph, StudioLight(hdri, rotation, 1.5), lines, ExportCache().texels)
    assert not lines and found.backdrop is None
    for name in ("radiance", "strength"):
        np.testing.assert_array_equal(getattr(found.light, name), getattr(expected.light, name))
    # a quarter of a texel's thousandth
    turned = expected.light.world_to_map
    np.testing.assert_allclose(found.light.world_to_map, turned, atol=1e-6)


def test_the_camera_sees_it_over_the_worlds_color(cube_scene, hdri):
    """As opaque as is wanted; the light stays whole. The world's color counts, not its nodes."""
    cube_scene.world.color = 0.1, 0.2, 0.4
    studio = StudioLight(hdri, 0.3, 2.0, 0.25)
    scene, _ = export(ViewShading(studio=studio))
    whole = scene.environment.radiance * scene.environment.strength
    expected = 0.25 * whole + 0.75 * np.float32([0.1, 0.2, 0.4])
    np.testing.assert_allclose(scene.backdrop.radiance, expected, rtol=1e-6)
    assert (scene.backdrop.strength == 1.0).all() and scene.environment.strength[0] == 2.0
    assert same(scene.backdrop.world_to_map, scene.environment.world_to_map)
    cube_scene.world = None
    without = export(ViewShading(studio=studio))[0].backdrop
    np.testing.assert_allclose(without.radiance, 0.25 * whole, rtol=1e-6)


def test_the_studio_light_is_there_where_the_world_is_not(cube_scene, hdri):
    """In a view layer without Environment, as in Cycles; hidden from the camera as the world is."""
    bpy.context.view_layer.use_sky = False
    bpy.context.view_layer.update()
    assert not export()[0].environment.radiance.mean() * export()[0].environment.strength.any()
    cube_scene.world.cycles_visibility.camera = False
    light = export(ViewShading(studio=StudioLight(hdri)))[0].environment
    assert light.radiance.mean() > 0.1 and light.strength.all() and not light.visible_to_camera


def test_texels_are_read_once_and_nothing_is_left_in_the_file(cube_scene, hdri, monkeypatch):
    """A slider that is dragged reads no file; light that is built for them stays."""
    before, cache, lines = len(bpy.data.images), ExportCache().texels, []
    graph = bpy.context.evaluated_depsgraph_get()
    read, count = studio_light.texels_of, []
    monkeypatch.setattr(studio_light, "texels_of", lambda image: count.append(1) or read(image))
    first = read_studio_light(graph, StudioLight(hdri), lines, cache)
    second = read_studio_light(graph, StudioLight(hdri, 1.0, 3.0, 0.5), lines, cache)
    assert len(count) == 1 and first.light.radiance is second.light.radiance
    assert len(bpy.data.images) == before and not lines


def test_simplify_makes_it_smaller(cube_scene, hdri):
    """The texture limit counts for it as for every image, as in Cycles."""
    cache, graph = ExportCache().texels, bpy.context.evaluated_depsgraph_get()
    cache.size = TextureSize(limit=4)
    found = read_studio_light(graph, StudioLight(hdri), [], cache).light.radiance
    whole = read_studio_light(graph, StudioLight(hdri), [], ExportCache().texels).light.radiance
    np.testing.assert_allclose(found, whole.reshape(2, 2, 4, 2, 3).mean((1, 3)), rtol=1e-6)


@pytest.mark.parametrize("content", [None, b"", b"no picture"])
def test_a_studio_light_that_cannot_be_read_is_pink_and_told_of(cube_scene, tmp_path, content):
    """One line that says which one and what to do."""
    path = tmp_path / "gone.exr"
    if content is not None:
        path.write_bytes(content)
    scene, lines = export(ViewShading(studio=StudioLight(str(path), strength=2.0)))
    assert (scene.environment.radiance == [1.0, 0.0, 1.0]).all()
    what = "has no file" if content is None else "cannot be read"
    assert lines == [
        f"Studio light 'gone.exr': {what}: pink; choose another one in the view's shading menu, "
        "Lighting"
    ]


def test_without_a_studio_light_at_all(cube_scene):
    """No file is installed: as one that is missing."""
    _, lines = export(ViewShading(studio=StudioLight("")))
    assert lines and lines[0].startswith("Studio light 'none': has no file")


def test_a_view_asks_for_what_its_pass_takes_and_for_nothing_else(cube_scene):
    """Whatever the view layer's passes are, and its Alpha Threshold: Cycles' window has .5."""
    layer = bpy.context.view_layer
    layer.pass_alpha_threshold = 0.9
    layer.use_pass_uv = layer.use_pass_mist = layer.use_pass_cryptomatte_object = True
    cube_scene.world.mist_settings.start = 3.0
    cube_scene.world.light_settings.distance = 2.5
    bpy.context.view_layer.update()
    asked = {row.layer: export(ViewShading(shown=row.layer))[0].asked for row in VIEW_PASSES[1:]}
    assert asked["mist"].mist.start == 3.0 and asked["ambient_occlusion"].occlusion_distance == 2.5
    assert (asked["uv"].uv.row >= 0).all() and asked["shadow_catcher"].catcher
    for (name, one), field in itertools.product(asked.items(), ("mist", "uv")):
        assert one.shown == name and (getattr(one, field) is None) == (field != name)
        assert [matte.layer for matte in one.mattes] == [name] * name.startswith("crypto")
        assert (one.solid == 0.5) == (name in ("position", "normal", "uv"))
    assert export()[0].asked.uv is None


def test_a_render_knows_nothing_of_it(shading):
    """Of what a view shows, a final render has the lamps, the world and its own passes."""
    before = export(live=False)[0]
    shading.use_scene_lights_render = shading.use_scene_world_render = False
    shading.iwis.render_pass = "NORMAL"
    bpy.context.view_layer.update()
    assert same(export(live=False)[0], before)


def picture(shown, pixels):
    return SimpleNamespace(shown=shown, layers={shown: np.float32(pixels)})


def test_passes_are_drawn_as_cycles_draws_them():
    """Scene-linear, opaque, nothing below 0 or beyond a half float; numbers are greys."""
    found = shown_pixels(picture("normal", [[[-0.5, 0.25, 1.0]]]))
    np.testing.assert_array_equal(found, [[[0.0, 0.25, 1.0, 1.0]]])
    found = shown_pixels(picture("mist", [[[0.3], [math.inf]]]))
    np.testing.assert_array_equal(found[0], np.float32([[0.3] * 3 + [1.0], [65504.0] * 3 + [1.0]]))
    red, grey = np.uint32([0x3F0000FF, 0x3FFFFFFF]).view(np.float32)
    found = shown_pixels(picture("crypto_object", [[[red, 0.25, grey, 0.5], [0.0] * 4]]))
    np.testing.assert_allclose(found[0], [[0.75, 0.5, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0]], rtol=1e-6)
    combined = np.float32([[[0.1, 0.2, 0.3, 0.5]]])
    np.testing.assert_array_equal(shown_pixels(picture("combined", combined)), combined)

"""The buttons that make, compare and show pictures: what comes out of them is right."""

import bpy
import numpy as np
import pytest

from iwis.core.settings import RenderSettings
from iwis.iwis_addon.cycles_settings import compare, copy_cycles_settings
from iwis.iwis_addon.export.worlds.world import read_world
from iwis.iwis_addon.false_color import false_color, scale_of
from iwis.iwis_addon.images import put_image
from iwis.iwis_addon.job import RenderJob
from iwis.iwis_addon.world_bake import bake_world
from support.world_render import new_image, new_world, some_texels


def pixels_of(image):
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)


def test_a_baked_hdri_is_the_hdri(scene, rng):
    """Nothing is turned or mirrored: a world of strength 2 becomes itself, twice as bright."""
    tree, texels = new_world(scene), some_texels(rng)
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image, texture.interpolation = new_image(texels), "Closest"
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = 2.0
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    baked = pixels_of(bake_world(scene, height=8, samples=16))
    # The box filter reaches as far as the pixel; float32 azimuths may round across an edge.
    np.testing.assert_allclose(baked[..., :3], 2.0 * texels, rtol=0.02)


def test_convert_world_replaces_a_sky_by_its_image(cube_scene):
    """Afterwards the export has no warning, the world is an image; the old world is still there."""
    tree = cube_scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    background = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    old, warnings = cube_scene.world, []
    assert bpy.ops.iwis.convert_world(height=16, samples=4) == {"FINISHED"}
    warnings.clear()
    environment = read_world(cube_scene, warnings).light
    assert warnings == [] and environment.radiance.shape == (16, 32, 3)
    up, down = environment.radiance[-1].mean(), environment.radiance[0].mean()
    assert up > down and environment.radiance.std() > 0.0
    assert old.name in bpy.data.worlds and cube_scene.world is not old
    assert [scene.name for scene in bpy.data.scenes] == [cube_scene.name]


def test_cycles_settings_are_taken_over(scene):
    """Defaults become defaults; a fixed number of samples a fixed number."""
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, 0.01
    scene.cycles.samples, scene.cycles.seed = 300, 7
    scene.cycles.use_animated_seed, scene.cycles.pixel_filter_type = True, "BOX"
    scene.cycles.transparent_max_bounces = 0
    copy_cycles_settings(scene)
    iwis = scene.iwis
    assert iwis.transparent_max_bounces == 0
    assert iwis.error_threshold == pytest.approx(RenderSettings().error_threshold)
    assert (iwis.max_samples, iwis.seed, iwis.pixel_filter) == (300, 7, "BOX")
    assert iwis.use_animated_seed and iwis.stop_rule == "PERCEPTUAL"
    kinds = {
        item.identifier for item in scene.cycles.bl_rna.properties["pixel_filter_type"].enum_items
    }
    for kind in kinds:
        scene.cycles.pixel_filter_type = kind
        copy_cycles_settings(scene)
        assert iwis.pixel_filter == kind
    assert len(kinds) == 3
    scene.cycles.use_adaptive_sampling = False
    assert bpy.ops.iwis.copy_cycles_settings() == {"FINISHED"}
    assert iwis.stop_rule == "FIXED"


def test_cycles_time_limit_is_a_budget(scene):
    """With the samples as its other end; a scene without one gets its rule back."""
    scene.cycles.use_adaptive_sampling, scene.cycles.time_limit = True, 12.5
    copy_cycles_settings(scene)
    iwis = scene.iwis
    assert (iwis.stop_rule, iwis.time_limit, iwis.target_samples) == ("BUDGET", 12.5, 0)
    scene.cycles.time_limit = 0.0
    copy_cycles_settings(scene)
    assert (iwis.stop_rule, iwis.time_limit) == ("PERCEPTUAL", 0.0)


@pytest.mark.slow
def test_compare_with_cycles_leaves_difference_and_settings(cube_scene):
    """Both render the cube; they agree to some percent; no setting of the file has changed."""
    cube_scene.iwis.max_samples = 64
    before = (
        cube_scene.cycles.samples,
        cube_scene.render.filepath,
        cube_scene.render.film_transparent,
    )
    assert bpy.ops.iwis.compare_cycles(samples=64) == {"FINISHED"}
    image = bpy.data.images["IWIS Difference to Cycles"]
    assert tuple(image.size) == (32, 24)
    assert 0.0 < image["mre"] < 0.05 and abs(image["bias"]) < 0.02  # noise of 64 samples
    assert cube_scene.render.engine == "IWIS"
    after = (
        cube_scene.cycles.samples,
        cube_scene.render.filepath,
        cube_scene.render.film_transparent,
    )
    assert after == before


def test_compare_counts_objects_only():
    """A picture that is twice as bright has an error of 1, whatever the background is."""
    cycles = np.ones((4, 4, 4), np.float32)
    cycles[:2, :, 3] = 0.0
    ours = cycles.copy()
    ours[2:, :, :3] *= 2.0
    ours[:2, :, :3] *= 50.0
    result = compare(ours, cycles)
    assert result.mre == pytest.approx(1.0) and result.bias == pytest.approx(1.0)
    assert np.isnan(compare(ours, np.zeros_like(ours)).mre)


def test_false_color_of_the_last_render(cube_scene, tmp_path):
    """In background with Keep Film; colors grow with the samples; else the button is off."""
    cube_scene.render.filepath = str(tmp_path / "a.png")
    bpy.ops.render.render()
    assert not bpy.ops.iwis.false_color.poll()
    cube_scene.iwis.keep_film = True
    bpy.ops.render.render()
    for layer in ("samples", "error", "visibility"):
        assert bpy.ops.iwis.false_color(layer=layer) == {"FINISHED"}
    image = bpy.data.images["IWIS Samples"]
    assert tuple(image.size) == (34, 24)  # with the scale at the edge
    film = RenderJob.current.numbers["ViewLayer", ""]
    samples, colors = film.layers["samples"], pixels_of(image)[:, :32, :3].sum(axis=2)
    assert colors[samples == samples.max()].min() > colors[samples == 0].max()


def test_false_color_is_monotonous_and_clipped():
    """Brighter for more, on both kinds of scales; outside the scale the end's color."""
    for layer in ("samples", "error", "visibility"):
        scale = scale_of(layer, RenderSettings())
        values = np.linspace(scale.low, scale.high, 50, dtype=np.float32)[None]
        light = false_color(values, scale)[0, :, :3] @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(light) > 0.0).all()
        ends = np.float32([[-1.0, 1e9]])
        expected = false_color(np.float32([[scale.low, scale.high]]), scale)
        np.testing.assert_array_equal(false_color(ends, scale), expected)
        assert [place for place, _ in scale.ticks()] == [0.0, 0.25, 0.5, 0.75, 1.0]
    with pytest.raises(ValueError, match="depth"):
        scale_of("depth", RenderSettings())


def test_sampling_of_a_pixel_is_shown(cube_scene):
    """The middle shows the cube: an image of four maps with red and blue dots; a miss is named."""
    assert bpy.ops.iwis.inspect_pixel(x=16, y=12, height=32) == {"FINISHED"}
    image = bpy.data.images["IWIS Sampling"]
    assert tuple(image.size) == (136, 72) and not image.is_float
    cube_scene.camera.rotation_euler.x = 3.1
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="no object"):
        bpy.ops.iwis.inspect_pixel(x=16, y=12)
    with pytest.raises(RuntimeError, match="outside"):
        bpy.ops.iwis.inspect_pixel(x=16, y=500)


def test_images_are_made_anew_where_they_must(scene):
    """Another size or kind under the same name is the same image's name."""
    first = put_image("Test", np.zeros((4, 6, 4), np.float32), is_float=False)
    assert put_image("Test", np.ones((8, 6, 4), np.float32), is_float=False) == first
    assert tuple(first.size) == (6, 8) and pixels_of(first).min() == 1.0
    again = put_image("Test", np.full((4, 6, 4), 2.5, np.float32), is_float=True)
    assert again.name == "Test" and pixels_of(again).max() == 2.5


def test_animated_seed_changes_with_the_frame(scene):
    """Only where it is asked for."""
    from iwis.iwis_addon.settings import render_settings

    scene.iwis.seed = 3
    scene.frame_set(5)
    assert render_settings(scene).seed == 3
    scene.iwis.use_animated_seed = True
    assert render_settings(scene).seed == 8

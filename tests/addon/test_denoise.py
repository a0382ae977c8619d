"""Denoising through Blender: files, views, layers, borders; and where there is no library."""

import bpy
import numpy as np
import pytest

import iwis
from iwis.core.exr import read_exr_layers
from iwis.iwis_addon import denoiser, panels_denoise
from iwis.iwis_addon.job import RenderJob
from support.cycles_render import render_cycles
from support.iwis_render import render_iwis, use_format

COMBINED, NOISY = "ViewLayer.Combined", "ViewLayer.Noisy Image"
DATA = ("Denoising Normal", "Denoising Albedo", "Denoising Depth")


@pytest.fixture
def noisy_scene(cube_scene):
    """The cube with the noise of two samples; every pixel of it takes them."""
    cube_scene.iwis.max_samples, cube_scene.iwis.stop_rule = 2, "FIXED"
    return cube_scene


@pytest.fixture
def no_library(monkeypatch):
    """A Blender that brings none."""
    monkeypatch.setattr(denoiser, "_library_paths", list)
    denoiser.find_library.cache_clear()
    yield
    denoiser.find_library.cache_clear()


def test_blender_brings_the_library():
    """bpy does, of either version: else nothing here would be tested."""
    assert denoiser.find_library()[0]


def test_a_render_is_denoised(noisy_scene, tmp_path):
    """Other colors, the same alpha; the noisy picture is there; samples are untouched."""
    before = render_iwis(noisy_scene, tmp_path)
    assert NOISY not in before
    noisy_scene.iwis.denoise = True
    after = render_iwis(noisy_scene, tmp_path)
    assert set(after) == {*before, NOISY}
    assert (after[NOISY] == before[COMBINED]).all()
    assert (after["ViewLayer.IWIS Samples"] == before["ViewLayer.IWIS Samples"]).all()
    assert (after[COMBINED][..., 3] == before[COMBINED][..., 3]).all()
    shown = before["ViewLayer.IWIS Samples"][..., 0] > 0
    assert (after[COMBINED][shown] != before[COMBINED][shown]).any(axis=1).mean() > 0.9
    assert np.isfinite(after[COMBINED]).all()
    assert RenderJob.current.records[-1].stats.warnings == []


def test_denoising_is_off_for_a_view_layer_that_says_so(noisy_scene, tmp_path):
    """The other one is denoised, by its own guides."""
    second = noisy_scene.view_layers.new("Second")
    second.iwis.use_denoising = False
    noisy_scene.iwis.denoise = True
    layers = render_iwis(noisy_scene, tmp_path)
    assert NOISY in layers and "Second.Noisy Image" not in layers
    assert (layers["Second.Combined"] == layers[NOISY]).all()
    assert (layers[COMBINED] != layers[NOISY]).any()


@pytest.mark.parametrize("crop", [False, True])
def test_a_border_is_denoised_alone(noisy_scene, tmp_path, crop):
    """In its place; other passes of the border stay, and outside it is empty."""
    render = noisy_scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x = 0.26, 0.77
    render.border_min_y, render.border_max_y = 0.3, 0.9
    noisy_scene.view_layers[0].use_pass_position = True
    before = render_iwis(noisy_scene, tmp_path)
    noisy_scene.iwis.denoise = True
    after = render_iwis(noisy_scene, tmp_path)
    assert (after[NOISY] == before[COMBINED]).all()
    assert (after[COMBINED] != before[COMBINED]).any()
    for name in set(before) - {COMBINED}:
        assert (after[name] == before[name]).all(), name
    outside = before[COMBINED][..., 3] == 0.0
    assert outside.any() != crop and (after[COMBINED][outside] == 0.0).all()


def test_both_eyes_are_denoised(noisy_scene, tmp_path):
    """Each has its own picture."""
    render = noisy_scene.render
    render.use_multiview, render.views_format = True, "STEREO_3D"
    noisy_scene.camera.data.stereo.interocular_distance = 0.5
    noisy_scene.iwis.denoise = True
    use_format(noisy_scene, "OPEN_EXR_MULTILAYER")
    render.image_settings.views_format = "INDIVIDUAL"
    render.filepath = str(tmp_path / "eyes.exr")
    bpy.ops.render.render(write_still=True)
    left, right = (read_exr_layers(tmp_path / f"eyes{eye}.exr") for eye in ("_L", "_R"))
    for eye in (left, right):
        assert (eye[COMBINED] != eye[NOISY]).any()
        assert (eye[COMBINED][..., 3] == eye[NOISY][..., 3]).all()
    assert (left[COMBINED] != right[COMBINED]).any()


def test_scripts_get_both_pictures(noisy_scene):
    """iwis.render() and the command line's names: denoised, and noisy beside."""
    iwis.settings(noisy_scene, denoise=True)
    noisy_scene.render.film_transparent = True
    layers = iwis.render(noisy_scene)
    assert layers["noisy"].shape == layers["combined"].shape
    assert (layers["noisy"][..., :3] != layers["combined"][..., :3]).any()
    empty = layers["combined"][..., 3] == 0.0
    assert empty.any() and (layers["combined"][empty] == 0.0).all()
    iwis.settings(noisy_scene, denoise=False)
    assert "noisy" not in iwis.render(noisy_scene)


def test_an_animation_is_denoised_frame_by_frame(noisy_scene, tmp_path):
    """The switch may be animated: a file has the pass where its frame is denoised."""
    noisy_scene.frame_end = 2
    for frame, on in ((1, False), (2, True)):
        noisy_scene.iwis.denoise = on
        noisy_scene.keyframe_insert("iwis.denoise", frame=frame)
    for frame, on in ((1, False), (2, True)):
        noisy_scene.frame_set(frame)
        assert (NOISY in render_iwis(noisy_scene, tmp_path)) == on


def test_without_a_library_there_is_a_warning_and_the_noisy_picture(
    noisy_scene, tmp_path, no_library
):
    """Not a failure; the panel is greyed and says why."""
    before = render_iwis(noisy_scene, tmp_path)[COMBINED]
    noisy_scene.iwis.denoise = True
    after = render_iwis(noisy_scene, tmp_path)
    assert (after[COMBINED] == before).all() and (after[NOISY] == before).all()
    (warning,) = RenderJob.current.records[-1].stats.warnings
    assert "keeps its noise" in warning and "no Open Image Denoise" in warning


def test_save_film_has_what_denoising_adds(noisy_scene, tmp_path):
    """And without denoising it has not."""
    noisy_scene.iwis.keep_film = True
    render_iwis(noisy_scene, tmp_path)
    path = str(tmp_path / "film.exr")
    assert bpy.ops.iwis.save_film(filepath=path) == {"FINISHED"}
    before = read_exr_layers(path)
    noisy_scene.iwis.denoise = True
    noisy_scene.view_layers[0].iwis.use_pass_denoising_data = True
    picture = render_iwis(noisy_scene, tmp_path)
    assert bpy.ops.iwis.save_film(filepath=path) == {"FINISHED"}
    film = read_exr_layers(path)
    assert set(film) - set(before) == {NOISY, *(f"ViewLayer.{name}" for name in DATA)}
    for name in (COMBINED, NOISY):
        assert (film[name] == picture[name]).all()


def test_sockets_follow_the_switches(noisy_scene):
    """Those of Denoising Data, and Noisy Image where the scene and the layer are denoised."""
    layer = noisy_scene.view_layers[0]
    if bpy.app.version >= (5, 0, 0):
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        noisy_scene.compositing_node_group = tree
    else:
        noisy_scene.use_nodes = True
        tree = noisy_scene.node_tree
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = noisy_scene

    def names():
        return {output.name for output in node.outputs if output.enabled}

    layer.iwis.use_pass_denoising_data = True
    assert set(DATA) <= names() and "Noisy Image" not in names()
    noisy_scene.iwis.denoise = True
    assert "Noisy Image" in names()
    layer.iwis.use_denoising = False
    assert "Noisy Image" not in names()


class Drawn:
    """A layout that notes what is drawn, and whether a user can change it."""

    def __init__(self):
        self.enabled, self.props, self.labels = True, {}, []

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties
        self.props[name] = self

    def label(self, text="", **_options):
        self.labels.append(text)

    def column(self, **_options):
        own = Drawn()
        own.props, own.labels = self.props, self.labels
        return own

    row = column


def test_the_box_is_greyed_with_the_reason(noisy_scene, no_library):
    """Where Blender has no library; and no option that does nothing is shown."""
    layout = Drawn()
    noisy_scene.iwis.denoise = True
    panels_denoise.draw_denoise(layout, bpy.context, noisy_scene.iwis)
    assert list(layout.props) == ["denoise"] and not layout.props["denoise"].enabled
    assert "Open Image Denoise" in " ".join(layout.labels)


def test_options_are_shown_where_they_do_something(noisy_scene):
    """Start Sample is the rendered view's alone."""
    layout = Drawn()
    panels_denoise.draw_denoise(layout, bpy.context, noisy_scene.iwis)
    assert list(layout.props) == ["denoise"] and layout.props["denoise"].enabled
    assert not layout.labels
    noisy_scene.iwis.denoise = noisy_scene.iwis.viewport.denoise = True
    panels_denoise.draw_denoise(layout, bpy.context, noisy_scene.iwis)
    options = ["denoise", "denoise_passes", "denoise_prefilter", "denoise_quality"]
    assert list(layout.props) == options
    view = Drawn()
    panels_denoise.draw_denoise(view, bpy.context, noisy_scene.iwis.viewport)
    assert list(view.props) == [*options, "denoise_start"]


def test_cycles_settings_are_copied(noisy_scene):
    """Of renders, of the rendered view, and of view layers."""
    cycles, layer = noisy_scene.cycles, noisy_scene.view_layers[0]
    cycles.use_denoising, cycles.denoising_input_passes = True, "RGB_ALBEDO"
    cycles.denoising_prefilter, cycles.denoising_quality = "NONE", "BALANCED"
    cycles.use_preview_denoising, cycles.preview_denoising_start_sample = True, 17
    cycles.preview_denoising_input_passes = "RGB"
    layer.cycles.use_denoising, layer.cycles.denoising_store_passes = False, True
    bpy.ops.iwis.copy_cycles_settings()
    own, view = noisy_scene.iwis, noisy_scene.iwis.viewport
    assert (own.denoise, own.denoise_passes) == (True, "ALBEDO")
    assert (own.denoise_prefilter, own.denoise_quality) == ("NONE", "BALANCED")
    assert (view.denoise, view.denoise_passes, view.denoise_start) == (True, "NONE", 17)
    assert not layer.iwis.use_denoising and layer.iwis.use_pass_denoising_data


@pytest.mark.slow
def test_denoising_data_is_that_of_cycles(noisy_scene, tmp_path):
    """Of a rough surface and of the world: names, normals of the camera, color, ray lengths."""
    noisy_scene.iwis.pixel_filter = "CENTER"
    layer = noisy_scene.view_layers[0]
    layer.iwis.use_pass_denoising_data = True
    ours = render_iwis(noisy_scene, tmp_path)
    layer.cycles.denoising_store_passes = True
    theirs = render_cycles(noisy_scene, tmp_path, ())
    hit = ours["ViewLayer.Denoising Depth"][..., 0] < 1e9
    for name in DATA:
        far = np.abs(ours[f"ViewLayer.{name}"] - theirs[name]).max(axis=2)
        where = hit if name == "Denoising Depth" else np.ones_like(hit)
        # A ray that grazes an edge may hit either side of it: 1 of 100 pixels may.
        assert np.quantile(far[where], 0.99) < 2e-4, name  # float32 of some metres

"""Bad scenes: a picture where one is possible, one clear message for each thing that is wrong."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon import render_result
from iwis.iwis_addon.job import RenderJob
from iwis.iwis_addon.notices import last_lines
from support import bad_scenes as bad
from support.iwis_render import render_iwis


@pytest.fixture
def rendered(cube_scene, tmp_path):
    """A function: change(scene, tmp_path), then render; layers without a prefix, and warnings."""

    def render(change):
        change(cube_scene, tmp_path)
        bpy.context.view_layer.update()
        layers = render_iwis(cube_scene, tmp_path)
        warnings = RenderJob.get().records[-1].stats.warnings
        return {name.removeprefix("ViewLayer."): layer for name, layer in layers.items()}, warnings

    return render


# What happens -> words of its only warning; none: nothing is wrong.
LIT = {
    bad.hdri_missing: ("White", "Sky", "gone.hdr", "Find Missing Files", "Pink"),
    bad.hdri_empty: ("White", "Sky", "empty.exr", "empty file", "copy it again", "Pink"),
    bad.hdri_damaged: ("White", "Sky", "bad.exr", "damaged", "replace it", "Pink"),
    bad.hdri_cut: ("White", "Sky", "cut.hdr", "damaged", "replace it", "Pink"),
    bad.hdri_is_a_folder: ("White", "Sky", "is a folder", "choose a file", "Pink"),
    bad.hdri_not_chosen: ("White", "Sky", "no image is chosen", "choose one", "Pink"),
    bad.hdri_with_nan: ("White", "Sky", "map", "1 of 128 texels are NaN: 0 instead"),
    bad.hdri_with_infinity: ("White", "Sky", "map", "1 of 128 texels are infinite: 0.5 instead"),
    bad.hdri_with_overflow: ("White", "Sky", "map", "too bright to render: 0.5 instead"),
    bad.hdri_with_negatives: ("White", "Sky", "map", "1 of 128 texels are too far below 0"),
    bad.hdri_of_one_texel: (),
    bad.hdri_of_two_texels: (),
    bad.hdri_of_one_column: (),
    bad.strength_infinite: ("White", "strength", "is too large: 1e+10 is used"),
    bad.colour_nan: ("White", "colour is NaN: 0 instead"),
    bad.broken_triangles: (
        "Broken",
        "3 triangles",
        "1 without area",
        "2 with a vertex",
        "clean up",
    ),
    bad.transform_nan: ("Cube", "transform is not finite"),
    bad.flat_scale: ("Cube", "8 triangles", "8 without area"),
    bad.scale_0: (),
    bad.slot_left_empty: (),
    bad.slot_beyond_the_last: (),
    bad.material_nan: ("Cube", "Skin", "base color", "not finite"),
    bad.far_from_the_origin: ("Cube", "without area", "nearer to the origin"),
    bad.scene_of_1e7_metres: (),
    bad.scene_of_a_hundredth_of_a_millimetre: (),
    bad.error_threshold_0: (),
    bad.fewer_samples_than_a_batch: (),
    bad.a_million_threads: (),
}


def name_of(value):
    return getattr(value, "__name__", "")


@pytest.mark.parametrize(("change", "words"), LIT.items(), ids=name_of)
def test_scene_is_rendered_with_one_message(rendered, change, words):
    """Every layer is finite, the ground is lit, and nothing else is said."""
    layers, warnings = rendered(change)
    assert all(np.isfinite(layer).all() for layer in layers.values())
    assert (layers["Combined"][..., :3].max(-1) > 0.05).mean() > 0.5
    assert len(warnings) == bool(words), warnings
    assert all(word in warnings[0] for word in words), warnings


BLACK = {
    bad.no_world: ("no world", "add one"),
    bad.world_without_shader: ("White", "nothing is linked"),
    bad.world_black: ("White", "gives no light"),
    bad.hdri_all_nan: ("White", "Sky", "8 of 8 texels are NaN"),
}


@pytest.mark.parametrize(("change", "words"), BLACK.items(), ids=name_of)
def test_black_picture_is_explained(rendered, change, words):
    """No light, but the geometry is there: its layers are what they would be."""
    layers, warnings = rendered(change)
    assert layers["Combined"][..., :3].max() == 0.0
    assert (layers["Combined"][..., 3] == 1.0).all()
    assert len(warnings) == 1 and all(word in warnings[0] for word in words), warnings


@pytest.mark.parametrize(
    ("change", "n_warnings"),
    [
        (bad.no_objects, 0),
        (bad.only_broken_triangles, 1),
        (bad.clip_end_before_everything, 0),
        (bad.clip_end_before_clip_start, 0),
    ],
    ids=name_of,
)
def test_nothing_to_see_is_the_world(rendered, change, n_warnings):
    """White everywhere, without a sample."""
    layers, warnings = rendered(change)
    assert (layers["Combined"] == 1.0).all()
    assert layers["IWIS Samples"].max() == 0.0
    assert len(warnings) == n_warnings


def test_camera_inside_a_closed_body_sees_black(rendered):
    """No light comes in; that is no error."""

    def enter(scene, _folder):
        scene.camera.location = (0.0, 0.0, 0.5)

    layers, warnings = rendered(enter)
    assert layers["Combined"][..., :3].max() == 0.0 and warnings == []
    assert layers["IWIS Samples"].min() == 8.0


def test_picture_of_one_pixel(rendered):
    """Blender's least size is four pixels, but a percentage makes it one."""

    def shrink(scene, _folder):
        scene.render.resolution_x = scene.render.resolution_y = 4
        scene.render.resolution_percentage = 25

    layers, warnings = rendered(shrink)
    assert layers["Combined"].shape == (1, 1, 4) and layers["Combined"].min() > 0.0
    assert warnings == []


def test_picture_that_memory_has_no_room_for_is_an_error(rendered, tmp_path, monkeypatch):
    """Nothing is exported, and Blender is given no result, which it would die of: no file."""
    monkeypatch.setattr(render_result, "free_memory_bytes", lambda: 1000)
    with pytest.raises(RuntimeError, match=r"has 32 x 24 pixels; its passes need .* GB"):
        rendered(lambda _scene, _folder: None)
    assert not list(tmp_path.iterdir())
    assert RenderJob.get().records == []


def test_picture_that_fits_into_memory_is_rendered(rendered, monkeypatch):
    """Of memory that the passes just leave free."""
    monkeypatch.setattr(render_result, "free_memory_bytes", lambda: 1_000_000)
    assert rendered(lambda _scene, _folder: None)[0]["Combined"].max() > 0.0


def test_line_breaks_of_names_are_no_lines(rendered, caplog):
    """A warning is one line of the log and of the panel."""
    rendered(bad.hdri_of_a_broken_name)
    (line,) = [text for text in caplog.text.splitlines() if "gone" in text]
    assert r"new\nline.hdr" in line
    assert any(r"new\nline.hdr" in line for line in last_lines())


FAILURES = {
    bad.no_camera: "no camera",
    bad.flat_camera: "Camera has a scale of 0 or a transform that is not finite: set its scale",
    bad.camera_nowhere: "Camera has a scale of 0 or a transform that is not finite",
    bad.damaged_mesh: r"Mesh Damaged: a face has a vertex that is not there.*validate",
    bad.empty_border: "Image too small",
}


@pytest.mark.parametrize(("change", "message"), FAILURES.items(), ids=name_of)
def test_impossible_picture_is_an_error(rendered, change, message, tmp_path, capfd):
    """Blender's operator fails with the message; no file, no traceback."""
    with pytest.raises(RuntimeError, match=message):
        rendered(change)
    assert not list(tmp_path.glob("*.exr"))
    assert "Traceback" not in capfd.readouterr().err

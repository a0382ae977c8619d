"""Renders from end to end, as Blender calls the engine."""

import collections
import time

import bpy
import numpy as np
import pytest

from iwis.core import render as core_render
from iwis.core.exr import read_exr_layers
from iwis.iwis_addon import stereo
from iwis.iwis_addon.job import RenderJob, stats_by_frame
from iwis.iwis_addon.sink import BlenderSink
from support.cycles_render import use_cycles
from support.iwis_render import render_iwis, use_format

COMBINED = "ViewLayer.Combined"


def test_a_picture_comes_out(cube_scene, tmp_path):
    """A grey cube under a white sky is neither black nor brighter than the sky; alpha is 1."""
    picture = render_iwis(cube_scene, tmp_path)[COMBINED]
    assert picture.shape == (24, 32, 4)
    assert np.isfinite(picture).all()
    assert (picture[..., 3] == 1.0).all()
    assert 0.2 < picture[..., :3].mean() < 1.0
    stats = RenderJob.current.records[-1].stats
    assert (stats.width, stats.height) == (32, 24)
    assert 0 < stats.samples_max <= cube_scene.iwis.max_samples
    assert stats.seconds["export"] > 0.0 and stats.seconds["sampling"] > 0.0


def test_an_empty_scene_shows_the_world(cube_scene, tmp_path):
    """No object at all: the world alone, and no error."""
    for thing in list(bpy.data.objects):
        if thing.type == "MESH":
            bpy.data.objects.remove(thing)
    assert (render_iwis(cube_scene, tmp_path)[COMBINED] == 1.0).all()


def test_same_settings_same_bits(cube_scene, tmp_path):
    """Threads and tiles change nothing; the seed does."""
    first = render_iwis(cube_scene, tmp_path)[COMBINED]
    cube_scene.iwis.tile_px, cube_scene.iwis.threads = 8, 2
    assert (render_iwis(cube_scene, tmp_path)[COMBINED] == first).all()
    cube_scene.iwis.seed = 1
    assert (render_iwis(cube_scene, tmp_path)[COMBINED] != first).any()


@pytest.mark.parametrize("crop", [False, True])
def test_border_is_the_same_part_of_the_frame(cube_scene, tmp_path, crop):
    """A border's pixels are the whole frame's; outside it is empty, or cropped away."""
    whole = render_iwis(cube_scene, tmp_path)
    render = cube_scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x = 0.26, 0.77
    render.border_min_y, render.border_max_y = 0.3, 0.9
    part = render_iwis(cube_scene, tmp_path)
    x0, x1 = int(np.float32(0.26) * 32), int(np.float32(0.77) * 32)
    y0, y1 = int(np.float32(0.3) * 24), int(np.float32(0.9) * 24)
    for name, pixels in part.items():
        expected = np.zeros_like(whole[name])
        expected[y0:y1, x0:x1] = whole[name][y0:y1, x0:x1]
        assert (pixels == (expected[y0:y1, x0:x1] if crop else expected)).all(), name


def test_every_view_layer_is_rendered(cube_scene, tmp_path):
    """Each layer has its own passes and its own collections."""
    second = cube_scene.view_layers.new("Second")
    second.iwis.use_pass_samples, second.use_pass_z = False, True
    hidden = bpy.data.collections.new("Hidden")
    cube_scene.collection.children.link(hidden)
    cube = bpy.data.objects["Cube"]
    for collection in list(cube.users_collection):
        collection.objects.unlink(cube)
    hidden.objects.link(cube)
    second.layer_collection.children["Hidden"].exclude = True
    layers = render_iwis(cube_scene, tmp_path)
    assert set(layers) == {COMBINED, "ViewLayer.IWIS Samples", "Second.Combined", "Second.Depth"}
    assert (layers[COMBINED] != layers["Second.Combined"]).any()
    assert [r.layer for r in RenderJob.current.records] == ["ViewLayer", "Second"]


def render_views(scene, engine, folder, suffixes):
    """The Position pass of each view: float32 (h, w, 3)."""
    scene.render.engine = engine
    scene.render.filepath = str(folder / f"{engine}.exr")
    bpy.ops.render.render(write_still=True)
    return [
        read_exr_layers(folder / f"{engine}{suffix}.exr")["ViewLayer.Position"]
        for suffix in suffixes
    ]


def views_differ_by(scene, folder, suffixes):
    """Largest distance of seen points, IWIS against Cycles, left out the edges of objects."""
    use_cycles(scene)
    scene.view_layers[0].use_pass_position = True
    use_format(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.views_format = "INDIVIDUAL"
    ours = render_views(scene, "IWIS", folder, suffixes)
    cycles = render_views(scene, "CYCLES", folder, suffixes)
    assert (ours[0] != ours[1]).any()
    distances = np.abs(np.array(ours) - np.array(cycles)).max(axis=-1)
    # A ray that grazes an edge may hit either side of it: 1 of 200 pixels may.
    return np.quantile(distances, 0.995)


@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL", "TOE"])
def test_both_eyes_see_what_cycles_sees(cube_scene, tmp_path, mode):
    """Each eye's points are those of Cycles, in all three modes of convergence."""
    render = cube_scene.render
    render.use_multiview, render.views_format = True, "STEREO_3D"
    stereo = cube_scene.camera.data.stereo
    stereo.convergence_mode, stereo.convergence_distance = mode, 3.0
    stereo.interocular_distance = 0.5
    assert views_differ_by(cube_scene, tmp_path, ("_L", "_R")) < 1e-4  # float32 of 5 m


def _hold_back_tiles(monkeypatch, first: int) -> None:
    """Have all tiles of a render but so many wait until it is cancelled: else a busy machine may
    have done the last one before anybody asks."""
    begun, make = collections.Counter(), core_render.make_tile

    def held_back(job, rect):
        begun[job.stop] += 1
        late = begun[job.stop] > first
        deadline = time.monotonic() + 60.0
        while late and not job.stop.is_set() and time.monotonic() < deadline:
            time.sleep(0.002)
        return make(job, rect)

    monkeypatch.setattr(core_render, "make_tile", held_back)


@pytest.mark.parametrize("way", ["border", "denoised", "cancelled"])
def test_views_that_arrive_whole_are_the_same(cube_scene, tmp_path, monkeypatch, way):
    """A window gets each eye's picture at once, all passes of it; after a cancel what is done."""
    render, layer = cube_scene.render, cube_scene.view_layers[0]
    render.use_multiview = render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_y = 0.26, 0.9
    layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
    cube_scene.iwis.denoise, cube_scene.iwis.tile_px = way == "denoised", 8
    results, end = [], BlenderSink._deliver
    monkeypatch.setattr(BlenderSink, "_deliver", lambda *of: (results.append(of[1:5]), end(*of)))
    if way == "cancelled":
        monkeypatch.setattr(BlenderSink, "cancelled", lambda sink: sink.tiles_written >= 3)
        _hold_back_tiles(monkeypatch, 4)

    def eyes(whole: bool) -> list:
        monkeypatch.setattr(stereo, "at_once", lambda view: whole and bool(view))
        results.clear()
        use_format(cube_scene, "OPEN_EXR_MULTILAYER")
        render.filepath = str(tmp_path / f"{whole}.exr")
        bpy.ops.render.render(write_still=True)
        return [read_exr_layers(tmp_path / f"{whole}_{side}.exr") for side in "LR"]

    for expected, found in zip(eyes(False), eyes(True), strict=True):
        assert expected.keys() == found.keys()
        filled = found[COMBINED][..., 3] > 0.0
        assert filled.any() and filled.all() == (way != "cancelled")
        if way != "cancelled":
            for name, pixels in expected.items():
                assert (found[name] == pixels).all(), name
    assert len(results) == 2 and {size[:2] for size in results} == {(0, 0)}


def test_several_cameras_see_what_cycles_sees(cube_scene, tmp_path):
    """With one camera a view, each has its own place and lens."""
    first = cube_scene.camera
    first.name = "Camera_near"
    second = first.copy()
    second.data = first.data.copy()
    second.name = "Camera_far"
    second.data.lens, second.data.shift_x = 24.0, 0.1
    second.location.x += 0.7
    cube_scene.collection.objects.link(second)
    render = cube_scene.render
    render.use_multiview, render.views_format = True, "MULTIVIEW"
    for view, suffix in zip(render.views, ("_near", "_far"), strict=True):
        view.camera_suffix = view.file_suffix = suffix
    assert views_differ_by(cube_scene, tmp_path, ("_near", "_far")) < 1e-4  # float32 of 5 m


@pytest.mark.parametrize("persistent", [False, True])
def test_animation_shares_caches_and_lets_them_go(cube_scene, tmp_path, persistent):
    """All frames of a job see the same caches; they stay after it only with Persistent Data."""
    cube_scene.frame_end = 3
    cube_scene.render.use_persistent_data = persistent
    use_format(cube_scene, "PNG")
    cube_scene.render.filepath = str(tmp_path / "frame_")
    seen = []

    def remember(_scene, _depsgraph=None):
        seen.append((RenderJob.current.export_cache, RenderJob.current.render_cache()))

    bpy.app.handlers.render_post.append(remember)
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.render_post.remove(remember)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"frame_000{frame}.png" for frame in (1, 2, 3)
    ]
    assert len(seen) == 3
    assert all(caches[0] is seen[0][0] and caches[1] is seen[0][1] for caches in seen)
    assert (RenderJob.current.export_cache is seen[0][0]) == persistent
    assert [frame.frame for frame in stats_by_frame(RenderJob.current.records)] == [1, 2, 3]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert RenderJob.current is None


def test_animated_settings_and_passes(cube_scene, tmp_path):
    """A keyframe on a setting of the engine is followed."""
    cube_scene.iwis.stop_rule = "FIXED"
    for frame, count in ((1, 2), (2, 6)):
        cube_scene.iwis.max_samples = count
        cube_scene.keyframe_insert("iwis.max_samples", frame=frame)
    for frame, count in ((1, 2), (2, 6)):
        cube_scene.frame_set(frame)
        assert render_iwis(cube_scene, tmp_path)["ViewLayer.IWIS Samples"].max() == count


def test_compositing_follows_the_render(cube_scene, tmp_path):
    """The compositor gets the passes: its picture of IWIS Samples is the pass."""
    if bpy.app.version >= (5, 0, 0):
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        cube_scene.compositing_node_group = tree
        output = tree.nodes.new("NodeGroupOutput")
    else:
        cube_scene.use_nodes = True
        tree = cube_scene.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    layers = tree.nodes.new("CompositorNodeRLayers")
    tree.links.new(layers.outputs["IWIS Samples"], output.inputs[0])
    use_format(cube_scene, "OPEN_EXR")
    cube_scene.render.filepath = str(tmp_path / "composite.exr")
    bpy.ops.render.render(write_still=True)
    picture = read_exr_layers(tmp_path / "composite.exr")[""]
    assert set(np.unique(picture[..., 0])) <= set(range(cube_scene.iwis.max_samples + 1))
    assert picture[..., 0].max() > 1.0


def test_film_is_kept_and_saved_where_asked(cube_scene, tmp_path):
    """Save Film writes all layers, as long as Keep Film was on; without it the button is off."""
    render_iwis(cube_scene, tmp_path)
    assert not bpy.ops.iwis.save_film.poll()
    cube_scene.iwis.keep_film = True
    picture = render_iwis(cube_scene, tmp_path)[COMBINED]
    assert bpy.ops.iwis.save_film(filepath=str(tmp_path / "film.exr")) == {"FINISHED"}
    film = read_exr_layers(tmp_path / "film.exr")
    assert (film[COMBINED] == picture).all()
    assert film["ViewLayer.Position"].shape == (24, 32, 3)
    with pytest.raises(RuntimeError, match="was not saved"):
        bpy.ops.iwis.save_film(filepath=str(tmp_path / "no" / "folder.exr"))


@pytest.mark.parametrize("event", ["render_pre", "frame_change_post"])
def test_a_handler_may_render(cube_scene, tmp_path, event):
    """Another scene, before a frame: the frame has its picture all the same.

    (One and the same scene inside itself ends Blender, whatever the engine.)
    """
    cube_scene.frame_end, begun = 1, []
    cube_scene.copy().name = "Screen"

    def render_within(scene, *_):
        if scene.name != "Screen" and not begun:
            begun.append(event)
            bpy.ops.render.render(scene="Screen")

    handlers = getattr(bpy.app.handlers, event)
    handlers.append(render_within)
    try:
        cube_scene.render.filepath = str(tmp_path / "out_")
        bpy.ops.render.render(animation=True)
    finally:
        handlers.remove(render_within)
    (written,) = tmp_path.iterdir()
    pixels = np.array(bpy.data.images.load(str(written)).pixels[:]).reshape(-1, 4)
    assert begun and 0.2 < pixels[:, :3].mean() < 1.0
    assert RenderJob.rendering == "" and not RenderJob.around

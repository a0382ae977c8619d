"""A picture that is cut short is found where the disk ran full, and only there."""

import shutil
import sys
from types import SimpleNamespace

import bpy
import pytest

from iwis.iwis_addon import job, output
from iwis.iwis_addon.output import check_room, check_saved, check_written, has_pixels, lacks_layers
from support.compositor import empty_tree
from support.iwis_render import use_format


@pytest.fixture
def picture(scene, tmp_path, request):
    """A file of each format, saved by Blender."""
    scene.render.engine = "BLENDER_WORKBENCH"
    suffix, file_format = request.param
    use_format(scene, file_format)
    image = bpy.data.images.new("picture", 64, 64)
    image.generated_type = "COLOR_GRID"
    path = tmp_path / f"picture{suffix}"
    image.save_render(str(path), scene=scene)
    return path


@pytest.mark.parametrize("border", [None, (0.2, 0.4), (0.2, 0.24), (0.49, 0.51), (0.0, 1.0)])
@pytest.mark.parametrize("size", [(40, 40, 100), (8, 40, 30), (4, 4, 20), (4, 4, 25), (40, 4, 24)])
def test_pictures_without_pixels_are_those_that_blender_refuses(cube_scene, size, border):
    """By resolution, percentage and border."""
    render = cube_scene.render
    render.engine = "BLENDER_WORKBENCH"
    render.resolution_x, render.resolution_y, render.resolution_percentage = size
    if border is not None:
        render.use_border = True
        render.border_min_x, render.border_max_x = border
    refused = False
    cube_scene.camera = None  # the next thing that is wrong, where the size is right
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        refused = "Image too small" in str(error)
    assert has_pixels(render) != refused


_PROGRAM = SimpleNamespace(background=True, module=False)

both = pytest.mark.parametrize(
    "picture", [(".png", "PNG"), (".exr", "OPEN_EXR")], indirect=True, ids=["png", "exr"]
)


@both
def test_whole_file_is_fine(picture):
    """And is named: others may ask how many there are."""
    assert check_written(picture) == [picture]


@both
def test_cut_file_is_named(picture):
    """What Blender calls a success is none."""
    picture.write_bytes(picture.read_bytes()[:-100])
    with pytest.raises(OSError, match=rf"{picture.name}: is cut short: the disk is full"):
        check_written(picture)


def test_views_beside_the_name_are_looked_at(tmp_path):
    """One of two is empty; brackets in a name are letters."""
    (tmp_path / "out[1]_L.png").write_bytes(b"IEND\xaeB`\x82")
    (tmp_path / "out[1]_R.png").touch()
    with pytest.raises(OSError, match=r"out\[1\]_R.png"):
        check_written(tmp_path / "out[1].png")


@pytest.mark.parametrize("movie", [False, True])
def test_movies_are_not_asked(cube_scene, tmp_path, monkeypatch, movie):
    """They are written frame by frame, and empty at first."""
    use_format(cube_scene, "PNG")
    cube_scene.render.filepath = str(tmp_path / "out_#.png")
    (tmp_path / f"out_{cube_scene.frame_current}.png").touch()
    render = SimpleNamespace(
        is_movie_format=movie, frame_path=cube_scene.render.frame_path, use_compositing=False
    )
    scene = SimpleNamespace(render=render, frame_current=cube_scene.frame_current)
    monkeypatch.setattr(output, "bpy", SimpleNamespace(app=_PROGRAM, path=bpy.path))
    if movie:
        check_saved(scene)
    else:
        with pytest.raises(OSError, match="is cut short"):
            check_saved(scene)


def test_cut_frame_ends_an_animation(cube_scene, tmp_path, monkeypatch):
    """The next frame is not rendered, and the process will end with a failure."""
    ended = []

    def cut(scene):
        if scene.frame_current == 2:
            raise OSError("out_2: is cut short")

    monkeypatch.setattr(job, "check_saved", cut)
    monkeypatch.setattr(job, "end_with_failure", lambda temporary: ended.append(temporary))
    cube_scene.frame_end = 4
    cube_scene.render.filepath = str(tmp_path / "out_#")
    use_format(cube_scene, "PNG")
    with pytest.raises(RuntimeError, match=r"out_2: is cut short; the frames after it are not"):
        bpy.ops.render.render(animation=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out_1.png", "out_2.png"]
    assert ended == [bpy.app.tempdir]


def turn_layers_off(scene):
    for layer in scene.view_layers:
        layer.use = False


def test_farm_job_without_a_view_layer_fails(cube_scene, tmp_path, monkeypatch):
    """Blender would save a picture of nothing, and end with 0. The layers stay off."""
    turn_layers_off(cube_scene)
    monkeypatch.setattr(job, "is_farm_job", lambda: True)
    cube_scene.render.filepath = str(tmp_path / "out")
    with pytest.raises(RuntimeError, match="No view layer is on: turn on Use for Rendering"):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.iterdir())
    assert not cube_scene.view_layers[0].use


@pytest.mark.parametrize("first_on", [True, False])
def test_farm_job_knows_layers_that_are_animated(cube_scene, tmp_path, monkeypatch, first_on):
    """Of each frame its own: what the file was saved with says nothing."""
    layer = cube_scene.view_layers[0]
    for frame, on in ((1, first_on), (2, not first_on)):
        layer.use = on
        layer.keyframe_insert("use", frame=frame)
    monkeypatch.setattr(job, "is_farm_job", lambda: True)
    cube_scene.frame_start = cube_scene.frame_end = 1 if first_on else 2
    cube_scene.render.filepath = str(tmp_path / "out_#")
    use_format(cube_scene, "PNG")
    bpy.ops.render.render(animation=True)
    assert len(list(tmp_path.iterdir())) == 1
    cube_scene.frame_end = cube_scene.frame_start = 2 if first_on else 1
    with pytest.raises(RuntimeError, match="No view layer is on"):
        bpy.ops.render.render(animation=True)
    assert len(list(tmp_path.iterdir())) == 1


def test_compositor_without_render_layers_needs_no_view_layer(cube_scene):
    """Blender asks an engine for those of the scene's Render Layers nodes alone."""
    assert not lacks_layers(cube_scene)
    turn_layers_off(cube_scene)
    assert lacks_layers(cube_scene)
    tree = empty_tree(cube_scene)
    tree.nodes.new("CompositorNodeImage")
    assert not lacks_layers(cube_scene)
    cube_scene.render.use_compositing = False
    assert lacks_layers(cube_scene)
    cube_scene.render.use_compositing = True
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = cube_scene
    assert lacks_layers(cube_scene)
    node.mute = True
    assert not lacks_layers(cube_scene)


def test_strips_need_no_view_layer(cube_scene):
    """They are the picture."""
    turn_layers_off(cube_scene)
    editor = cube_scene.sequence_editor_create()
    assert lacks_layers(cube_scene)
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    ends = {"length": 5} if bpy.app.version >= (5, 0) else {"frame_end": 6}
    strips.new_effect("Color", "COLOR", channel=1, frame_start=1, **ends)
    assert not lacks_layers(cube_scene)
    cube_scene.render.use_sequencer = False
    assert lacks_layers(cube_scene)


@pytest.mark.parametrize(
    "words",
    [("-f", "1"), ("--render-anim",), ("-P", "script.py"), ("-P", "script.py", "--", "-f", "1")],
)
def test_room_is_asked_for_what_the_command_line_saves(cube_scene, tmp_path, monkeypatch, words):
    """A script may render without saving; and a file system that knows no size has room."""
    real = shutil.disk_usage
    cube_scene.render.filepath = str(tmp_path / "picture")
    monkeypatch.setattr(sys, "argv", ["blender", "-b", "a.blend", *words])
    monkeypatch.setattr(output, "bpy", SimpleNamespace(app=_PROGRAM, path=bpy.path))
    monkeypatch.setattr(shutil, "disk_usage", lambda path: real(path)._replace(free=0))
    if words[0] == "-P":
        check_room(cube_scene, 4)
    else:
        with pytest.raises(OSError, match="0 bytes are left"):
            check_room(cube_scene, 4)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: real(path)._replace(free=0, total=0))
    check_room(cube_scene, 4)

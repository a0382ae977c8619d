"""What Blender calls a success, and is none: full disks, movies, scenes of a compositor."""

import contextlib
import errno
import io
import tempfile
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

from iwis.iwis_addon import engine, file_outputs, job, output
from iwis.iwis_addon.file_outputs import output_folders
from iwis.iwis_addon.output import check_saved
from support.compositor import empty_tree
from support.iwis_render import use_format

_PROGRAM = SimpleNamespace(background=True, module=False)


@pytest.fixture
def full(monkeypatch):
    """Folders whose disks are full, as whoever writes to them is told."""
    folders, real = set(), tempfile.TemporaryFile

    class Full(io.RawIOBase):
        def write(self, _data):
            raise OSError(errno.ENOSPC, "No space left on device")

    def open_in(dir, buffering):
        return Full() if Path(dir) in folders else real(dir=dir, buffering=buffering)

    monkeypatch.setattr(file_outputs.tempfile, "TemporaryFile", open_in)
    return folders


def use_movie(scene, path, size):
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "VIDEO"
    scene.render.image_settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format = "MPEG4"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.filepath = str(path / "movie_")
    scene.frame_start = scene.frame_end = 1


def file_output(tree, folder):
    node = tree.nodes.new("CompositorNodeOutputFile")
    if hasattr(node, "directory"):
        node.directory = str(folder)
        node.file_output_items.new("RGBA", "Image")
    else:
        node.base_path = str(folder)
    picture = tree.nodes.new("CompositorNodeRGB")
    tree.links.new(picture.outputs[0], node.inputs[0])
    return node


@pytest.mark.parametrize("suffix", [".jpg", ".tif", ".exr"])
def test_formats_that_tell_nothing_are_whole_while_there_is_room(
    cube_scene, tmp_path, monkeypatch, full, suffix
):
    """A JPEG on a full disk is no success; an OpenEXR file that is whole is one."""
    formats = {".jpg": "JPEG", ".tif": "TIFF", ".exr": "OPEN_EXR"}
    use_format(cube_scene, formats[suffix])
    cube_scene.render.engine = "BLENDER_WORKBENCH"
    cube_scene.render.filepath = str(tmp_path / "out_#")
    path = tmp_path / f"out_{cube_scene.frame_current}{suffix}"
    bpy.data.images.new("picture", 8, 8).save_render(str(path), scene=cube_scene)
    monkeypatch.setattr(output, "bpy", SimpleNamespace(app=_PROGRAM, path=bpy.path))
    check_saved(cube_scene)
    full.add(tmp_path)
    if suffix == ".exr":
        check_saved(cube_scene)
    else:
        with pytest.raises(OSError, match="the disk is full"):
            check_saved(cube_scene)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_movie_on_a_full_disk_is_a_failure(cube_scene, tmp_path, monkeypatch, full):
    """Blender ends with 0; the job's process does not."""
    ended = []
    monkeypatch.setattr(job, "is_farm_job", lambda: True)
    monkeypatch.setattr(job, "end_with_failure", lambda _temporary, unless=None: ended.append(1))
    use_movie(cube_scene, tmp_path, 32)
    bpy.ops.render.render(animation=True)
    begun = len(ended)  # asked at the start of any movie
    full.add(tmp_path)
    bpy.ops.render.render(animation=True)
    assert (begun, len(ended)) == (1, 3)
    assert f"{tmp_path}: the disk is full" in job.RenderJob.get().unsaved


def test_strips_of_scenes_leave_the_picture_asked(cube_scene, tmp_path, monkeypatch):
    """A strip's render is a job of its own, which ends before the picture is saved."""
    asked = []
    monkeypatch.setattr(job, "check_saved", lambda scene: asked.append(scene.name))
    use_format(cube_scene, "PNG")
    cube_scene.render.filepath = str(tmp_path / "out")
    shown = cube_scene.copy()
    editor = cube_scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    strips.new_scene("Strip", shown, 1, cube_scene.frame_current)
    bpy.ops.render.render(write_still=True)
    assert asked == [cube_scene.name]


@pytest.mark.parametrize(("size", "fails"), [(60000, True), (32, False)])
def test_movie_that_cannot_begin_is_a_failure(cube_scene, tmp_path, monkeypatch, size, fails):
    """Blender ends with 0, and tells no handler of an end: a bake after it is no render."""
    asked = []
    monkeypatch.setattr(job, "is_farm_job", lambda: True)
    monkeypatch.setattr(
        job, "end_with_failure", lambda _temporary, unless=None: asked.append(unless)
    )
    use_movie(cube_scene, tmp_path, size)
    try:
        bpy.ops.render.render(animation=True)
    except RuntimeError as error:
        assert fails and "60000" in str(error)
    (unless,) = asked
    assert unless() != fails
    assert job.RenderJob.rendering == ""


def test_folders_of_file_outputs_are_those_that_are_written(cube_scene, tmp_path):
    """In groups too; muted nodes, nodes without a link and templates are left out."""
    tree = empty_tree(cube_scene)
    file_output(tree, tmp_path / "a")
    file_output(tree, tmp_path / "muted").mute = True
    file_output(tree, tmp_path / "loose")
    tree.links.remove(tree.links[-1])
    file_output(tree, tmp_path / "template_####")
    group = bpy.data.node_groups.new("Group", "CompositorNodeTree")
    file_output(group, tmp_path / "b")
    tree.nodes.new("CompositorNodeGroup").node_tree = group
    assert output_folders(cube_scene) == [tmp_path / "a", tmp_path / "b"]
    cube_scene.render.use_compositing = False
    assert output_folders(cube_scene) == []


def test_file_output_on_a_full_disk_is_a_failure(cube_scene, tmp_path, monkeypatch, full):
    """Though the picture itself is whole, on another one; folders that are not there are not."""
    tree = empty_tree(cube_scene)
    file_output(tree, tmp_path / "passes")
    file_output(tree, tmp_path / "nothing")
    (tmp_path / "passes").mkdir()
    monkeypatch.setattr(output, "bpy", SimpleNamespace(app=_PROGRAM, path=bpy.path))
    cube_scene.render.filepath = str(tmp_path / "out")
    check_saved(cube_scene)
    full |= {tmp_path / "passes", tmp_path / "nothing"}
    with pytest.raises(OSError, match="passes: the disk is full"):
        check_saved(cube_scene)


@pytest.mark.parametrize("fails", [True, False])
def test_farm_job_fails_where_a_scene_of_its_compositor_does(
    cube_scene, tmp_path, monkeypatch, fails
):
    """Blender saves the picture without that scene, and ends with 0."""
    ended = []
    monkeypatch.setattr(engine, "is_farm_job", lambda: True)
    monkeypatch.setattr(engine, "end_with_failure", lambda temporary: ended.append(temporary))
    use_format(cube_scene, "PNG")
    cube_scene.render.filepath = str(tmp_path / "out")
    other = cube_scene.copy()
    tree = empty_tree(cube_scene)
    for shown in (cube_scene, other):
        tree.nodes.new("CompositorNodeRLayers").scene = shown
    file_output(tree, tmp_path)
    cube_scene.render.engine = "BLENDER_WORKBENCH"
    cube_scene.view_layers[0].use = False  # of it nothing is rendered: that may need a GPU
    if fails:
        for thing in list(other.collection.all_objects):
            if thing.type == "MESH":
                broken = bpy.data.materials.new("Broken")
                broken.iwis.use_measured = True
                thing.data.materials.clear()
                thing.data.materials.append(broken)
    with contextlib.suppress(RuntimeError):
        bpy.ops.render.render()
    assert ended == [bpy.app.tempdir] * fails

"""A picture that is cut short is found where the disk ran full, and only there."""

import shutil
import sys
from types import SimpleNamespace

import bpy
import pytest

from iwis.iwis_addon import output
from iwis.iwis_addon.output import check_room, check_written
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


_PROGRAM = SimpleNamespace(background=True, module=False)

both = pytest.mark.parametrize(
    "picture", [(".png", "PNG"), (".exr", "OPEN_EXR")], indirect=True, ids=["png", "exr"]
)


@pytest.fixture
def full_disk(monkeypatch):
    """Every disk says that nothing is free."""
    real = shutil.disk_usage
    monkeypatch.setattr(shutil, "disk_usage", lambda path: real(path)._replace(free=0))


@both
def test_whole_file_on_a_full_disk_is_fine(picture, full_disk):
    """It just had room."""
    check_written(picture)


@both
def test_cut_file_on_a_full_disk_is_named(picture, full_disk):
    """What Blender calls a success is none."""
    picture.write_bytes(picture.read_bytes()[:-100])
    with pytest.raises(OSError, match=rf"{picture.name}: .*disk is full"):
        check_written(picture)


@both
def test_nothing_is_read_back_while_there_is_room(picture):
    """A disk with room cuts nothing: no time is spent on it."""
    picture.write_bytes(picture.read_bytes()[:-100])
    check_written(picture)


@pytest.mark.parametrize("words", [("-f", "1"), ("--render-anim",), ("-P", "script.py")])
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

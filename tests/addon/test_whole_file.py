"""iwis_addon/whole_file.py: each file that Blender writes is whole, and each part of it is not."""

import os

import bpy
import numpy as np
import pytest

from iwis.core.exr import write_exr_layers
from iwis.iwis_addon.whole_file import is_cut_short
from support.iwis_render import use_format

_SETTINGS = bpy.types.ImageFormatSettings.bl_rna.properties
# All but those of images alone: Blender does not render to them.
CODECS = {item.identifier for item in _SETTINGS["exr_codec"].enum_items} - {"B44", "B44A"}


@pytest.fixture(params=[*sorted(CODECS), "multilayer", "our own"])
def exr(request, cube_scene, tmp_path):
    """67 lines, so that the last chunk is not full."""
    path = tmp_path / "out.exr"
    if request.param == "our own":
        layers = {"Combined": np.random.default_rng(1).random((67, 40, 4), np.float32)}
        write_exr_layers(path, layers, view_layer="")
        return path
    render = cube_scene.render
    render.resolution_x, render.resolution_y = 40, 67
    render.filepath = str(path)
    use_format(cube_scene, "OPEN_EXR_MULTILAYER" if request.param == "multilayer" else "OPEN_EXR")
    if request.param in CODECS:
        render.image_settings.exr_codec = request.param
    cube_scene.iwis.max_samples = 8
    bpy.ops.render.render(write_still=True)
    return path


def test_exr_is_whole_only_as_a_whole(exr):
    """Without its last byte, half of it, its header, or anything at all it is not."""
    assert not is_cut_short(exr)
    data = exr.read_bytes()
    for length in (len(data) - 1, len(data) // 2, 100, 6, 0):
        exr.write_bytes(data[:length])
        assert is_cut_short(exr), length


def test_exr_whose_list_was_not_filled_in_is_cut_short(tmp_path):
    """So it is where writing failed in the middle, and other files were removed meanwhile."""
    path = tmp_path / "out.exr"
    write_exr_layers(path, {"Combined": np.ones((5, 4, 4), np.float32)}, view_layer="")
    data = path.read_bytes()
    # One chunk, which begins where the list of chunks ends.
    (at,) = (k for k in range(len(data) - 8) if data[k : k + 8] == (k + 8).to_bytes(8, "little"))
    path.write_bytes(data[:at] + bytes(8) + data[at + 8 :])
    assert is_cut_short(path)


def test_other_files_are_taken_as_they_are(tmp_path):
    """Nothing is said of a format that does not tell where it ends, but that it is not empty."""
    path = tmp_path / "out.jpg"
    path.write_bytes(b"\xff\xd8")
    assert not is_cut_short(path)
    path.write_bytes(b"")
    assert is_cut_short(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has none in folders")
def test_pipes_are_not_read(tmp_path):
    """Who opens one waits for what is written next."""
    os.mkfifo(tmp_path / "out.png")
    assert not is_cut_short(tmp_path / "out.png")

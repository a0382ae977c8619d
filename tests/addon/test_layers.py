"""OpenEXR files with layers: what cannot be shown is said; parity/layered_cases.py has the rest."""

import sys

import bpy
import numpy as np
import OpenEXR
import pytest

from iwis.iwis_addon.export.images.image import ImageError, read_texels
from iwis.iwis_addon.export.images.layers import plain_file
from iwis.iwis_addon.exr_process import write_picture
from support.layered import write_layers

_LAYERS = {"V.Combined": "RGBA", "V.Depth": "Z"}


@pytest.fixture
def path(tmp_path):
    """A file with layers."""
    write_layers(tmp_path / "layers.exr", _LAYERS)
    return str(tmp_path / "layers.exr")


@pytest.mark.parametrize("inside_blender", [False, True])
def test_picture_is_made_beside_or_inside_blender(path, tmp_path, inside_blender):
    """The process of its own, for a Blender program, writes the same file as the direct way."""
    target = str(tmp_path / "plain.exr")
    assert write_picture(path, target, [], False, inside_blender)
    assert not write_picture(path, target, ["Depth"], False, inside_blender)
    planes = write_layers(path, _LAYERS)
    with OpenEXR.File(target, separate_channels=True) as file:
        np.testing.assert_array_equal(file.channels()["G"].pixels, planes["V.Depth.Z"])


@pytest.mark.parametrize("inside_blender", [False, True])
def test_file_that_is_damaged_is_named(path, tmp_path, inside_blender):
    with open(path, "r+b") as file:
        file.truncate(900)
    with pytest.raises(OSError, match=r"layers\.exr: the file is damaged"):
        write_picture(path, str(tmp_path / "plain.exr"), [], False, inside_blender)


def test_files_in_the_temporary_folder_are_gone_afterwards(path, scene, tmp_path, monkeypatch):
    """Of what is packed, too; and no data-block stays."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    image = bpy.data.images.load(path)
    image.pack()
    assert read_texels(image).rgb.shape == (12, 16, 3)
    assert not list((tmp_path / "temporary").iterdir())
    assert list(bpy.data.images) == [image]


def test_missing_package_is_told(path, scene, monkeypatch):
    """One line with the image's name, and what to do."""
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(ImageError, match=r"'layers\.exr' has layers.* OpenEXR .* install it"):
        read_texels(bpy.data.images.load(path))


def test_what_holds_no_picture_is_told(scene, tmp_path):
    """As above."""
    path = str(tmp_path / "ids.exr")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"V.id.X": np.ones((4, 4), np.uint32)}).write(path)
    image = bpy.data.images.load(path)
    with pytest.raises(ImageError, match=r"'ids\.exr' .*ids\.exr: its first .* save it as plain"):
        read_texels(image)
    image.pack()
    with pytest.raises(ImageError, match=r"'ids\.exr' .*\(its packed file: its first layer holds"):
        read_texels(image)


def test_damage_that_blender_lets_pass_is_told(path, scene):
    """A file that loses its end after Blender has seen its layers."""
    image = bpy.data.images.load(path)
    assert tuple(image.size) == (0, 0) and image.type == "MULTILAYER"
    with open(path, "r+b") as file:
        file.truncate(900)
    with (
        pytest.raises(ValueError, match=r"'layers\.exr' has layers, and .* damaged"),
        plain_file(image, path),
    ):
        pass


def test_layers_that_change_on_disk_are_read_again(path, scene):
    image = bpy.data.images.load(path)
    before = read_texels(image).rgb
    planes = write_layers(path, _LAYERS, seed=5, width=20)
    after = read_texels(image).rgb
    assert before.shape == (12, 16, 3) and after.shape == (12, 20, 3)
    np.testing.assert_array_equal(after[::-1, :, 0], planes["V.Combined.R"])

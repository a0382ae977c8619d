"""Tiles of UDIM images: packed into the .blend they pass through the temporary folder; missing."""

import shutil
import tempfile

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.images.image import ImageError
from iwis.iwis_addon.export.shaders.program_images import ImageStore


@pytest.fixture
def tiled(scene, tmp_path, rng):
    """Two tiles in files: (image, bytes (2, h, w, 4), from the bottom)."""
    folder = tmp_path / "tiles"
    folder.mkdir()
    texels = rng.integers(0, 256, (2, 4, 8, 4), np.uint8)
    texels[..., 3] = 255
    for number, tile in zip((1001, 1002), texels, strict=True):
        made = bpy.data.images.new("tile", 8, 4)
        made.pixels.foreach_set((tile / np.float32(255.0)).astype(np.float32).ravel())
        made.filepath_raw, made.file_format = str(folder / f"t.{number}.png"), "PNG"
        made.save()
    image = bpy.data.images.load(str(folder / "t.1001.png"))
    image.source, image.filepath_raw = "TILED", str(folder / "t.<UDIM>.png")
    image.tiles.new(1002)
    return image, texels


@pytest.fixture
def packed(tiled, tmp_path):
    """The same, packed; their files are gone."""
    tiled[0].pack()
    shutil.rmtree(tmp_path / "tiles")
    return tiled


def test_tiles_are_read_and_leave_nothing(packed, monkeypatch, tmp_path):
    """The bytes, and an empty temporary folder afterwards."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    image, texels = packed
    before = len(bpy.data.images)
    tiles = ImageStore().tiles(image, None)
    assert tiles.encoded
    for column in range(2):
        np.testing.assert_array_equal(tiles.tiles[column, 0], texels[column])
    assert not list(tmp_path.iterdir()) and len(bpy.data.images) == before


def test_tiles_in_files_need_no_temporary_folder(tiled, monkeypatch, tmp_path):
    """They are read where they are."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    image, texels = tiled
    np.testing.assert_array_equal(ImageStore().tiles(image, None).tiles[1, 0], texels[1])


def test_temporary_folder_that_cannot_be_written_is_told(packed, monkeypatch, tmp_path):
    """By an error that names the image and what to do: the export warns, and shows pink."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    image, _ = packed
    with pytest.raises(ImageError, match=rf"{image.name!r}.*temporary folder.*make room"):
        ImageStore().tiles(image, None)


@pytest.mark.parametrize("content", [None, b"", b"damaged"])
def test_tile_that_cannot_be_read_leaves_the_others(tiled, tmp_path, content):
    """No file, an empty one, a damaged one: the rest is there, and a line tells which is not."""
    image, texels = tiled
    file = tmp_path / "tiles" / "t.1001.png"
    if content is None:
        file.unlink()
    else:
        file.write_bytes(content)
    store = ImageStore()
    tiles = store.tiles(image, None).tiles
    assert list(tiles) == [(1, 0)]
    np.testing.assert_array_equal(tiles[1, 0], texels[1])
    (why,) = store.left_out(image)
    assert f"{image.name!r}: tile 1001" in why and str(file) in why


def test_image_without_any_tile_is_told(tiled, tmp_path):
    """By an error, of the first tile, as of any image without a file."""
    shutil.rmtree(tmp_path / "tiles")
    store = ImageStore()
    with pytest.raises(ImageError, match=r"tile 1001: there is no file"):
        store.tiles(tiled[0], None)

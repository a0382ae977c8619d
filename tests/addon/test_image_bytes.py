"""Images of bytes are read as bytes: the very ones that their scene-linear texels stand for."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.images.image import Room, bytes_of, texels_of
from iwis.iwis_addon.export.shaders.program_images import ImageStore


def save_png(folder, name="t.png", width=9):
    """A file of texels, 7 rows, whose colors and alphas are all kinds of bytes."""
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (7, width, 4)) / np.float32(255.0)
    pixels[0, 0], pixels[0, 1] = 0.0, 1.0
    made = bpy.data.images.new("made", width, 7, alpha=True)
    made.pixels.foreach_set(pixels.astype(np.float32).ravel())
    made.filepath_raw, made.file_format = str(folder / name), "PNG"
    made.save()
    bpy.data.images.remove(made)
    return str(folder / name)


def encoded(linear):
    """Bytes of linear values in sRGB."""
    curve = np.where(
        linear <= 0.0031308, linear * 12.92, 1.055 * linear.astype(np.float64) ** (1 / 2.4) - 0.055
    )
    return np.rint(curve * 255.0)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("space", ["sRGB", "Non-Color"])
def test_bytes_are_those_of_the_linear_texels(tmp_path, space, mode, packed):
    """Alpha is multiplied in as in the texels of worlds, which tests hold to Cycles'."""
    image = bpy.data.images.load(save_png(tmp_path))
    image.colorspace_settings.name, image.alpha_mode = space, mode
    if packed:
        image.pack()
    rgb = texels_of(image).rgb
    expected = np.rint(rgb * 255.0) if space == "Non-Color" else encoded(rgb)
    np.testing.assert_array_equal(bytes_of(image, Room())[..., :3], expected)
    bpy.data.images.remove(image)


def test_other_spaces_are_no_bytes(tmp_path):
    """Cycles interpolates these when they are scene-linear."""
    image = bpy.data.images.load(save_png(tmp_path))
    image.colorspace_settings.name = "Linear Rec.709"
    assert bytes_of(image, Room()) is None
    tiles = ImageStore().tiles(image, None)
    assert tiles.tiles[0, 0].dtype == np.float32 and not tiles.encoded
    bpy.data.images.remove(image)


@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Linear Rec.709"])
def test_blender_keeps_no_copy_that_it_did_not_have(tmp_path, space):
    """Without a window: 16 MB an image of 2048 x 2048 texels."""
    image = bpy.data.images.load(save_png(tmp_path))
    image.colorspace_settings.name = space
    ImageStore().tiles(image, None)
    assert not image.has_data
    bpy.data.images.remove(image)


def test_an_image_survives_the_next_one(tmp_path):
    """They are read through the same memory."""
    images = [bpy.data.images.load(save_png(tmp_path, f"{k}.png", k)) for k in (9, 5)]
    store = ImageStore()
    first = store.tiles(images[0], None).tiles[0, 0]
    before = first.copy()
    store.tiles(images[1], None)
    np.testing.assert_array_equal(first, before)
    for image in images:
        bpy.data.images.remove(image)

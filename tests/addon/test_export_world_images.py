"""Files, colour spaces and alpha give the same radiance as in Cycles."""

import bpy
import numpy as np
import pytest

from support.world_render import (
    RELATIVE,
    assert_as_cycles,
    cycles_background,
    exported,
    looked_up,
    new_image,
    new_world,
    save_image,
    some_texels,
    textured_world,
)


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


@pytest.mark.parametrize("packed", [False, True], ids=["file", "packed"])
@pytest.mark.parametrize(
    "name, file_format, depth",
    [
        ("map8.png", "PNG", "8"),
        ("map16.png", "PNG", "16"),
        ("half.exr", "OPEN_EXR", "16"),
        ("float.exr", "OPEN_EXR", "32"),
        ("map.hdr", "HDR", "32"),
        ("map.jpg", "JPEG", "8"),
    ],
)
def test_files(scene, tree, texels, tmp_path, name, file_format, depth, packed):
    image = save_image(texels, tmp_path / name, file_format, depth)
    if packed:
        image.pack()
    textured_world(tree, image)
    # sRGB multiplies a contrast by 2.4 at most.
    assert_as_cycles(scene, tmp_path, relative=2.4 * RELATIVE)


@pytest.mark.parametrize("is_float", [False, True], ids=["byte", "float"])
@pytest.mark.parametrize(
    "space, slope",
    [
        ("sRGB", 2.4),
        ("Non-Color", 1.0),
        ("Linear Rec.709", 1.0),
        ("Linear Rec.2020", 1.0),
        ("ACEScg", 1.0),
        ("Filmic sRGB", 3.0),
        ("AgX Log", 17.3),  # 25 stops, ln 2 each
    ],
)
def test_colour_spaces(scene, tree, texels, tmp_path, space, slope, is_float):
    """Of files, in the spaces that Blender converts.

    Cycles converts bytes as half floats: 2^-11 before and after, the former times the relative
    change of the result for a change of the number, ``slope``.
    """
    numbers = 0.4 + 0.1 * texels if space == "AgX Log" else texels  # stays positive, contrast 1:2
    numbers = 0.6 * numbers + 0.4 * numbers.mean(axis=2, keepdims=True)  # likewise
    path, kind = (("map.exr", "OPEN_EXR"), ("map.png", "PNG"))[not is_float]
    image = save_image(numbers, tmp_path / path, kind, "32" if is_float else "8")
    image.colorspace_settings.name = space
    textured_world(tree, image)
    half = 0.0 if is_float else (1.0 + slope) * 2**-11
    assert_as_cycles(scene, tmp_path, max(1.0, min(slope, 3.0)) * RELATIVE, half)


@pytest.mark.parametrize("alpha_mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("space", ["sRGB", "Linear Rec.709", "Non-Color", "Display P3"])
@pytest.mark.parametrize("packed", [False, True], ids=["file", "packed"])
@pytest.mark.parametrize(
    ("name", "file_format", "depth"),
    [
        ("a8.png", "PNG", "8"),
        ("a16.png", "PNG", "16"),
        ("a.exr", "OPEN_EXR", "32"),
        ("a8.tif", "TIFF", "8"),
        ("a16.tif", "TIFF", "16"),
    ],
)
def test_alpha(
    scene, tree, texels, tmp_path, rng, name, file_format, depth, packed, space, alpha_mode
):
    """Of files whose alpha is straight or not, by their nature and by what the user says."""
    alpha = rng.uniform(0.7, 1.0, (8, 16)).astype(np.float32)
    # Bytes of a straight file are divided by alpha: they must not exceed 1.
    image = save_image(0.7 * texels, tmp_path / name, file_format, depth, alpha)
    image.colorspace_settings.name, image.alpha_mode = space, alpha_mode
    if packed:
        image.pack()
    textured_world(tree, image)
    # Multiplied bytes are whole numbers again, in Cycles' file reader rounded another way: 1/64 of
    # the smallest, .25 (sRGB: of a slope of 2.4).
    slope = 2.4 if space in ("sRGB", "Display P3") else 1.0
    quantised = slope * 2**-6 if depth == "8" else 0.0
    if space == "Display P3" and depth != "32":
        quantised += (1.0 + slope) * 2**-11  # converted as half floats, as above
    assert_as_cycles(scene, tmp_path, slope * 2.0 * RELATIVE, quantised)


@pytest.mark.parametrize("packed", [False, True])
def test_image_sequence_frame(scene, tree, texels, tmp_path, packed):
    """The frame of the node's image user, not the first file, nor what is packed of it."""
    for frame in (1, 2, 3):
        bpy.data.images.remove(save_image(texels * frame / 3, tmp_path / f"s{frame}.png", "PNG"))
    image = bpy.data.images.load(str(tmp_path / "s1.png"))
    if packed:
        image.pack()
    image.source = "SEQUENCE"
    texture, _ = textured_world(tree, image)
    user = texture.image_user
    user.frame_duration, user.frame_start, user.use_auto_refresh = 3, 1, True
    scene.frame_set(3)
    assert_as_cycles(scene, tmp_path, relative=2.4 * RELATIVE)
    environment, _ = exported()
    assert environment.radiance.max() > 0.9


def test_missing_images_are_pink_as_in_cycles(scene, tree, tmp_path):
    """No image chosen, no file, an empty file, a damaged file, a damaged packed file."""
    texture, _ = textured_world(tree, None)
    empty, damaged = tmp_path / "empty.exr", tmp_path / "damaged.png"
    empty.touch()
    damaged.write_bytes(b"\x89PNG\r\n\x1a\n and then something else")
    packed = bpy.data.images.load(str(damaged))
    packed.pack()
    for path in (None, tmp_path / "gone.hdr", empty, damaged, packed):
        if isinstance(path, bpy.types.Image):
            texture.image = path
        elif path is not None:
            texture.image = bpy.data.images.new("map", 4, 4)
            texture.image.source, texture.image.filepath = "FILE", str(path)
        environment, warnings = exported()
        np.testing.assert_array_equal(looked_up(environment)[:9], np.tile([1, 0, 1], (9, 1)))
        np.testing.assert_allclose(cycles_background(scene, tmp_path)[:, 1], 0.0)
        assert len(warnings) == 1 and texture.name in warnings[0]
        if path is not None and path is not packed:
            assert str(path) in warnings[0]


def test_bad_radiance_is_counted_and_mended(tree, texels):
    texels[0, 0] = np.nan
    texels[1, 1, 0] = -3.0
    texels[2, 2, 1] = np.inf
    texels[3, 3] = -np.inf
    texels[3, 4] = -3e38
    texels[4, 4] = 7.0
    textured_world(tree, new_image(texels))
    environment, warnings = exported()
    radiance = environment.radiance
    assert radiance[0, 0].max() == radiance[3, 3:5].max() == 0.0 and radiance[1, 1, 0] == -3.0
    assert radiance[2, 2, 1] == 7.0
    np.testing.assert_array_equal(radiance[5:], texels[5:])
    expected = (
        ("1 of 128 texels", "are NaN"),
        ("2 of", "are too far below 0 to render: 0 instead"),
        ("1 of", "are infinite: 7 instead"),
    )
    assert len(warnings) == 3
    for text, words in zip(warnings, expected, strict=True):
        assert '"World"' in text and '"map"' in text and all(word in text for word in words)


@pytest.mark.parametrize("interpolation", ["Linear", "Cubic"])
def test_negative_texels_stay(scene, tree, texels, tmp_path, interpolation):
    """Filters leave them round the sun of many a map, with a tenth of its light and more."""
    texels[2, 3] = -5.0
    textured_world(tree, new_image(texels), interpolation=interpolation)
    environment, warnings = exported()
    assert environment.radiance.min() < -1.0 and warnings == []
    ours, cycles = looked_up(environment), cycles_background(scene, tmp_path)
    assert cycles.min() < -1.0
    np.testing.assert_allclose(ours, cycles, atol=0.05)  # 1 % of the texel: its slopes, as above


def test_map_of_nothing_good(tree, texels):
    """Black, or where infinity is all there is as bright as a half float can be; no crash."""
    for value, mended in ((np.nan, 0.0), (-np.inf, 0.0), (np.inf, 65504.0)):
        textured_world(tree, new_image(np.full_like(texels, value)))
        environment, warnings = exported()
        assert (environment.radiance == mended).all()
        assert len(warnings) == 1 and "128 of 128 texels" in warnings[0]
        tree.nodes.clear()

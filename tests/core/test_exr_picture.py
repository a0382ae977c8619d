"""core/exr_picture.py: which channels are shown of a file with layers, as measured in Cycles."""

import numpy as np
import OpenEXR
import pytest

from iwis.core.exr import read_exr
from iwis.core.exr_picture import write_picture
from support.layered import write_layers, write_parts

_PASSES = ["Combined", "Depth", "Normal"]
_ZERO = "zero"


def _shown(path, folder, passes=(), straight=False):
    """(channels of the plain file, rows as in the source; whether they are colors)."""
    colors = write_picture(str(path), str(folder / "plain.exr"), passes, straight)
    channels = read_exr(folder / "plain.exr")
    return [channels[letter][::-1] for letter in "RGBA" if letter in channels], colors


def _assert_shows(path, folder, planes, expected, passes=(), colors=True):
    shown, are_colors = _shown(path, folder, passes)
    planes = {**planes, _ZERO: np.zeros_like(next(iter(planes.values())))}
    assert are_colors == colors and len(shown) == len(expected)
    for plane, name in zip(shown, expected, strict=True):
        np.testing.assert_array_equal(plane, planes[name], err_msg=name)


def _names(layer, letters):
    return [f"{layer}.{letter}" for letter in letters]


@pytest.mark.parametrize(
    ("layers", "expected"),
    [
        ({"V.Combined": "RGBA", "V.Depth": "Z"}, _names("V.Combined", "RGBA")),
        ({"B.Combined": "RGBA", "A.Combined": "RGBA"}, _names("A.Combined", "RGBA")),
        ({"V.AO": "RGB", "V.Combined": "RGBA"}, [*_names("V.AO", "RGB"), "V.Combined.R"]),
        ({"b": "RGB", "a": "RGB"}, [*_names("a", "RGB"), "b.R"]),
        ({"": "RGBA", "diffuse": "RGB"}, [*"RGBA"]),
        ({"V.Depth": "Z", "V.Normal": "XYZ"}, ["V.Depth.Z", *_names("V.Normal", "XYZ")]),
        ({"V.UV": "UVA"}, _names("V.UV", "AUV")),
        ({"V.Depth": "Z"}, ["V.Depth.Z"] * 3),
        ({"a": "RG"}, ["a.R"] * 3 + ["a.G"]),
        ({"d": ["blue", "green", "red"]}, ["d.red", "d.green", "d.blue"]),
    ],
)
def test_file_shows_its_first_four_channels(tmp_path, layers, expected):
    """By layer, then as RGBA, whatever they are; one is grey, of two the second is alpha."""
    planes = write_layers(tmp_path / "a.exr", layers)
    _assert_shows(tmp_path / "a.exr", tmp_path, planes, expected)


@pytest.mark.parametrize(
    ("layers", "expected", "colors"),
    [
        ({"V.AO": "RGB", "V.Combined": "RGBA"}, _names("V.Combined", "RGBA"), True),
        ({"B.Combined": "RGBA", "A.Normal": "XYZ"}, _names("A.Normal", "XYZ"), False),
        ({"V.Normal": "XYZ", "V.Depth": "Z"}, ["V.Depth.Z"] * 3, False),
        ({"V.b": "RGB", "V.a": "RGB"}, _names("V.a", "RGB"), True),
        ({"": "RGBA", "a": "RGB"}, [*"RGBA"], True),
        ({"x": "rgba"}, _names("x", "rgba"), True),
        ({"d": ["blue", "green", "red"]}, ["d.red", "d.green", "d.blue"], True),
        ({"V.UV": "UVA"}, _names("V.UV", "UVA"), False),
        ({"a": "ZRGBA"}, _names("a", "ABGR"), False),
        ({"a": "RG"}, ["a.G", "a.R", _ZERO], False),
    ],
)
def test_packed_shows_the_first_pass(tmp_path, layers, expected, colors):
    """Of the first layer, in Blender's order of passes; colors are RGB and RGBA alone."""
    planes = write_layers(tmp_path / "a.exr", layers)
    _assert_shows(tmp_path / "a.exr", tmp_path, planes, expected, _PASSES, colors)


@pytest.mark.parametrize("passes", [(), _PASSES])
def test_stereo_shows_the_left_eye(tmp_path, passes):
    """Names of channels, or of parts, tell of views."""
    layers = {"V.Combined.right": "RGBA", "V.Combined.left": "RGBA"}
    planes = write_layers(tmp_path / "a.exr", layers, views=True)
    _assert_shows(tmp_path / "a.exr", tmp_path, planes, _names("V.Combined.left", "RGBA"), passes)
    views = {"left": "RGBA", "right": "RGBA"}
    first, _ = write_parts(tmp_path / "b.exr", views, views=["left", "right"])
    _assert_shows(tmp_path / "b.exr", tmp_path, first, [*"RGBA"], passes)


def test_parts(tmp_path):
    """A file shows the first, packed the first pass: the names of parts are those of passes."""
    parts = {"V.Depth": "Z", "V.Combined": "RGBA"}
    depth, combined = write_parts(tmp_path / "a.exr", parts)
    _assert_shows(tmp_path / "a.exr", tmp_path, depth, "ZZZ")
    _assert_shows(tmp_path / "a.exr", tmp_path, combined, "RGBA", _PASSES)
    _, left = write_parts(
        tmp_path / "b.exr", {"right": "RGB", "left": "RGB"}, views=["right", "left"]
    )
    _assert_shows(tmp_path / "b.exr", tmp_path, left, "RGB", _PASSES)


@pytest.mark.parametrize(
    ("layers", "passes", "multiplied"),
    [
        ({"V.Combined": "RGBA"}, (), True),
        ({"V.Combined": "RGBA", "V.Depth": "Z"}, (), False),
        ({"V.Combined": "RGBA", "V.Depth": "Z"}, _PASSES, True),
        ({"V.Combined": "RGB"}, (), False),
    ],
)
def test_straight_alpha_is_multiplied_in_as_blender_does(tmp_path, layers, passes, multiplied):
    planes = write_layers(tmp_path / "a.exr", layers)
    shown, _ = _shown(tmp_path / "a.exr", tmp_path, passes, straight=True)
    factor = planes["V.Combined.A"] if multiplied else np.float32(1.0)
    for plane, letter in zip(shown, "RGB", strict=False):
        np.testing.assert_array_equal(plane, planes[f"V.Combined.{letter}"] * factor)


def test_what_is_no_picture_is_named(tmp_path):
    """Whole numbers, and files that are damaged."""
    path = tmp_path / "a.exr"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"V.id.X": np.ones((4, 4), np.uint32)}).write(str(path))
    with pytest.raises(OSError, match=r"a\.exr: its first layer holds whole numbers"):
        _shown(path, tmp_path)
    write_layers(path, {"V.Combined": "RGBA", "V.Depth": "Z"})
    path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(OSError, match=r"a\.exr: the file is damaged"):
        _shown(path, tmp_path)

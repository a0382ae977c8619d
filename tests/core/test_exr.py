"""core/exr.py: what is written is read back; what cannot be read or written says so."""

import os
import subprocess
import sys
import types

import numpy as np
import OpenEXR
import pytest

from iwis.core import exr


def _picture(rng, channels=4, height=7, width=11):
    return rng.standard_normal((height, width, channels)).astype(np.float32)


def test_layers_come_back_bit_for_bit(tmp_path, rng):
    """Every layer, negative and huge values and all, is the same after writing and reading."""
    layers = {
        "Combined": _picture(rng) * np.float32(1e6),
        "Position": _picture(rng, 3),
        "Depth": np.full((7, 11, 1), 1e10, np.float32),
        "IWIS Samples": _picture(rng, 1),
    }
    exr.write_exr_layers(tmp_path / "a.exr", layers)
    back = exr.read_exr_layers(tmp_path / "a.exr")
    assert set(back) == {f"ViewLayer.{name}" for name in layers}
    for name, pixels in layers.items():
        np.testing.assert_array_equal(back[f"ViewLayer.{name}"], pixels)
        assert back[f"ViewLayer.{name}"].dtype == np.float32


def test_infinity_and_nan_survive(tmp_path):
    """The file is an honest witness of a broken picture."""
    pixels = np.array([[np.nan, np.inf, -np.inf]], np.float32)
    exr.write_exr_layers(tmp_path / "a.exr", {"IWIS Error": pixels})
    np.testing.assert_array_equal(
        exr.read_exr(tmp_path / "a.exr")["ViewLayer.IWIS Error.V"], pixels
    )


def test_channel_names_are_blenders(tmp_path, rng):
    """Letters as Blender 4.5 and 5.2 write them, by the pass's name and the number of channels."""
    layers = {
        "Combined": _picture(rng),
        "Depth": _picture(rng, 1),
        "Normal": _picture(rng, 3),
        "Object Index": _picture(rng, 1),
        "Diffuse Direct": _picture(rng, 3),
        "IWIS Samples": _picture(rng, 1),
    }
    exr.write_exr_layers(tmp_path / "a.exr", layers, view_layer="Hero")
    expected = {"Combined": "RGBA", "Depth": "Z", "Normal": "XYZ", "Object Index": "X"}
    expected |= {"Diffuse Direct": "RGB", "IWIS Samples": "V"}
    names = {f"Hero.{layer}.{letter}" for layer, word in expected.items() for letter in word}
    assert set(exr.read_exr(tmp_path / "a.exr")) == names


def test_letters_and_no_view_layer_can_be_asked_for(tmp_path, rng):
    """A caller's letters win, and an empty view layer leaves the first word out."""
    path = tmp_path / "a.exr"
    exr.write_exr_layers(path, {"UV": _picture(rng, 3)}, view_layer="", letters={"UV": "UVA"})
    assert set(exr.read_exr(path)) == {"UV.U", "UV.V", "UV.A"}


def test_row_zero_is_the_bottom(tmp_path):
    """Our row 0 is the last scanline of the file, which OpenEXR counts from the top."""
    pixels = np.arange(6, dtype=np.float32).reshape(3, 2)
    exr.write_exr_layers(tmp_path / "a.exr", {"Depth": pixels})
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        from_top = file.channels()["ViewLayer.Depth.Z"].pixels.copy()
    np.testing.assert_array_equal(from_top, pixels[::-1])


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.uint32])
def test_reads_half_float_and_uint(tmp_path, dtype):
    """All three pixel types of the format arrive as float32."""
    pixels = np.array([[0, 1, 2], [3, 4, 2048]], dtype)
    OpenEXR.File({}, {"Y": pixels}).write(str(tmp_path / "a.exr"))
    back = exr.read_exr(tmp_path / "a.exr")["Y"]
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, pixels[::-1].astype(np.float32))


def test_reads_an_image_without_layers(tmp_path, rng):
    """An HDRI as it is downloaded: channels R, G, B, grouped or not, are the layer ''."""
    rgb = _picture(rng, 3)
    OpenEXR.File({}, {"RGB": rgb[::-1].copy()}).write(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(exr.read_exr_layers(tmp_path / "a.exr")[""], rgb)


def test_reads_one_part_a_pass(tmp_path, rng):
    """Blender 5's files: parts are merged, each channel under its full name."""
    combined, samples = _picture(rng), _picture(rng, 1)[..., 0]
    parts = [
        OpenEXR.Part({}, {"ViewLayer.Combined": combined[::-1].copy()}, "ViewLayer.Combined"),
        OpenEXR.Part(
            {}, {"ViewLayer.IWIS Samples.V": samples[::-1].copy()}, "ViewLayer.IWIS Samples"
        ),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    layers = exr.read_exr_layers(tmp_path / "a.exr")
    np.testing.assert_array_equal(layers["ViewLayer.Combined"], combined)
    np.testing.assert_array_equal(layers["ViewLayer.IWIS Samples"][..., 0], samples)


def test_parts_that_share_channel_names_stay_apart(tmp_path, rng):
    """Parts 'left' and 'right', both with R, G, B, do not overwrite each other."""
    left, right = _picture(rng, 3), _picture(rng, 3)
    parts = [
        OpenEXR.Part({}, {"RGB": left[::-1].copy()}, "left"),
        OpenEXR.Part({}, {"RGB": right[::-1].copy()}, "right"),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    layers = exr.read_exr_layers(tmp_path / "a.exr")
    np.testing.assert_array_equal(layers["left"], left)
    np.testing.assert_array_equal(layers["right"], right)


def _whole_file(tmp_path) -> bytes:
    # Whole numbers compress: a chunk of noise is stored as it is, and no byte of it could be wrong.
    pixels = np.arange(64 * 64 * 4, dtype=np.float32).reshape(64, 64, 4) % 251
    exr.write_exr_layers(tmp_path / "whole.exr", {"Combined": pixels})
    return (tmp_path / "whole.exr").read_bytes()


@pytest.mark.parametrize(
    ("cut", "reason"),
    [
        (lambda data: b"", "the file is empty"),
        (lambda data: b"#?RADIANCE\n" * 9, "is not an OpenEXR file"),
        (lambda data: data[:4], "the file is damaged"),
        (lambda data: data[:300], "the file is damaged"),
        (lambda data: data[:-1000], "the file is damaged"),
        (lambda data: data[:1500] + bytes(1000) + data[2500:], "the file is damaged"),
    ],
    ids=["empty", "radiance", "magic_only", "header", "pixels_cut", "pixels_zeroed"],
)
def test_bad_file_is_one_clear_oserror(tmp_path, cut, reason):
    """The message names the file and what is wrong with it."""
    path = tmp_path / "bad.exr"
    path.write_bytes(cut(_whole_file(tmp_path)))
    with pytest.raises(OSError, match=rf"bad\.exr: {reason}"):
        exr.read_exr(path)


def test_missing_file_and_folder_say_so(tmp_path):
    """Neither becomes the library's 'unable to open'."""
    with pytest.raises(FileNotFoundError, match=r"no\.exr: there is no such file"):
        exr.read_exr(tmp_path / "no.exr")
    with pytest.raises(OSError, match="is not a file"):
        exr.read_exr(tmp_path)


def test_write_into_missing_folder_names_the_path(tmp_path, rng):
    """OSError with the path that was asked for, not with the temporary one."""
    with pytest.raises(OSError, match=r"no/a\.exr: cannot be written: No such file or directory$"):
        exr.write_exr_layers(tmp_path / "no" / "a.exr", {"Combined": _picture(rng)})


_FULL_DISK = """
import resource, signal, sys
import numpy as np
from iwis.core import exr
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))  # a write beyond fails like a full disk
try:
    noise = np.random.default_rng(1).random((400, 400, 4), np.float32)
    exr.write_exr_layers(sys.argv[1], {"Combined": noise})
except OSError as error:
    sys.exit(f"OSError: {error}")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no file size limits on Windows")
def test_write_that_runs_out_of_room_keeps_the_old_file(tmp_path, rng):
    """A full disk gives an OSError with the path; the old file and no temporary file remain."""
    path = tmp_path / "a.exr"
    old = _picture(rng)
    exr.write_exr_layers(path, {"Combined": old})
    script = [sys.executable, "-c", _FULL_DISK, str(path)]
    child = subprocess.run(script, capture_output=True, text=True, timeout=120, check=False)
    assert child.returncode == 1
    assert f"OSError: {path}: cannot be written: " in child.stderr
    np.testing.assert_array_equal(exr.read_exr_layers(path)["ViewLayer.Combined"], old)
    assert os.listdir(tmp_path) == ["a.exr"]


def test_writing_replaces_the_old_file(tmp_path, rng):
    """The second picture is what is read, and no temporary file is left."""
    for pixels in (_picture(rng), _picture(rng)):
        exr.write_exr_layers(tmp_path / "a.exr", {"Combined": pixels})
    layers = exr.read_exr_layers(tmp_path / "a.exr")
    np.testing.assert_array_equal(layers["ViewLayer.Combined"], pixels)
    assert os.listdir(tmp_path) == ["a.exr"]


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        ({}, "no layer"),
        ({"A": np.zeros((2, 2, 4)), "B": np.zeros((2, 3, 1))}, "layer B: is"),
        ({"A": np.zeros((2, 2, 2))}, "layer A: 2 channels"),
        ({"A": np.zeros((0, 2, 3))}, "layer A: expected"),
        ({"A": np.zeros(3)}, "layer A: expected"),
    ],
    ids=["none", "sizes_differ", "two_channels", "no_rows", "one_axis"],
)
def test_layers_that_make_no_picture_are_refused(tmp_path, layers, message):
    """ValueError names the layer; no file appears."""
    with pytest.raises(ValueError, match=message):
        exr.write_exr_layers(tmp_path / "a.exr", layers)
    assert os.listdir(tmp_path) == []


def test_refused_inside_a_blender_program(tmp_path, monkeypatch, rng):
    """With the bpy of a Blender program (not the module) it is not loaded, and why is said."""
    blender = types.SimpleNamespace(app=types.SimpleNamespace(module=False))
    monkeypatch.setitem(sys.modules, "bpy", blender)
    with pytest.raises(RuntimeError, match="must not be loaded into Blender's own process"):
        exr.write_exr_layers(tmp_path / "a.exr", {"Combined": _picture(rng)})


def test_import_does_not_load_openexr():
    """core.exr can be imported inside Blender: the package is loaded by the functions only."""
    code = "import sys, iwis.core.exr; sys.exit('OpenEXR' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 0

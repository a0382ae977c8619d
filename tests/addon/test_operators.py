"""The buttons: what they leave on disk."""

import bpy
import numpy as np
import OpenEXR
import pytest

from iwis.iwis_addon.exr_process import write_exr
from iwis.operators.clear_cache import clear_cache


@pytest.mark.slow
def test_bake_tables_keeps_what_a_paper_render_needs(cube_scene, tmp_path, monkeypatch):
    """After baking, a render in mode Paper writes no table of its own."""
    monkeypatch.setenv("IWIS_CACHE_DIR", str(tmp_path))
    assert bpy.ops.iwis.bake_tables() == {"FINISHED"}
    baked = {path: path.stat().st_mtime_ns for path in (tmp_path / "tables").iterdir()}
    assert baked
    cube_scene.iwis.estimator = "PAPER"
    cube_scene.render.filepath = str(tmp_path / "a.png")
    bpy.ops.render.render(write_still=True)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "tables").iterdir()} == baked


def test_bake_tables_says_what_is_missing(scene):
    """A scene without a camera cannot be exported; the operator fails with that text."""
    with pytest.raises(RuntimeError, match="camera"):
        bpy.ops.iwis.bake_tables()


def test_clear_cache_removes_only_what_is_ours(tmp_path):
    """Files below tables/ and numba/ go; their folders, and a user's own files, stay."""
    for name in ("tables/a.npz", "numba/key/b.nbi", "thesis.odt"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"12345")
    assert clear_cache([tmp_path, tmp_path / "missing"]) == (2, 10)
    assert (tmp_path / "thesis.odt").exists() and (tmp_path / "numba" / "key").is_dir()
    assert clear_cache([tmp_path]) == (0, 0)


@pytest.mark.parametrize("inside_blender", [False, True])
def test_film_is_written_beside_or_inside_blender(tmp_path, inside_blender):
    """The process of its own, for a Blender program, writes the same file as the direct way."""
    from iwis.core.exr import read_exr_layers

    path = tmp_path / "film.exr"
    layers = {"A.Depth": np.arange(6, dtype=np.float32).reshape(2, 3, 1)}
    write_exr(str(path), layers, {"A.Depth": "Z"}, inside_blender, "lin_ap1_scene")
    read = read_exr_layers(path)
    with OpenEXR.File(str(path)) as file:
        assert file.header()["colorInteropID"] == "lin_ap1_scene"
    assert list(read) == ["A.Depth"]
    assert (read["A.Depth"] == layers["A.Depth"]).all()


@pytest.mark.parametrize("inside_blender", [False, True])
def test_film_that_cannot_be_written_is_named(tmp_path, inside_blender):
    """Either way an OSError names the file."""
    path = tmp_path / "no" / "film.exr"
    with pytest.raises(OSError, match=r"film\.exr"):
        write_exr(str(path), {"A": np.ones((2, 2, 1), np.float32)}, {"A": "X"}, inside_blender)


# Of Blender's own, which shows neither.
_UNSEEN = {"rna_type", "remove_name", "remove_active", "filter_glob"}


def test_all_that_a_button_asks_has_a_tooltip(scene):
    """Of the button itself, and of each number and choice in its dialog."""
    missing = []
    for name in dir(bpy.ops.iwis):
        operator = getattr(bpy.ops.iwis, name).get_rna_type()
        asked = [each for each in operator.properties if each.identifier not in _UNSEEN]
        missing += [f"{name}.{each.identifier}" for each in asked if not each.description]
        missing += [] if operator.description else [name]
    assert not missing

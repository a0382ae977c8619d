"""paper_tables.py: which tables a scene needs; built, kept, read back, or done without."""

import os
import shutil

import numpy as np
import pytest

from iwis.core.light.environment import make_lookup
from iwis.core.paper_mode import paper_tables
from iwis.core.paper_mode.paper_tables import N_PARTS, TableBuilder
from iwis.core.paper_mode.tables import SLICES
from iwis.core.scene import BECKMANN
from iwis.core.settings import RenderSettings
from iwis.core.wavelets.haar_forest import build_forest
from support.scenes import (
    black,
    camera_above,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_materials,
    make_picture,
    make_scene,
    principled,
)

LOOKUP = make_lookup(gradient_world())


def _tables(builder, folder, *materials, told=None, coefficients=0.02):
    settings = RenderSettings(cache_dir=str(folder), coefficients=coefficients)
    progress = (lambda fraction, text: told.append((fraction, text))) if told is not None else None
    extra = {} if progress is None else {"progress": progress}
    return builder.tables(LOOKUP, make_materials(*materials), settings, 1, **extra)


def _assert_same(a, b):
    for one, other in ((a.light, b.light), (a.brdf, b.brdf)):
        for name in one._fields:
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    np.testing.assert_array_equal(a.first_slice, b.first_slice)
    np.testing.assert_array_equal(a.frames, b.frames)


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """(folder, tables) of a diffuse and a glossy material, built once."""
    folder = tmp_path_factory.mktemp("filled")
    return folder, _tables(TableBuilder(), folder, diffuse(), glossy(0.3))


def test_tables_from_disk_equal_those_that_were_built(filled):
    """Another process would read: the same arrays, and nothing is built."""
    folder, built = filled
    told = []
    _assert_same(_tables(TableBuilder(), folder, diffuse(), glossy(0.3), told=told), built)
    assert told == []


def test_progress_names_what_is_built(filled, tmp_path):
    """The user sees why a first render takes seconds."""
    shutil.copytree(filled[0], tmp_path, dirs_exist_ok=True)
    told = []
    _tables(TableBuilder(), tmp_path, diffuse(), glossy(0.45), told=told)
    assert {text for _, text in told} == {"Building BRDF table, alpha 0.45"}
    assert told[-1][0] == 1.0


def test_a_builder_keeps_its_tables_in_memory(filled, monkeypatch):
    """The next frame reads no file; other materials drop what is not needed any more."""
    folder, _ = filled
    builder = TableBuilder()
    first = _tables(builder, folder, diffuse(), glossy(0.3))
    monkeypatch.setattr(np, "load", None)
    again = _tables(builder, folder, diffuse(), glossy(0.3))
    assert again.brdf is first.brdf and again.light is first.light
    fewer = _tables(builder, folder, diffuse())
    assert len(fewer.brdf.root) == 1 and fewer.light is first.light


@pytest.mark.parametrize(
    ("material", "parts"),
    [
        (diffuse(), [0]),
        (black(), [0]),
        (glossy(0.3), [0, 1]),
        (principled(roughness=0.5), [0, 1, 2]),
        (principled(metallic=1.0, roughness=0.5), [0, 1, 3]),
        (
            principled(metallic=1.0, roughness=0.5, specular_tint=(0.5, 0.5, 0.5)),
            [0, 1, 3, 4],
        ),
        (principled(metallic=0.5, roughness=0.5, ior=1.0), [0, 1, 3]),
    ],
    ids=["diffuse", "black", "glossy", "plastic", "metal", "tinted metal", "no coat"],
)
def test_materials_get_the_curves_they_have(material, parts, table_dir):
    """Lambert for all; plain, dielectric, Schlick and edge curves where the lobe has them."""
    tables = _tables(TableBuilder(), table_dir, material)
    assert np.flatnonzero(tables.first_slice[0] >= 0).tolist() == parts
    assert tables.first_slice.shape == (1, N_PARTS)
    assert len(tables.brdf.root) == 1 + SLICES * (len(parts) - 1)


def test_colours_share_tables(table_dir):
    """Ten colours of one roughness are one table; another width or distribution is another."""
    colours = [glossy(0.3, (0.1 * k, 0.5, 1.0)) for k in range(10)]
    tables = _tables(TableBuilder(), table_dir, *colours)
    assert len(tables.brdf.root) == 1 + SLICES
    assert (tables.first_slice[:, 1] == 1).all()
    three = [glossy(0.3), glossy(0.5), glossy(0.3, distribution=BECKMANN)]
    assert len(_tables(TableBuilder(), table_dir, *three).brdf.root) == 1 + 3 * SLICES


@pytest.mark.slow
def test_unwritable_cache_folder_is_a_warning_and_a_picture(tmp_path):
    """A file stands where the folder should be: named once, with what to do; the picture comes."""
    blocked = tmp_path / "cache"
    blocked.write_text("a file")
    scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above(4, 4))
    layers, stats = make_picture(scene, estimator="PAPER", cache_dir=str(blocked), max_samples=8)
    assert layers["combined"][..., :3].min() > 0.0
    assert len(stats.warnings) == 1
    assert str(blocked) in stats.warnings[0] and "Choose another cache folder" in stats.warnings[0]


def test_corrupt_tables_are_built_again(filled, tmp_path):
    """A cut file: the same tables as before, and a whole file afterwards."""
    folder, before = filled
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    (path,) = tmp_path.rglob("lobe-*.npz")
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[:1000])
    _assert_same(_tables(TableBuilder(), tmp_path, diffuse(), glossy(0.3)), before)
    assert path.stat().st_size == size


def test_tables_of_other_light_or_fraction_are_others(tmp_path, monkeypatch):
    """A turned or dimmed world, or another fraction, never reads the old file."""
    small = build_forest(np.ones((1, 3, 4, 4), np.float32), 1.0)
    monkeypatch.setattr(paper_tables, "build_light_table", lambda *_: small)
    turn = np.float32([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]])
    dim = np.float32([0.5, 0.5, 0.5])
    worlds = [gradient_world(), gradient_world(world_to_map=turn), gradient_world(strength=dim)]
    for world in worlds:
        for coefficients in (0.02, 0.03):
            settings = RenderSettings(cache_dir=str(tmp_path), coefficients=coefficients)
            materials = make_materials(diffuse())
            TableBuilder().tables(make_lookup(world), materials, settings, 1)
    assert len(os.listdir(tmp_path / "tables")) == 6

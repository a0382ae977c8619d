"""light_cache.py: trees on disk come back, or are built again; the folder stays small."""

import os
import time

import numpy as np
import pytest

import iwis.core.light.light_cache as light_cache
from iwis.core.light.environment import make_lookup
from iwis.core.light.light_cache import light_key, load_light, save_light
from iwis.core.light.light_tree import build_pyramid
from iwis.core.scene import CLOSEST, EnvironmentMap
from support.scenes import gradient_world


@pytest.fixture(scope="module")
def pyramid():
    """Some tree."""
    return build_pyramid(make_lookup(gradient_world(32)))


def test_trees_come_back_bit_for_bit(tmp_path, pyramid):
    """All fields, with their kinds; nothing else is left in the folder."""
    assert save_light(tmp_path, "world-1.npz", pyramid) is None
    back = load_light(tmp_path, "world-1.npz")
    for name in ("averages", "children"):
        np.testing.assert_array_equal(getattr(back, name), getattr(pyramid, name))
        assert getattr(back, name).dtype == getattr(pyramid, name).dtype
    assert (back.levels, back.deepest) == (pyramid.levels, pyramid.deepest)
    assert type(back.deepest) is type(pyramid.deepest)  # another type would recompile kernels
    assert os.listdir(tmp_path) == ["world-1.npz"]


def test_keys_differ_by_all_that_makes_the_light(rng):
    """One bit of one texel, shape, mapping, strength, interpolation; not the object."""
    texels = rng.random((8, 16, 3), np.float32)
    other = texels.copy()
    other.view(np.uint32)[7, 15, 2] ^= 1
    maps = [
        EnvironmentMap(radiance=texels),
        EnvironmentMap(radiance=other),
        EnvironmentMap(radiance=texels.reshape(16, 8, 3)),
        EnvironmentMap(radiance=texels, world_to_map=np.eye(3, 4, dtype=np.float32)[::-1].copy()),
        EnvironmentMap(radiance=texels, strength=np.float32([1, 1, 2])),
        EnvironmentMap(radiance=texels, interpolation=CLOSEST),
    ]
    keys = [light_key(make_lookup(a)) for a in maps]
    assert len(set(keys)) == len(keys)
    assert light_key(make_lookup(EnvironmentMap(radiance=texels.copy()))) == keys[0]


def test_hashing_can_be_stopped(monkeypatch):
    """progress is told at each part, and what it raises comes through."""
    monkeypatch.setattr(light_cache, "_HASHED_AT_ONCE", 1 << 10)
    lookup, told = make_lookup(gradient_world(32)), []
    light_key(lookup, told.append)
    assert told == sorted(told) and len(told) == 24  # 24 kB

    def stop(fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        light_key(lookup, stop)


@pytest.mark.parametrize("damage", ["cut", "flipped", "other", "beyond", "types"])
def test_damaged_trees_are_built_again_with_one_line(damage, tmp_path, pyramid, caplog):
    """Whatever a file holds, no kernel reads beyond an array."""
    save_light(tmp_path, "world-1.npz", pyramid)
    path = tmp_path / "world-1.npz"
    data = bytearray(path.read_bytes())
    children = pyramid.children.copy()
    children[-1] = len(children) - 3
    if damage == "cut":
        path.write_bytes(data[: len(data) // 2])
    elif damage == "flipped":
        data[len(data) // 3] ^= 255
        path.write_bytes(data)
    elif damage == "other":
        np.savez(path, something=np.ones(3))
    elif damage == "beyond":
        save_light(tmp_path, "world-1.npz", pyramid._replace(children=children))
    else:
        save_light(tmp_path, "world-1.npz", pyramid._replace(children=children.astype(np.int64)))
    assert load_light(tmp_path, "world-1.npz") is None
    assert len(caplog.records) == 1 and "built again" in caplog.text
    assert str(path) in caplog.text


def test_what_is_not_there_is_none(tmp_path, caplog):
    """No line in the log: the first render of a world is nothing to report."""
    assert load_light(tmp_path / "none", "world-1.npz") is None and not caplog.records


def test_a_folder_that_cannot_be_written_is_a_warning(tmp_path, pyramid):
    """A file stands in its place; the text says what to do."""
    (tmp_path / "cache").write_text("a file")
    warning = save_light(tmp_path / "cache", "world-1.npz", pyramid)
    assert f"cache folder {tmp_path / 'cache'}: cannot keep tables" in warning
    assert "Choose another cache folder" in warning


def test_the_least_recently_used_go_first(tmp_path, pyramid, monkeypatch):
    """Room for three: reading one keeps it, tables of other kinds stay, the newest always does."""
    (tmp_path / "light-table.npz").write_bytes(b"x" * 100)
    save_light(tmp_path, "world-0.npz", pyramid)
    size = (tmp_path / "world-0.npz").stat().st_size
    monkeypatch.setattr(light_cache, "MOST_BYTES", 3 * size + 10)
    for k in range(3):
        save_light(tmp_path, f"world-{k}.npz", pyramid)
        os.utime(tmp_path / f"world-{k}.npz", ns=(10**9 * (k + 1),) * 2)
    changed = (tmp_path / "world-0.npz").stat().st_mtime_ns
    assert load_light(tmp_path, "world-0.npz") is not None
    assert (tmp_path / "world-0.npz").stat().st_mtime_ns == changed
    save_light(tmp_path, "world-3.npz", pyramid)
    kept = {"light-table.npz", "world-0.npz", "world-2.npz", "world-3.npz"}
    assert set(os.listdir(tmp_path)) == kept
    monkeypatch.setattr(light_cache, "MOST_BYTES", 10)
    save_light(tmp_path, "world-4.npz", pyramid)
    assert set(os.listdir(tmp_path)) == {"light-table.npz", "world-4.npz"}


def test_what_killed_processes_left_is_removed(tmp_path, pyramid):
    """Not what another one writes at this moment."""
    old, young = tmp_path / "tmpold.part", tmp_path / "tmpyoung.part"
    for path, hours in ((old, 2), (young, 0)):
        path.touch()
        os.utime(path, times=(time.time() - 3600 * hours,) * 2)
    assert save_light(tmp_path, "world-1.npz", pyramid) is None
    assert not old.exists() and young.exists()

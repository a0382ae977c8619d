"""core/wavelets/table_cache.py: tables on disk come back, or say why not."""

import os

import numpy as np
import pytest

from iwis.core.wavelets.haar_forest import HaarForest, build_forest
from iwis.core.wavelets.table_cache import load_table, save_table, table_folder, table_key


@pytest.fixture
def forest(rng):
    """Some slices of a small table."""
    return build_forest(rng.random((3, 2, 8, 8), np.float32), 0.2)


def test_tables_come_back_bit_for_bit(tmp_path, forest):
    """All arrays, with their kinds; the folder is made, and nothing else is left in it."""
    folder = tmp_path / "a" / "b"
    assert save_table(folder, "light-1.npz", forest) is None
    back = load_table(folder, "light-1.npz")
    for name in HaarForest._fields:
        np.testing.assert_array_equal(getattr(back, name), getattr(forest, name))
        assert getattr(back, name).dtype == getattr(forest, name).dtype
    assert os.listdir(folder) == ["light-1.npz"]


def test_a_table_that_is_not_there_is_none(tmp_path):
    """The folder need not exist either; a file may stand in its place."""
    (tmp_path / "file").touch()
    for folder in (tmp_path, tmp_path / "no", tmp_path / "file"):
        assert load_table(folder, "no.npz") is None


@pytest.mark.parametrize("damage", ["empty", "text", "cut", "flipped", "other arrays", "folder"])
def test_damaged_tables_are_none_with_a_log_line(tmp_path, forest, damage, caplog):
    """Whatever is wrong with the file: built again, and the log names it."""
    path = tmp_path / "t.npz"
    save_table(tmp_path, "t.npz", forest)
    data = path.read_bytes()
    if damage == "empty":
        path.write_bytes(b"")
    elif damage == "text":
        path.write_bytes(b"<html>404</html>" * 40)
    elif damage == "cut":
        path.write_bytes(data[: len(data) // 2])
    elif damage == "flipped":
        path.write_bytes(data[:200] + bytes(b ^ 255 for b in data[200:260]) + data[260:])
    elif damage == "other arrays":
        np.savez(path, root=forest.root)
    else:
        path.unlink()
        path.mkdir()
    assert load_table(tmp_path, "t.npz") is None
    assert "t.npz cannot be read and is built again" in caplog.text


def test_unwritable_folder_is_a_warning(tmp_path, forest):
    """A file stands where the folder should be: the text names it and what to do."""
    (tmp_path / "cache").write_text("a file")
    warning = save_table(tmp_path / "cache", "t.npz", forest)
    assert f"cache folder {tmp_path / 'cache'}: cannot keep tables" in warning
    assert "Choose another cache folder" in warning


def test_failed_writes_leave_nothing(tmp_path, forest, monkeypatch):
    """A disk that fills up: no half table, no temporary file."""

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    assert "No space left on device" in save_table(tmp_path, "t.npz", forest)
    assert os.listdir(tmp_path) == []


def test_keys_differ_by_all_they_are_made_of():
    """Kind, each number, each array's values, shape and dtype."""
    a = np.arange(6, dtype=np.float32)
    keys = [
        table_key("light", a, 0.05),
        table_key("lobe", a, 0.05),
        table_key("light", a, 0.02),
        table_key("light", a + 1, 0.05),
        table_key("light", a.reshape(2, 3), 0.05),
        table_key("light", a.view(np.int32), 0.05),
    ]
    assert len(set(keys)) == len(keys)
    assert table_key("light", a.copy(), 0.05) == keys[0]
    assert table_key("light", np.arange(12, dtype=np.float32)[::2] / 2, 0.05) == keys[0]


def test_folder_is_the_users_unless_chosen(tmp_path, monkeypatch):
    """An empty setting means the user's cache folder."""
    monkeypatch.setenv("IWIS_CACHE_DIR", str(tmp_path / "user"))
    assert table_folder("") == tmp_path / "user" / "tables"
    assert table_folder(str(tmp_path / "mine")) == tmp_path / "mine" / "tables"

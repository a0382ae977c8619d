"""core/_kernel_files.py: what a damaged cache of kernels, or a full disk, does to a render."""

import errno
import logging
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numba
import numpy as np
import pytest

from iwis.core import _jit, _kernel_files
from iwis.core._kernel_files import KernelFiles

_DAMAGES = {
    "empty": lambda data: b"",
    "cut": lambda data: data[: len(data) // 2],
    "zeros": lambda data: bytes(len(data)),
    "one bit": lambda data: data[:-100] + bytes([data[-100] ^ 1]) + data[-99:],
}


def _twice(values):
    for k in range(len(values)):
        values[k] *= 2.0


def _compiled():
    """A kernel as a start of Blender finds it: (doubled numbers, whether it was on disk)."""
    made = _jit.kernel(_twice)
    values = np.arange(3.0)
    made(values)
    np.testing.assert_array_equal(values, [0.0, 2.0, 4.0])
    return bool(made.stats.cache_hits)


@pytest.fixture
def folder(monkeypatch, tmp_path):
    """A folder for kernels, with one in it."""
    monkeypatch.setattr(_jit, "_CACHE_DIR", str(tmp_path))
    _kernel_files._tell_once.cache_clear()
    assert not _compiled() and _compiled()
    return tmp_path


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", _DAMAGES)
def test_a_damaged_file_is_compiled_anew(folder, suffix, damage):
    """Once: after that it is whole again. (A bit of an index may be one that says nothing.)"""
    (path,) = folder.rglob(f"*.{suffix}")
    path.write_bytes(_DAMAGES[damage](path.read_bytes()))
    found = _compiled()
    assert not found or (suffix, damage) == ("nbi", "one bit")
    assert _compiled()


def test_a_callback_of_c_is_compiled_anew(folder):
    """The same for what Embree calls."""

    def half(value):
        return value / 2.0

    signature = numba.float64(numba.float64)
    assert _jit.c_callback(signature)(half).cache_hits == 0
    (path,) = folder.rglob("*half*.nbc")
    path.write_bytes(b"")
    assert _jit.c_callback(signature)(half).cache_hits == 0
    again = _jit.c_callback(signature)(half)
    assert again.cache_hits == 1 and again.ctypes(3.0) == 1.5


def test_a_callback_is_compiled_while_other_threads_import_kernels(folder, monkeypatch):
    """It takes seconds, and a window's thread may be among them."""
    found = []

    def enter():
        with _jit._FOLDER_IS_SET:
            found.append(True)

    def compiled(made):
        other = threading.Thread(target=enter, daemon=True)
        other.start()
        other.join(10.0)
        return _kernel_files.compiled(made)

    monkeypatch.setattr(_jit, "compiled", compiled)
    signature = numba.float64(numba.float64)
    assert _jit.c_callback(signature)(lambda value: value + 1.0).ctypes(2.0) == 3.0
    assert found


def test_processes_that_begin_at_once_share_no_file(folder, monkeypatch):
    """Neither has seen what the other lists: each finds its own machine code, or none."""
    files = _jit.kernel(_twice)._cache._cache_file
    real, others_turn = KernelFiles._save_data, [True]

    def save_data(self, name, data):
        if others_turn:
            others_turn.clear()
            self.save("types of the other", "code of the other")
        real(self, name, data)

    with monkeypatch.context() as at_once:
        at_once.setattr(KernelFiles, "_load_index", lambda self: {})
        at_once.setattr(KernelFiles, "_save_data", save_data)
        files.save("types of one", "code of one")
    assert files.load("types of the other") in ("code of the other", None)
    assert files.load("types of one") in ("code of one", None)
    files.save("types of the other", "code of the other")
    assert files.load("types of one") == "code of one"
    assert files.load("types of the other") == "code of the other"


def test_what_is_compiled_again_takes_the_same_file(folder):
    """A file that no index lists any more does not stay beside its like."""
    (index,) = folder.rglob("*.nbi")
    before = list(folder.rglob("*.nbc"))
    index.unlink()
    assert not _compiled() and list(folder.rglob("*.nbc")) == before


def test_a_full_disk_is_told_once_and_no_error(folder, monkeypatch, caplog):
    """Kernels stay in memory."""

    def full(self, path):
        raise OSError(errno.ENOSPC, "No space left on device")

    for path in folder.rglob("*.nb?"):
        path.unlink()
    monkeypatch.setattr(KernelFiles, "_open_for_write", full)
    with caplog.at_level(logging.WARNING):
        assert not _compiled() and not _compiled()
    assert [r.getMessage().count("No space left on device") for r in caplog.records] == [1]
    assert str(folder) in caplog.records[0].getMessage()
    assert not list(Path(folder).rglob("*.nb?"))


_ONE_OF_MANY = """
import sys, time
from pathlib import Path
import numpy as np
from iwis.core.unit_square.halton import halton_table
Path(sys.argv[1], sys.argv[2]).touch()
while not Path(sys.argv[1], "go").exists():
    time.sleep(0.001)
halton_table(2, np.zeros((2, 2)))
print(sum(halton_table.stats.cache_misses.values()))
"""


@pytest.mark.slow
def test_of_processes_that_begin_at_once_one_compiles(tmp_path):
    """The others wait for it, and read what it has kept."""
    environment = os.environ | {"IWIS_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", _ONE_OF_MANY, str(tmp_path)]
    pipe = {"stdout": subprocess.PIPE, "env": environment, "text": True}
    processes = [subprocess.Popen([*command, name], **pipe) for name in "abc"]
    while not all((tmp_path / name).exists() for name in "abc"):
        assert all(process.poll() is None for process in processes)
        time.sleep(0.01)
    (tmp_path / "go").touch()
    assert sorted(process.communicate()[0].strip() for process in processes) == ["0", "0", "1"]


def test_nobody_waits_for_a_turn_for_ever(tmp_path):
    """Nor for one that has ended, nor where there is no folder; and one comes after another."""
    path, order = tmp_path / "a.turn", []

    def second():
        with _kernel_files.turn_of(path):
            order.append("second")

    thread = threading.Thread(target=second)
    with _kernel_files.turn_of(path):
        with _kernel_files.turn_of(path, seconds=0.1):
            order.append("without")
        thread.start()
        time.sleep(0.2)
        order.append("first")
    thread.join()
    assert order == ["without", "first", "second"]
    with _kernel_files.turn_of(tmp_path / "nowhere" / "a.turn"):
        pass

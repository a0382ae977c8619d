"""core/_jit.py: kernels are honest about NaN, and their cache about what it was made from."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import numba
import numpy as np
import pytest

from iwis.core import _jit

_SAYS_FOLDER = "from iwis.core import _jit; print(_jit._CACHE_DIR)"


@_jit.kernel
def _classify(values, out):
    """out: 1 where NaN, 2 where infinite, 3 where 0 is divided by; written."""
    for k in range(len(values)):
        out[k] = 1.0 if np.isnan(values[k]) else 2.0 if np.isinf(values[k]) else 0.0
        if values[k] == np.float32(0.0):
            out[k] = 3.0 if np.isinf(np.float32(1.0) / values[k]) else 4.0


def _cache_dir_of(**environment) -> str:
    """The folder that another process would keep its machine code in."""
    script = [sys.executable, "-c", _SAYS_FOLDER]
    child = subprocess.run(
        script,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return child.stdout.strip()


def test_fast_maths_keeps_nan_and_infinity():
    """isnan, isinf and division by zero mean what they say."""
    out = np.zeros(4, np.float32)
    _classify(np.float32([np.nan, np.inf, 0.0, 1.0]), out)
    assert out.tolist() == [1.0, 2.0, 3.0, 0.0]


def test_cache_folder_is_chosen_by_the_environment(tmp_path):
    """IWIS_CACHE_DIR, for farms; it holds all that can be made again."""
    assert Path(_cache_dir_of(IWIS_CACHE_DIR=str(tmp_path))).parent == tmp_path / "numba"


@pytest.mark.parametrize("name", ["BOUNDSCHECK", "OPT", "SLP_VECTORIZE"])
def test_other_code_is_kept_apart(tmp_path, name):
    """Code with checks, or not optimised, is not what a later start without them finds."""
    folder = {"IWIS_CACHE_DIR": str(tmp_path)}
    one = _cache_dir_of(**folder, **{f"NUMBA_{name}": "1"})
    assert one != _cache_dir_of(**folder, **{f"NUMBA_{name}": "0"})


def test_unwritable_cache_folder_falls_back_to_a_temporary_one(tmp_path):
    """A full or read-only disk costs the time to compile, not the render."""
    blocked = tmp_path / "cache"
    blocked.write_text("a file")
    chosen = Path(_cache_dir_of(IWIS_CACHE_DIR=str(blocked), TMPDIR=str(tmp_path)))
    assert chosen.parent == tmp_path and chosen.is_dir()


def test_user_cache_follows_the_platform(monkeypatch, tmp_path):
    """XDG on Linux when nothing else is said."""
    monkeypatch.delenv("IWIS_CACHE_DIR", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert _jit.user_cache_dir() == tmp_path / "iwis"
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert _jit.user_cache_dir() == tmp_path / "local" / "iwis"
    monkeypatch.setattr(sys, "platform", "darwin")
    assert _jit.user_cache_dir() == Path.home() / "Library" / "Caches" / "iwis"


def test_unwritable_cache_folder_is_told_and_replaced(monkeypatch, tmp_path, caplog):
    """A folder of one's own among the temporary ones; never another user's."""
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("IWIS_CACHE_DIR", str(blocked))
    monkeypatch.setattr(_jit.tempfile, "tempdir", str(tmp_path))
    folder = Path(_jit._writable_cache_dir())
    assert folder.parent == tmp_path and folder.is_dir()
    assert len(caplog.messages) == 1
    assert str(blocked) in caplog.text and str(folder) in caplog.text
    assert _jit._writable_cache_dir() == str(folder)
    real = _jit.os.getuid()
    monkeypatch.setattr(_jit.os, "getuid", lambda: real + 1)
    another = Path(_jit._writable_cache_dir())
    theirs = f"iwis-numba-{real + 1}-{_jit._code_key()}"
    assert another.is_dir() and another.name.startswith("iwis-numba-") and another.name != theirs


def test_threads_that_make_kernels_keep_them_in_the_folder():
    """A thread that is done does not take the folder from one that is not, nor leave it set."""
    before, seen = numba.config.CACHE_DIR, []
    second_began, first_ended = threading.Event(), threading.Event()

    def compile_first(function):
        second.start()
        second_began.wait(0.2)  # it does not begin: it waits for its turn

    def compile_second(function):
        second_began.set()
        first_ended.wait(10)
        seen.append(numba.config.CACHE_DIR)

    second = threading.Thread(target=_jit._kept, args=(compile_second, None))
    _jit._kept(compile_first, None)
    first_ended.set()
    second.join(10)
    assert seen == [_jit._CACHE_DIR]
    assert before == numba.config.CACHE_DIR

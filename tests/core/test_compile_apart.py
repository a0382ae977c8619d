"""The dearest kernel is compiled by a second process, where it is found by this one."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from iwis.core import _jit
from iwis.core.film import Film
from iwis.core.machine import compile_apart
from iwis.core.render import render
from iwis.core.sampling.block_loop import continue_blocks
from iwis.core.sampling.loop_types import loop_signature
from iwis.core.settings import PIXEL_FILTERS, RenderSettings
from iwis.core.tiles.early_kernels import smallest_scene

_GUEST = """
import numba
from iwis.core import _jit
from iwis.core.light import pyramid
from iwis.core.machine import compile_apart
compile_apart._can_run = lambda: True
kernel, signature = pyramid.morton_to_row_column, (numba.int64,)
assert not kernel.is_kept(signature)
compile_apart.begin(kernel, signature, _jit._CACHE_DIR)
assert compile_apart._running
assert compile_apart.wait(lambda: False)
assert kernel.is_kept(signature) and not kernel.overloads
"""


@pytest.fixture
def alone(monkeypatch):
    """No process runs, and none that a test begins stays."""
    running = []
    monkeypatch.setattr(compile_apart, "_running", running)
    yield running
    for process in running:
        process.kill()
        process.wait()
        process.stdin.close()


@pytest.mark.parametrize("pixel_filter", PIXEL_FILTERS)
def test_the_types_are_those_that_renders_have(pixel_filter):
    """With others the second process would compile what nobody asks for."""
    settings = RenderSettings(threads=1, pixel_filter=pixel_filter)
    render(smallest_scene(), settings, Film((0, 0, 1, 1)))
    assert list(continue_blocks.overloads) == [loop_signature()]


def test_what_is_kept_is_not_compiled_again(alone):
    render(smallest_scene(), RenderSettings(threads=1), Film((0, 0, 1, 1)))
    compile_apart.begin(continue_blocks, loop_signature(), _jit._CACHE_DIR)
    assert not alone


class _Kernel:
    """One that is never kept; its process fails, for there is no such module."""

    class py_func:
        __module__ = "iwis.core.missing"
        __name__ = "missing"

    @staticmethod
    def is_kept(_):
        return False


def test_a_process_that_fails_is_forgotten(alone, monkeypatch):
    monkeypatch.setattr(compile_apart, "_can_run", lambda: True)
    compile_apart.begin(_Kernel, (), _jit._CACHE_DIR)
    (process,) = alone
    assert compile_apart.wait(lambda: False) and not alone
    assert process.returncode == 1


def test_a_cancel_ends_the_wait_and_not_the_process(alone, monkeypatch):
    monkeypatch.setattr(compile_apart, "_can_run", lambda: True)
    _sleeper(monkeypatch)
    compile_apart.begin(_Kernel, (), _jit._CACHE_DIR)
    assert not compile_apart.wait(lambda: True)
    assert alone[0].poll() is None


def _sleeper(monkeypatch):
    """A process that would never end, in place of the one that compiles."""
    command = [sys.executable, "-c", "import time; time.sleep(600)"]

    def start(_):
        return subprocess.Popen(command, stdin=subprocess.PIPE)

    monkeypatch.setattr(compile_apart, "_start", start)


def test_one_that_takes_too_long_is_given_up(alone, monkeypatch):
    monkeypatch.setattr(compile_apart, "_can_run", lambda: True)
    monkeypatch.setattr(compile_apart, "_SECONDS", 0.1)
    _sleeper(monkeypatch)
    compile_apart.begin(_Kernel, (), _jit._CACHE_DIR)
    (process,) = alone
    assert compile_apart.wait(lambda: False) and not alone
    assert process.returncode not in (None, 0)


def test_every_thread_that_waits_goes_on(alone, monkeypatch):
    """Workers and the early render wait for the same process; one of them is the first to see."""
    monkeypatch.setattr(compile_apart, "_can_run", lambda: True)
    compile_apart.begin(_Kernel, (), _jit._CACHE_DIR)
    with ThreadPoolExecutor(16) as threads:
        waits = [threads.submit(compile_apart.wait, lambda: False) for _ in range(16)]
    assert all(wait.result() for wait in waits) and not alone


def test_no_second_process_without_a_second_core(alone, monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)
    compile_apart.begin(_Kernel, (), _jit._CACHE_DIR)
    assert not alone


def test_it_ends_with_the_process_that_asked():
    """Its standard input is closed then."""
    ends = "import sys, threading, time\n"
    ends += "from iwis.core.machine.compile_apart import _end_with as end\n"
    ends += "threading.Thread(target=end, args=(sys.stdin.buffer,), daemon=True).start()\n"
    ends += "time.sleep(600)"
    done = subprocess.run([sys.executable, "-c", ends], input=b"", env=_environment(), timeout=100)
    assert done.returncode == 1


def test_this_process_finds_what_the_other_one_compiled(tmp_path):
    """From an empty cache folder to machine code that this one has not compiled."""
    own = _environment() | {"IWIS_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", _GUEST], env=own, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr


def _environment():
    """Modules are found where they are found here."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}

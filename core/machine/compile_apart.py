"""Compiles one kernel in a process of its own, while this one compiles the others.

Python and LLVM compile one function after another, under one lock. At a machine's first render the
loop of mode UNBIASED is more than half of all there is to compile; on a second core it is ready
when the rest is. What was compiled comes by the disk cache that every render uses.

Executed as a file this is the other process. It is told by its standard input what to compile, and
ends when that does: no process is left behind by one that has ended.
"""

from __future__ import annotations

import importlib
import logging
import os
import pickle
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

log = logging.getLogger(__name__)

_POLL_SECONDS = 0.02
# Of a process that takes longer nothing is expected any more: it is compiled here.
_SECONDS = 300.0
_running: list[subprocess.Popen] = []
_waiting: list[int] = []  # threads
_lock = threading.Lock()


def begin(kernel, signature: tuple, folder: str) -> None:
    """Have a kernel compiled for a signature if it is not kept in the cache folder, once.

    signature: of numba's types; folder: that kernels are kept in (_jit.py)
    """
    with _lock:
        if _running or not _can_run() or kernel.is_kept(signature):
            return
        package = __package__.rpartition(".")[0]  # core
        order = {
            "path": list(sys.path),
            "package": package,
            "root": sys.modules[package].__path__[0],  # as it is: kernels are kept by it
            "folder": folder,
            "kernel": (kernel.py_func.__module__, kernel.py_func.__name__),
        }
        try:
            _running.append(_start(pickle.dumps(order) + pickle.dumps(signature)))
        except OSError as error:
            log.debug("no second process: %s", error)


def wait(cancelled) -> bool:
    """Wait until what was begun is ready or has failed; False if cancelled() said so before.

    Also ended by the end of the main thread: Python waits for its threads then.
    """
    end, own = time.monotonic() + _SECONDS, threading.get_ident()
    _waiting.append(own)
    try:
        return _wait_until(end, cancelled)
    finally:
        _waiting.remove(own)


def is_awaited() -> bool:
    """Whether a thread waits for the other process."""
    return bool(_waiting)


def _wait_until(end: float, cancelled) -> bool:
    while running := list(_running):  # a copy: other threads wait too, and forget it
        if running[0].poll() is not None or time.monotonic() > end:
            _forget(running[0])
            break
        if cancelled() or not threading.main_thread().is_alive():
            return False
        time.sleep(_POLL_SECONDS)
    return True


def _forget(process) -> None:
    """Once, whichever thread was the first to see its end."""
    with _lock:
        if process not in _running:
            return
        _running.remove(process)
        process.kill()
        process.wait()
        process.stdin.close()
    if process.returncode:
        log.debug("the second process has ended with code %s", process.returncode)


def _can_run() -> bool:
    """Whether there is a second core, and a Python that can be started."""
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # not on Linux
        cores = os.cpu_count() or 1
    return cores > 1 and Path(sys.executable or "").name.lower().startswith("python")


def _start(order: bytes) -> subprocess.Popen:
    process = subprocess.Popen(
        [sys.executable, "-P", str(Path(__file__).resolve())],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )
    try:
        process.stdin.write(order)
        process.stdin.flush()
    except OSError:
        process.kill()
        process.wait()
        raise
    return process


def _serve(orders) -> int:
    """What the other process does: an exit code. orders: the standard input, binary"""
    order = pickle.load(orders)
    sys.path[:] = order["path"]
    _name_packages(order["package"], order["root"])
    signature = pickle.load(orders)
    threading.Thread(target=_end_with, args=(orders,), daemon=True).start()
    keeps = importlib.import_module(order["package"] + "._jit")
    if order["folder"] != keeps._CACHE_DIR:
        return 1
    module, name = order["kernel"]
    getattr(importlib.import_module(module), name).compile(signature)
    return 0


def _name_packages(package: str, root: str) -> None:
    """Have a package under the name that it has in Blender, without running those that hold it.

    Kernels are kept by their modules' names; the add-on's own __init__ asks for Blender.
    """
    names = package.split(".")
    folder = Path(root)
    for k in range(len(names) - 1, 0, -1):
        folder = folder.parent
        holder = types.ModuleType(".".join(names[:k]))
        holder.__path__ = [str(folder)]
        sys.modules[holder.__name__] = holder


def _end_with(orders) -> None:
    """End when the process that gave the order has: the pipe's other end is closed then."""
    orders.read()
    os._exit(1)


if __name__ == "__main__":
    _code = 1
    try:
        _code = _serve(sys.stdin.buffer)
    finally:  # Python's own end would abort over the thread that still reads
        os._exit(_code)

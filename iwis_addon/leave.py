"""The end of a process in which a render was interrupted, or a picture not saved.

Blender ends with 0 where it has saved half a file; scripts have no say in it. And Python waits for
its last thread: one that compiles for the first time has up to a minute to go. LLVM cannot be told
to stop, and Blender's memory cannot be taken from under it. So the process is ended as a whole.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import shutil
import sys
import threading
import time

_POLL_SECONDS = 0.02
_NAME = "iwis-leave"


def end_without_waiting(temporary: str = "") -> None:
    """Once the main thread has ended, end the process, with code 1, though threads still work.

    temporary: a folder of the process that is to go with it
    """
    if _working():
        _begin(_working, temporary)


def end_with_failure(temporary: str = "", unless=lambda: False) -> None:
    """End the process with code 1, whatever Blender makes of its job; when it ends by itself.

    unless: what says, then, that there was no failure
    """
    _begin(lambda: not unless(), temporary)


def _begin(is_wanted, temporary: str) -> None:
    threading.Thread(target=_end, args=(is_wanted, temporary), name=_NAME).start()


def _end(is_wanted, temporary: str) -> None:
    main = threading.main_thread()
    while main.is_alive():
        time.sleep(_POLL_SECONDS)
    if is_wanted():
        if temporary:
            shutil.rmtree(temporary, ignore_errors=True)
        _flush()
        os._exit(1)


def _working() -> bool:
    """Whether a thread of IWIS is there that Python would wait for."""
    return any(
        thread.name.startswith("iwis-") and thread.name != _NAME and not thread.daemon
        for thread in threading.enumerate()
    )


def _flush() -> None:
    logging.shutdown()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):  # a pipe that nobody reads any more, or no stream
            stream.flush()
    with contextlib.suppress(Exception):  # what Blender has printed lies in the C library
        library = ctypes.cdll.ucrtbase if os.name == "nt" else ctypes.CDLL(None)
        library.fflush(None)

"""The end of a process whose render was interrupted: what is still compiled is not waited for.

Python ends when its last thread does, and a thread that compiles for the first time has up to a
minute to go. LLVM cannot be told to stop, and Blender's memory cannot be taken from under it: so
the process is ended as a whole, with the exit code that Blender would give.
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


def end_without_waiting(temporary: str = "", code: int = 1) -> None:
    """Once the main thread has ended, end the process though threads of IWIS still work.

    temporary: a folder of the process that is to go with it; code: the exit code
    """
    if any(thread.name == _NAME for thread in threading.enumerate()) or not _working():
        return
    threading.Thread(target=_end, args=(temporary, code), name=_NAME).start()


def _end(temporary: str, code: int) -> None:
    main = threading.main_thread()
    while main.is_alive():
        time.sleep(_POLL_SECONDS)
    if _working():
        if temporary:
            shutil.rmtree(temporary, ignore_errors=True)
        _flush()
        os._exit(code)


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

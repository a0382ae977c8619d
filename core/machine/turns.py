"""Turns: how many of a pool's threads run Python and NumPy at a time.

Each call of NumPy and of a kernel lets go of Python's lock and asks for it again. Where two threads
are in such code, every call wakes the other one: 2800 switches for a picture of 320x200, and a
tenth of its time. So a worker takes a turn for its item, and lets others have it while it is in
machine code for long. It holds no other lock where it asks for one.
"""

from __future__ import annotations

import contextlib
import queue
import threading

_here = threading.local()  # .free: the queue that this thread's turn is of, or None


class Turns:
    """The turns of some threads: half as many, so that who is in long NumPy code stops nobody."""

    def __init__(self, threads: int):
        self._free: queue.SimpleQueue = queue.SimpleQueue()
        for _ in range(max(threads // 2, 1)):
            self._free.put(None)

    @contextlib.contextmanager
    def taken(self):
        """Wait for a turn, and keep it but for what runs ``aside``."""
        self._free.get()
        _here.free = self._free
        try:
            yield
        finally:
            _here.free = None
            self._free.put(None)


@contextlib.contextmanager
def aside():
    """Let others have this thread's turn, if it has one: for what runs long without Python.

    Also a decorator: ``@aside()``. Within itself it does nothing.
    """
    free = getattr(_here, "free", None)
    if free is None:
        yield
        return
    _here.free = None
    free.put(None)
    try:
        yield
    finally:
        free.get()
        _here.free = free

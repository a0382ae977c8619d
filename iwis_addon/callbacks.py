"""Which of Blender's threads are in the engine's callbacks now, and the end of all of them.

Blender forgets an engine's class while another thread of its own still renders with it: the job
then never ends. So whoever takes the engine from Blender waits here first.
"""

from __future__ import annotations

import contextlib
import threading
import time

import bpy

from .job import ENGINE, RenderJob

_POLL_SECONDS = 0.01
_AFTERWARDS_SECONDS = 0.2  # for Blender to let go of an engine object whose callback has returned

# Threads in callbacks, one entry a callback.
_inside: list[int] = []


@contextlib.contextmanager
def inside():
    """While a thread of Blender's is in a callback of the engine."""
    here = threading.get_ident()
    _inside.append(here)
    try:
        yield
    finally:
        _inside.remove(here)


def end_all(seconds: float) -> bool:
    """End renders, previews and bakes of other threads as by Esc; False where one still goes on.

    seconds: how long they are waited for at the most; nothing is waited for where there are none
    """
    if not _going_on():
        return True
    was_set = RenderJob.interrupt.is_set()
    RenderJob.interrupt.set()
    deadline = time.monotonic() + seconds
    while (going_on := _going_on()) and time.monotonic() < deadline:
        time.sleep(_POLL_SECONDS)
    time.sleep(_AFTERWARDS_SECONDS)
    if not was_set:
        RenderJob.interrupt.clear()
    return not going_on


def _going_on() -> bool:
    here = threading.get_ident()
    if here in _inside or threading.current_thread() is not threading.main_thread():
        return False  # it would wait for itself
    # Between two frames of an animation no thread is in a callback; in background it is this one.
    return bool(_inside) or (RenderJob.rendering == ENGINE and not bpy.app.background)

"""Which of Blender's threads are in the engine's callbacks now, and the end of all of them.

Blender forgets an engine's class while another thread of its own still renders with it: the job
then never ends. So whoever takes the engine from Blender waits here first. Who renders for a button
asks here, too: Blender ends with a crash where a render begins inside of one of its own jobs.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable

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
    return not _going_on() or _end(_going_on, seconds)


def end_previews(seconds: float = 10.0) -> None:
    """End previews of materials, worlds and lights, before a button sets a scene's engine.

    There Blender waits for its job of previews, and keeps Python, which the job needs to end: with
    any engine that is written in Python it would stand still for ever.
    """
    if _is_running("RENDER_PREVIEW"):
        _end(_others_inside, seconds)


def cannot_render() -> str:
    """Why a button cannot render now, for its tooltip; "" where it can."""
    for job, what in (("RENDER", "render"), ("OBJECT_BAKE", "bake")):
        if _is_running(job):
            return f"A {what} is going on: wait for its end, or press Esc in its window"
    return ""


def _is_running(job: str) -> bool:
    return bpy.app.is_job_running(job)


def _end(going_on: Callable[[], bool], seconds: float) -> bool:
    was_set = RenderJob.interrupt.is_set()
    RenderJob.interrupt.set()
    deadline = time.monotonic() + seconds
    while True:
        while (late := going_on()) and time.monotonic() < deadline:
            time.sleep(_POLL_SECONDS)
        time.sleep(_AFTERWARDS_SECONDS)
        if late or not going_on():  # a job of several previews goes on to the next
            break
    if not was_set:
        RenderJob.interrupt.clear()
    return not late


def _others_inside() -> bool:
    here = threading.get_ident()
    return any(thread != here for thread in _inside)


def _going_on() -> bool:
    here = threading.get_ident()
    if here in _inside or threading.current_thread() is not threading.main_thread():
        return False  # it would wait for itself
    # Between two frames of an animation no thread is in a callback; in background it is this one.
    return bool(_inside) or (RenderJob.rendering == ENGINE and not bpy.app.background)

"""A full disk: Blender writes half a file and calls it a success, so IWIS looks for itself."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from pathlib import Path

import bpy

_PNG_END = b"IEND\xaeB`\x82"
# Pictures of little content compress to this part of their size; less room than that is none.
_LEAST_COMPRESSED = 1 / 16
# Of Blender's command line: it renders and saves.
_RENDERS = {"-f", "--render-frame", "-a", "--render-anim"}


def check_room(scene, channels: int) -> None:
    """Raise OSError where a Blender program is about to save a picture that has no room.

    To be called before Blender saves, which it does by itself in background mode only, where its
    command line says so: what a script does with a picture it knows alone.
    channels: of all passes of the view layer
    """
    if not bpy.app.background or bpy.app.module or not _RENDERS & set(sys.argv):
        return
    path = Path(bpy.path.abspath(scene.render.frame_path(frame=scene.frame_current)))
    folder = next((parent for parent in path.parents if parent.is_dir()), None)
    if folder is None:  # Blender says so
        return
    render = scene.render
    share = (render.resolution_percentage / 100) ** 2
    pixels = render.resolution_x * render.resolution_y * share
    multilayer = render.image_settings.file_format == "OPEN_EXR_MULTILAYER"
    needed = pixels * (4 * channels if multilayer else 3) * _LEAST_COMPRESSED
    usage = shutil.disk_usage(folder)
    free = usage.free
    if usage.total and free < needed:  # file systems in memory, and some of networks, say nothing
        raise OSError(
            f"{folder}: {free} bytes are left on the disk, too few for {path.name}: "
            "free some space or choose another folder"
        )


def check_written(path: Path) -> None:
    """Raise OSError where a saved picture is cut short. Reads it back only when room ran out."""
    if path.stat().st_size == 0:
        raise OSError(f"{path}: nothing could be written: free some space, or choose another disk")
    usage = shutil.disk_usage(path.parent)
    if not usage.total or usage.free > path.stat().st_size:
        return
    problem = _damage_of(path)
    if problem:
        raise OSError(f"{path}: {problem}; the disk is full: free some space, or choose another")


def _damage_of(path: Path) -> str:
    if path.suffix.lower() == ".png":
        complete = path.read_bytes().endswith(_PNG_END)
        return "" if complete else "the file is cut short"
    from ..core.exr import read_exr

    try:
        with _without_stderr():
            read_exr(path)
    except OSError:
        return "the file is cut short"
    return ""


@contextlib.contextmanager
def _without_stderr():
    """Of the whole process: OpenEXR's C library prints a line for each damaged part of a file."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)

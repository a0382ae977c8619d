"""Files of images on disk, which may change while Blender keeps the texels that it has read.

Cycles reads the file for each render, whatever Blender has of it: so does who asks here first.
"""

from __future__ import annotations

import os

import bpy

_known: dict[int, tuple] = {}  # session_uid -> the file that Blender's texels were taken to be of


def file_state(path, library=None) -> tuple | None:
    """What changes when a file does; None without a file."""
    path = bpy.path.abspath(path, library=library)
    try:
        state = os.stat(path)
    except (OSError, ValueError):
        return None
    return path, state.st_ino, state.st_size, state.st_mtime_ns


def is_outdated(image) -> bool:
    """Whether the file has changed since Blender read it, as far as exports have seen.

    False as well for what has no file of its own, for what was painted, and without a file.
    To be asked before anything has Blender read the image: what it has not read is as the file is.
    """
    if image.source != "FILE" or image.packed_file or image.is_dirty:
        return False
    file = file_state(image.filepath, image.library)
    if file is None:
        return False
    if not image.has_data:
        _known[image.session_uid] = file
    return _known.setdefault(image.session_uid, file) != file

"""Materials whose measured BRDF stands in place of their node tree ("IWIS Measured BRDF").

The node trees of these are not read at all: export_materials gets an empty slot for each, whose row
is then written here.
"""

from __future__ import annotations

import os
import threading

import bpy
import numpy as np

from ....core.scene import MEASURED, MaterialParams, MeasuredBrdfs
from ..errors import ExportError

# Files that are kept in memory, 17 MB each: those of one scene, so that a preview and each frame
# need not read them anew.
_KEPT = 16
_files: dict[tuple, MeasuredBrdfs] = {}
_lock = threading.Lock()


def is_measured(material) -> bool:
    """Whether a bpy material (None: an empty slot) shows a measured BRDF in place of its nodes."""
    own = getattr(material, "iwis", None)  # an export without a registered add-on has none
    return own is not None and own.use_measured


def without_measured(materials: list) -> list:
    """The materials with None in place of those that show a measured BRDF."""
    return [None if is_measured(material) else material for material in materials]


def file_of(material) -> str:
    """The absolute path of its file, or ''; a relative one is relative to the material's .blend."""
    path = material.iwis.measured_path
    return os.path.normpath(bpy.path.abspath(path, library=material.library)) if path else ""


def read_file(path: str) -> MeasuredBrdfs:
    """The BRDF of a file, read again only when the file has changed.

    Raises OSError and ValueError with the path and what is wrong.
    """
    from pathlib import Path

    from ....core.bsdf import measured
    from ....core.wavelets.table_cache import table_folder

    try:
        state = os.stat(path)
        key = path, state.st_mtime_ns, state.st_size
    except OSError:
        key = (path,)  # read_measured says what is wrong
    with _lock:
        if key not in _files:
            _files[key] = measured.read_measured(Path(path), table_folder(""))
            while len(_files) > _KEPT:
                del _files[next(iter(_files))]
        return _files[key]


def add_measured(
    materials: list, params: MaterialParams, pass_index: np.ndarray, users: list[list[str]]
) -> tuple[MaterialParams, np.ndarray, MeasuredBrdfs | None]:
    """Write the rows of materials with a measured BRDF; None: there are no such ones.

    materials, users: as for export_materials; params, pass_index: what that made of
    without_measured(materials). Raises ExportError with the material, its objects and the file.
    """
    rows = [k for k, material in enumerate(materials) if is_measured(material)]
    if not rows:
        return params, pass_index, None
    from ....core.bsdf.measured import join_measured

    params = MaterialParams(*(column.copy() for column in params))
    pass_index, brdfs, row_of = pass_index.copy(), [], {}
    for k in rows:
        path = _path_of(materials[k], users[k])
        if path not in row_of:
            row_of[path] = len(brdfs)
            brdfs.append(_read(materials[k], users[k], path))
        params.model[k] = MEASURED
        params.distribution[k] = row_of[path] % 128  # more are refused below
        params.base_color[k] = materials[k].iwis.measured_tint
        params.emission[k] = 0.0
        pass_index[k] = materials[k].pass_index
    try:
        return params, pass_index, join_measured(brdfs)
    except ValueError as error:
        raise ExportError(f"{error}: set some materials back to their nodes") from None


def _name_of(material, users) -> str:
    on = f" of object '{users[0]}'" if users else ""
    return f"material '{material.name}'{on}"


def _path_of(material, users) -> str:
    path = file_of(material)
    if not path:
        what = "has no file: choose a MERL .binary in its panel IWIS Measured BRDF, or turn it off"
        raise ExportError(f"{_name_of(material, users)} {what}")
    return path


def _read(material, users, path) -> MeasuredBrdfs:
    try:
        return read_file(path)
    except (OSError, ValueError) as error:
        what = "choose another in its panel IWIS Measured BRDF, or turn it off"
        raise ExportError(f"{_name_of(material, users)}: {error}; {what}") from None

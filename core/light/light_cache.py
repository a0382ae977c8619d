"""The light's quadtree on disk, found again by the pixels it was made of.

The key is a hash of every byte of the map: two maps that differ in one texel must never share a
tree. SHA-1, for which processors have instructions, takes .21 s for the 400 MB of an 8K map
(BLAKE2b: .43): what nobody would forge needs no more.
"""

from __future__ import annotations

import hashlib
import logging
import os
import time
from pathlib import Path

import numpy as np

from ..wavelets.table_cache import load_arrays, save_arrays
from .environment import EnvironmentLookup
from .pyramid import WHOLE_LEVELS, LightPyramid, level_offset

log = logging.getLogger(__name__)

_FORMAT = 2  # raise it when light_tree.py builds other numbers
_PREFIX = "world-"
# A tree has up to 13 MB: some twenty worlds. The ones not used for longest go first.
MOST_BYTES = 256 << 20
_WRITTEN_SECONDS = 3600.0  # no file takes as long to be written
_HASHED_AT_ONCE = 16 << 20  # bytes; 20 ms, then a cancel is seen


def light_key(lookup: EnvironmentLookup, progress=lambda fraction: None) -> str:
    """A file name for the tree of a map; progress may raise to stop."""
    kind = (_FORMAT, lookup.texels.shape, lookup.projection, lookup.interpolation)
    digest = hashlib.sha1(repr(kind).encode(), usedforsecurity=False)
    digest.update(lookup.matrix.tobytes())
    digest.update(lookup.strength.tobytes())
    texels = memoryview(lookup.texels).cast("B")
    for first in range(0, len(texels), _HASHED_AT_ONCE):
        progress(first / len(texels))
        digest.update(texels[first : first + _HASHED_AT_ONCE])
    return f"{_PREFIX}{digest.hexdigest()}.npz"


def load_light(folder: Path, key: str) -> LightPyramid | None:
    """The tree of that key, or None where there is none that can be used."""
    stored = load_arrays(folder, key, ("averages", "children", "deepest"))
    if stored is None:
        return None
    averages, children, deepest = stored
    whole = level_offset(WHOLE_LEVELS + 1)
    if not (
        averages.dtype == np.float32
        and children.dtype == np.int32
        and whole <= len(averages) == len(children)
        and 0 <= children.min() <= children.max() <= len(averages) - 4
    ):
        log.warning("light %s is not what it should be and is built again", folder / key)
        return None
    _mark_as_used(folder / key)
    return LightPyramid(averages, WHOLE_LEVELS, children, int(deepest))


def save_light(folder: Path, key: str, pyramid: LightPyramid) -> str | None:
    """Keep a tree, whole or not at all, and drop the oldest; returns a warning if that failed."""
    arrays = {
        "averages": pyramid.averages,
        "children": pyramid.children,
        "deepest": np.int32(pyramid.deepest),
    }
    warning = save_arrays(folder, key, arrays)
    if warning is None:
        _drop_oldest(folder, key)
    return warning


def _mark_as_used(path: Path) -> None:
    try:
        os.utime(path, ns=(time.time_ns(), path.stat().st_mtime_ns))
    except OSError:  # a folder that may only be read
        pass


def _drop_parts(folder: Path) -> None:
    """Remove what processes that were killed have begun to write; others' writing goes on."""
    for path in folder.glob("*.part"):
        try:
            if time.time() - path.stat().st_mtime > _WRITTEN_SECONDS:
                path.unlink()
        except OSError:
            continue


def _drop_oldest(folder: Path, keep: str) -> None:
    """Remove trees until MOST_BYTES hold all; another process may do so at the same time."""
    _drop_parts(folder)
    found = []
    for path in folder.glob(f"{_PREFIX}*.npz"):
        try:
            status = path.stat()
        except OSError:
            continue
        found.append((path.name == keep, max(status.st_atime_ns, status.st_mtime_ns), path, status))
    total = sum(status.st_size for _, _, _, status in found)
    for is_kept, _, path, status in sorted(found, key=lambda row: row[:2]):
        if total <= MOST_BYTES or is_kept:
            return
        try:
            path.unlink(missing_ok=True)
        except OSError:
            return
        total -= status.st_size

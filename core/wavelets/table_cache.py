"""Tables on disk: built once for each light and lobe, found again by what they were made of."""

from __future__ import annotations

import hashlib
import logging
import os
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from .._jit import user_cache_dir
from .haar_forest import HaarForest

log = logging.getLogger(__name__)

_FORMAT = 1  # raise it when tables.py builds other numbers


def table_folder(cache_dir: str) -> Path:
    """Where tables are kept: ``cache_dir``, or the user's cache folder where it is empty."""
    return (Path(cache_dir) if cache_dir else user_cache_dir()) / "tables"


def table_key(kind: str, *parts) -> str:
    """A file name for a table: ``kind`` and a hash of all that it was made of (arrays, numbers)."""
    digest = hashlib.sha256(repr((_FORMAT, kind)).encode())
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(repr((part.shape, part.dtype.str)).encode())
            digest.update(np.ascontiguousarray(part).data)
        else:
            digest.update(repr(part).encode())
    return f"{kind}-{digest.hexdigest()[:32]}.npz"


def load_table(folder: Path, key: str) -> HaarForest | None:
    """The table of that key, or None where there is none that can be read."""
    arrays = load_arrays(folder, key, HaarForest._fields)
    return None if arrays is None else HaarForest(*arrays)


def load_arrays(folder: Path, key: str, names) -> list[np.ndarray] | None:
    """The arrays of that key, in the order of their names, or None where they cannot be read."""
    path = folder / key
    try:
        with path.open("rb") as file, np.load(file) as stored:  # np.load(path) leaks what is cut
            return [stored[name] for name in names]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        log.warning("table %s cannot be read and is built again: %s", path, error)
        return None


def save_table(folder: Path, key: str, forest: HaarForest) -> str | None:
    """Keep a table, whole or not at all; returns a warning where that failed."""
    return save_arrays(folder, key, forest._asdict())


def save_arrays(folder: Path, key: str, arrays: dict[str, np.ndarray]) -> str | None:
    """Keep arrays, whole or not at all; returns a warning where that failed."""
    temporary = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(suffix=".part", dir=folder)
        with os.fdopen(handle, "wb") as file:
            np.savez(file, **arrays)
        os.replace(temporary, folder / key)
    except OSError as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        return (
            f"cache folder {folder}: cannot keep tables ({error.strerror or error}): they are "
            "built again at each render. Choose another cache folder"
        )
    return None

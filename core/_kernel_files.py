"""Files of compiled kernels that may be damaged, and disks that may be full.

numba ends with whatever pickle makes of a file that is cut short or overwritten, and so does every
later render; a sum at the end of each file tells of it, and the kernel is compiled anew.

numba numbers the files of a kernel's signatures and processors. Two processes that begin at once,
on machines of a farm that share a folder, take the same number, and one would execute what the
other has compiled for other types or another processor. Here a file is named by what it is for.

Processes that begin at once on an empty folder want the same kernels: one compiles, the others wait
for it and read (turn_of).
"""

from __future__ import annotations

import functools
import hashlib
import logging
import pickle
import time
import zlib
from contextlib import contextmanager, nullcontext
from pathlib import Path

from numba.core import ccallback, sigutils
from numba.core.caching import IndexDataCacheFile
from numba.core.compiler_lock import global_compiler_lock

from ._quicker import quicker

try:
    import fcntl
except ImportError:  # on Windows
    import msvcrt

    fcntl = None

log = logging.getLogger(__name__)

_SUM = 4  # bytes
_NAME = 12  # letters: Windows has paths of 260
# How long to wait for another process, several times what the largest kernel takes; and between
# two looks at whether it is done.
_TURN_SECONDS, _POLL_SECONDS = 120.0, 0.05


class KernelFiles(IndexDataCacheFile):
    """numba's index and data files of one kernel."""

    @classmethod
    def take_over(cls, cache) -> None:
        """Stand in for the files of a numba Cache."""
        own = cls.__new__(cls)
        own.__dict__.update(cache._cache_file.__dict__)
        cache._cache_file = own

    def save(self, key, data):
        """Keep machine code; a disk that is full or gone is told of, once."""
        name = self._name_of(key)
        try:
            self._save_data(name, data)
            listed = self._load_index()  # late: what others have listed meanwhile is kept
            if listed.get(key) != name:
                self._save_index(listed | {key: name})
        except OSError as error:
            _tell_once(self._cache_path, error.strerror or str(error))

    def turn(self):
        """A context: among all processes of this folder, the turn to compile this kernel."""
        return turn_of(Path(self._cache_path, self._index_name).with_suffix(".turn"))

    def _name_of(self, key) -> str:
        digest = hashlib.sha256(self._dump(key)).hexdigest()[:_NAME]
        return f"{self._index_name.removesuffix('.nbi')}.{digest}.nbc"

    def _load_index(self):
        try:
            return super()._load_index()
        except OSError:
            raise
        except Exception:  # pickle raises anything; what it lists is compiled and saved again
            return {}

    def _save_data(self, name, data):
        data = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(data)
            file.write(zlib.crc32(data).to_bytes(_SUM, "little"))

    def _load_data(self, name):
        with open(self._data_path(name), "rb") as file:
            data = file.read()
        if zlib.crc32(data[:-_SUM]).to_bytes(_SUM, "little") != data[-_SUM:]:
            raise OSError(f"{self._data_path(name)} is damaged")  # as if there were none
        return pickle.loads(data[:-_SUM])


@contextmanager
def turn_of(path: Path, seconds: float = _TURN_SECONDS):
    """Hold the lock of a file. Without it where there are no locks, or where ``seconds`` did not
    suffice: then two do the same. The system takes it from a process that ends, however it does.
    """
    try:
        file = open(path, "ab")
    except OSError:
        yield
        return
    with file:
        end = time.monotonic() + seconds
        while not _is_locked(file) and time.monotonic() < end:
            time.sleep(_POLL_SECONDS)
        yield


def _is_locked(file) -> bool:
    """Whether there is nothing to wait for: the lock is this process's, or there are none here."""
    try:
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        pass
    return True


@functools.cache
def _tell_once(folder: str, reason: str) -> None:
    log.warning(
        "IWIS: compiled kernels cannot be kept in %s (%s): the next start compiles them again. "
        "Make room there, or choose another cache folder",
        folder,
        reason,
    )


def is_kept(cache, signature: tuple, codegen) -> bool:
    """Whether there is machine code for a signature in a numba Cache of ours."""
    return cache._index_key(signature, codegen) in cache._cache_file._load_index()


def c_function(function, signature, options: dict) -> ccallback.CFunc:
    """As numba's cfunc(signature, cache=True, **options)(function), which is not compiled yet."""
    made = ccallback.CFunc(function, sigutils.normalize_signature(signature), {}, options)
    made.enable_caching()
    KernelFiles.take_over(made._cache)
    return made


def compiled(made: ccallback.CFunc) -> ccallback.CFunc:
    """The same, compiled or read: of several processes one compiles."""
    codegen = made._targetdescr.target_context.codegen()
    kept = is_kept(made._cache, made._sig, codegen)
    with global_compiler_lock, nullcontext() if kept else made._cache._cache_file.turn(), quicker():
        made.compile()
    return made

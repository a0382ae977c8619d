"""The one decorator of all kernels, and the folder that their machine code is kept in.

numba's own disk cache does not see an edit in a callee of another file, cannot be read under
another package name (``iwis.core`` against ``bl_ext.user_default.iwis.core``), and ignores
variables such as NUMBA_BOUNDSCHECK and NUMBA_OPT. So the folder's name is a hash of all three:
whatever changes, the kernels are compiled anew.
"""

import hashlib
import logging
import os
import sys
import tempfile
import threading
from pathlib import Path

import numba

try:
    from ._kernel_files import c_function, compiled
    from ._parts import KNOWN_NUMBA, new_kernel

    _KNOWN_NUMBA = numba.version_info.short in KNOWN_NUMBA
except (ImportError, AttributeError):  # a numba with other insides: it compiles as it does itself
    _KNOWN_NUMBA = False

log = logging.getLogger(__name__)

# Variables by which numba makes other code, of which its own cache knows nothing.
_CHANGE_CODE = (
    "NUMBA_BOUNDSCHECK",
    "NUMBA_OPT",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_SLP_VECTORIZE",
    "NUMBA_DEBUGINFO",
)

# Relaxed arithmetic that keeps NaN and infinity honest: "nnan" and "ninf" are left out, for
# isfinite() must stay true to its name.
FAST_MATH = frozenset({"nsz", "arcp", "contract", "afn", "reassoc"})


def user_cache_dir() -> Path:
    """The folder for everything that can be made again: IWIS_CACHE_DIR, else the user's cache."""
    chosen = os.environ.get("IWIS_CACHE_DIR")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "iwis"


def _code_key() -> str:
    digest = hashlib.sha256(__name__.encode())
    digest.update(repr((numba.__version__, sys.version_info[:3])).encode())
    digest.update(repr([os.environ.get(name, "") for name in _CHANGE_CODE]).encode())
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:24]


def _writable_cache_dir() -> str:
    """A folder that can be written, else a temporary one: a full disk must not stop a render."""
    folder = user_cache_dir() / "numba" / _code_key()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        unwritable, folder = folder, _private_temporary_dir()
        log.warning(
            "IWIS: cache folder %s cannot be written (%s): compiled kernels are kept in %s. Choose "
            "another cache folder",
            unwritable,
            error.strerror,
            folder,
        )
    return str(folder)


def _private_temporary_dir() -> Path:
    """The same in each run; never one that another user made, who could put code into it."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"iwis-numba-{user}-{_code_key()}"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if hasattr(os, "getuid") and folder.stat().st_uid != user:
        return Path(tempfile.mkdtemp(prefix="iwis-numba-"))
    return folder


_CACHE_DIR = _writable_cache_dir()
_FOLDER_IS_SET = threading.RLock()


def kernel(function=None, *, allocates=False, ordered=False, **options):
    """Compile ``function`` with numba: cached by content, without the GIL, NaN-safe fast maths.

    A kernel may make arrays only where ``allocates`` says so: else numba counts no references,
    which it does atomically and in the innermost loops (a sample took 870 ns so, 330 without).
    ordered: sums are added up as written, so that they do not depend on how work was cut up.
    """
    if function is None:
        return lambda wrapped: kernel(wrapped, allocates=allocates, ordered=ordered, **options)
    options |= {"nogil": True, "error_model": "numpy", "_nrt": allocates}
    options["fastmath"] = set(FAST_MATH - {"reassoc"} if ordered else FAST_MATH)
    if "inline" in options:  # as text: it has no code of its own
        return numba.njit(**options)(function)
    if not _KNOWN_NUMBA:
        return _kept(numba.njit(cache=True, **options), function)
    return _kept(lambda wrapped: new_kernel(wrapped, options), function)


def c_callback(signature, counts_references=True):
    """Compile a function that C code may call, in any thread and without Python: f.address.

    counts_references: of arrays, as a kernel that allocates does
    """
    if not _KNOWN_NUMBA:
        return lambda function: _kept(numba.cfunc(signature, cache=True), function)
    options = {"nopython": True, "_nrt": counts_references}

    def make(function):
        # Compiled when other threads may import kernels again.
        return compiled(_kept(lambda own: c_function(own, signature, options), function))

    return make


def _kept(compile_it, function):
    """compile_it(function), its machine code in our folder.

    numba's setting is the whole process's: threads that import kernels take turns.
    """
    with _FOLDER_IS_SET:
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = _CACHE_DIR
        try:
            return compile_it(function)
        finally:
            numba.config.CACHE_DIR = before

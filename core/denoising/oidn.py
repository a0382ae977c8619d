"""Open Image Denoise's own C interface: the library that Blender brings, asked by ctypes.

Version 2, in main memory, in threads of its own.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable

import numpy as np

# OIDN_DEVICE_TYPE_CPU, OIDN_FORMAT_FLOAT3
_CPU, _FLOAT3 = 1, 3
QUALITIES = {"FAST": 4, "BALANCED": 5, "HIGH": 6}
_OUT_OF_MEMORY, _CANCELLED = 4, 6
# What the library guesses an exposure from: one pixel of 1e20 turns a whole picture grey.
_LARGEST = np.float32(1e8)
_HANDLE, _SIZE = ctypes.c_void_p, ctypes.c_size_t
_Monitor = ctypes.CFUNCTYPE(ctypes.c_bool, _HANDLE, ctypes.c_double)
_SIGNATURES = {
    "oidnNewDevice": (_HANDLE, [ctypes.c_int]),
    "oidnSetDeviceInt": (None, [_HANDLE, ctypes.c_char_p, ctypes.c_int]),
    "oidnSetDeviceBool": (None, [_HANDLE, ctypes.c_char_p, ctypes.c_bool]),
    "oidnCommitDevice": (None, [_HANDLE]),
    "oidnGetDeviceError": (ctypes.c_int, [_HANDLE, ctypes.POINTER(ctypes.c_char_p)]),
    "oidnReleaseDevice": (None, [_HANDLE]),
    "oidnNewFilter": (_HANDLE, [_HANDLE, ctypes.c_char_p]),
    "oidnSetSharedFilterImage": (
        None,
        [_HANDLE, ctypes.c_char_p, _HANDLE, ctypes.c_int, _SIZE, _SIZE, _SIZE, _SIZE, _SIZE],
    ),
    "oidnSetFilterBool": (None, [_HANDLE, ctypes.c_char_p, ctypes.c_bool]),
    "oidnSetFilterInt": (None, [_HANDLE, ctypes.c_char_p, ctypes.c_int]),
    "oidnSetFilterProgressMonitorFunction": (None, [_HANDLE, _Monitor, _HANDLE]),
    "oidnCommitFilter": (None, [_HANDLE]),
    "oidnExecuteFilter": (None, [_HANDLE]),
    "oidnReleaseFilter": (None, [_HANDLE]),
}


@functools.cache
def load_library(path: str) -> ctypes.CDLL:
    """The library at a path, its functions' types set. Raises OSError where it is none of ours."""
    library = ctypes.CDLL(path)
    try:
        for name, (result, arguments) in _SIGNATURES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except AttributeError as error:
        raise OSError(f"{path}: it is not version 2 of Open Image Denoise ({error})") from None
    return library


class Device:
    """Where filters run: threads of their own. To be used in a with statement, by one thread."""

    def __init__(self, path: str, threads: int):
        """path: of the library; threads: at the most. Raises OSError or RuntimeError."""
        self._handle = None
        self._library = load_library(path)
        self._handle = self._library.oidnNewDevice(_CPU)
        self._check()
        self._library.oidnSetDeviceInt(self._handle, b"numThreads", threads)
        # Pinned threads would stay pinned when the picture after this one is sampled.
        self._library.oidnSetDeviceBool(self._handle, b"setAffinity", False)
        self._library.oidnCommitDevice(self._handle)
        self._check()

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        """Free all of it."""
        if self._handle:
            self._library.oidnReleaseDevice(self._handle)
        self._handle = None

    __del__ = close

    def run(
        self,
        images: dict[str, np.ndarray],
        options: dict[str, bool | int],
        told: Callable[[float], bool] = lambda fraction: True,
    ) -> np.ndarray | None:
        """A picture without its noise, float32 (h, w, 3); None where ``told`` ended it.

        images: color, albedo and normal as they are there, float32 (h, w, 3), finite; alone, albedo
            or normal is what is filtered
        options: of the filter RT, by name
        told(fraction) is asked about thirty times a part of the picture whether to go on, by this
        thread or another. Raises MemoryError or RuntimeError.
        """
        library = self._library
        out = np.empty_like(next(iter(images.values())))
        handle = library.oidnNewFilter(self._handle, b"RT")
        monitor = _Monitor(lambda _, fraction: told(fraction))
        try:
            for name, image in {**images, "output": out}.items():
                height, width = image.shape[:2]
                own = image.ctypes.data, _FLOAT3, width, height, 0, 0, 0
                library.oidnSetSharedFilterImage(handle, name.encode(), *own)
            for name, value in options.items():
                kind = "Bool" if isinstance(value, bool) else "Int"
                getattr(library, f"oidnSetFilter{kind}")(handle, name.encode(), value)
            library.oidnSetFilterProgressMonitorFunction(handle, monitor, None)
            library.oidnCommitFilter(handle)
            library.oidnExecuteFilter(handle)
            return out if self._check() else None
        finally:
            library.oidnReleaseFilter(handle)

    def _check(self) -> bool:
        """Whether the last work was finished. Raises what went wrong."""
        text = ctypes.c_char_p()
        code = self._library.oidnGetDeviceError(self._handle, ctypes.byref(text))
        if code == _OUT_OF_MEMORY:
            raise MemoryError("Open Image Denoise: there is not enough memory")
        if code not in (0, _CANCELLED):
            said = (text.value or b"").decode(errors="replace")
            raise RuntimeError(f"Open Image Denoise: error {code} ({said})")
        return code == 0


def as_image(layer: np.ndarray) -> np.ndarray:
    """The first three channels of a layer as Device.run takes them: a copy, within reason."""
    image = np.array(layer[..., :3], np.float32, order="C")
    np.nan_to_num(image, copy=False)
    return np.clip(image, -_LARGEST, _LARGEST, out=image)

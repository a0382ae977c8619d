"""Embree's instances: one hierarchy of parts that stand elsewhere at another time.

Each part has a hierarchy of its own, which all times share; a time adds one over the parts alone.
"""

from __future__ import annotations

import ctypes
import functools

import numpy as np

from .embree import ROBUST, EmbreeScene, load_library
from .embree_rays import Traversal

_INSTANCE, _INSTANCE_ARRAY, _ROWS_OF_3X4 = 121, 122, 0x9134
_INDEX, _UINT, _TRANSFORM = 0, 0x5001, 23  # RTC_BUFFER_TYPE_..., RTC_FORMAT_UINT
_HANDLE = ctypes.c_void_p
_SIGNATURES = {
    "rtcSetGeometryInstancedScene": (None, [_HANDLE] * 2),
    "rtcSetGeometryTransform": (None, [_HANDLE, ctypes.c_uint, ctypes.c_int, _HANDLE]),
    "rtcSetGeometryInstancedScenes": (None, [_HANDLE, _HANDLE, ctypes.c_size_t]),
}


def can_instance() -> bool:
    """Whether Embree's own interface is there."""
    try:
        return _library() is not None
    except OSError:
        return False


@functools.cache
def can_copy() -> bool:
    """Whether this Embree has arrays of instances: 4.3 and later."""
    if not can_instance():
        return False
    library = _library()
    device = library.rtcNewDevice(b"")
    geometry = library.rtcNewGeometry(device, _INSTANCE_ARRAY)
    if geometry:
        library.rtcReleaseGeometry(geometry)
    library.rtcReleaseDevice(device)
    return bool(geometry)


def _library():
    library = load_library()
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class InstanceScene:
    """Parts under a matrix each. Keeps them; lives until it is let go."""

    def __init__(self, parts: list[EmbreeScene], matrices: np.ndarray):
        """parts: committed, of one device; matrices: float32 (n, 3, 4), to world space."""
        self.handle, self._parts = None, parts
        self._library = library = _library()
        self.handle = library.rtcNewScene(parts[0].device)
        library.rtcSetSceneFlags(self.handle, ROBUST)
        for part, matrix in zip(parts, np.ascontiguousarray(matrices, np.float32), strict=True):
            geometry = library.rtcNewGeometry(part.device, _INSTANCE)
            library.rtcSetGeometryInstancedScene(geometry, part.handle)
            library.rtcSetGeometryTransform(geometry, 0, _ROWS_OF_3X4, matrix.ctypes.data)
            library.rtcCommitGeometry(geometry)
            library.rtcAttachGeometry(self.handle, geometry)
            library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self.handle)
        parts[0].check()

    def traversal(self) -> Traversal:
        """See EmbreeScene."""
        found = [part.traversal() for part in dict.fromkeys(self._parts)]
        colored, aside = any(one.colored for one in found), max(one.aside for one in found)
        return found[0]._replace(scene=self.handle, colored=colored, aside=aside)

    def close(self) -> None:
        """Free it; it must not be asked any more."""
        if self.handle:
            self._library.rtcReleaseScene(self.handle)
        self.handle = None

    __del__ = close


class InstanceArray(InstanceScene):
    """Parts that stand in many places, as one geometry of Embree's: 64 bytes each and no time to
    make, where others take 5 us and 350 bytes, but are met sooner by rays."""

    def __init__(self, parts: list[EmbreeScene], part_of: np.ndarray, matrices: np.ndarray):
        """parts: committed, of one device; part_of: uint32 (n,), of each instance; matrices:
        float32 (n, 3, 4), to world space."""
        self.handle, self._parts = None, parts
        self._library = library = _library()
        self._arrays = part_of, matrices  # Embree reads them, and owns nothing
        self.handle = library.rtcNewScene(parts[0].device)
        library.rtcSetSceneFlags(self.handle, ROBUST)
        geometry = library.rtcNewGeometry(parts[0].device, _INSTANCE_ARRAY)
        handles = (_HANDLE * len(parts))(*(part.handle for part in parts))
        library.rtcSetGeometryInstancedScenes(geometry, handles, len(parts))
        for kind, form, array in ((_INDEX, _UINT, part_of), (_TRANSFORM, _ROWS_OF_3X4, matrices)):
            library.rtcSetSharedGeometryBuffer(
                geometry, kind, 0, form, array.ctypes.data, 0, array.strides[0], len(array)
            )
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self.handle, geometry)
        library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self.handle)
        parts[0].check()

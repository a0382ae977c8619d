"""Embree's instances: one hierarchy of parts that stand elsewhere at another time.

Each part has a hierarchy of its own, which all times share; a time adds one over the parts alone.
"""

from __future__ import annotations

import ctypes
import functools
from typing import NamedTuple

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


class InstanceArray(NamedTuple):
    """Parts that stand in many places, as one geometry of Embree's: 64 bytes each and no time to
    make, where others take 5 us and 350 bytes, but are met sooner by rays.

    parts: committed; part_of: uint32 (n,), of each instance; matrices: float32 (n, 3, 4), to world
    space. Embree reads the arrays, and owns nothing.
    """

    parts: list[EmbreeScene]
    part_of: np.ndarray
    matrices: np.ndarray


class InstanceScene:
    """Parts under a matrix each. Keeps them; lives until it is let go."""

    def __init__(
        self, parts: list[EmbreeScene], matrices: np.ndarray, array: InstanceArray | None = None
    ):
        """parts: committed; matrices: float32 (n, 3, 4), to world space; array: further instances,
        whose numbers follow. All of one device; there is at least one part."""
        self.handle, self._array = None, array
        self._parts = list(dict.fromkeys([*parts, *(array.parts if array else ())]))
        self._library = library = _library()
        self.handle = library.rtcNewScene(self._parts[0].device)
        library.rtcSetSceneFlags(self.handle, ROBUST)
        for part, matrix in zip(parts, np.ascontiguousarray(matrices, np.float32), strict=True):
            geometry = library.rtcNewGeometry(part.device, _INSTANCE)
            library.rtcSetGeometryInstancedScene(geometry, part.handle)
            library.rtcSetGeometryTransform(geometry, 0, _ROWS_OF_3X4, matrix.ctypes.data)
            self._attach(geometry)
        if array is not None:
            self._attach(self._geometry_of(array))
        library.rtcCommitScene(self.handle)
        self._parts[0].check()

    def _geometry_of(self, array: InstanceArray):
        library, parts = self._library, array.parts
        geometry = library.rtcNewGeometry(parts[0].device, _INSTANCE_ARRAY)
        handles = (_HANDLE * len(parts))(*(part.handle for part in parts))
        library.rtcSetGeometryInstancedScenes(geometry, handles, len(parts))
        own = (_INDEX, _UINT, array.part_of), (_TRANSFORM, _ROWS_OF_3X4, array.matrices)
        for kind, form, values in own:
            library.rtcSetSharedGeometryBuffer(
                geometry, kind, 0, form, values.ctypes.data, 0, values.strides[0], len(values)
            )
        return geometry

    def _attach(self, geometry) -> None:
        self._library.rtcCommitGeometry(geometry)
        self._library.rtcAttachGeometry(self.handle, geometry)
        self._library.rtcReleaseGeometry(geometry)

    def traversal(self) -> Traversal:
        """See EmbreeScene."""
        found = [part.traversal() for part in self._parts]
        colored, aside = any(one.colored for one in found), max(one.aside for one in found)
        return found[0]._replace(scene=self.handle, colored=colored, aside=aside)

    def close(self) -> None:
        """Free it; it must not be asked any more."""
        if self.handle:
            self._library.rtcReleaseScene(self.handle)
        self.handle = None

    __del__ = close

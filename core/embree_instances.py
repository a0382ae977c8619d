"""Embree's instances: one hierarchy of parts that stand elsewhere at another time.

Each part has a hierarchy of its own, which all times share; a time adds one over the parts alone.
"""

from __future__ import annotations

import ctypes

import numpy as np

from .embree import ROBUST, EmbreeScene, load_library
from .embree_rays import Traversal

_INSTANCE, _ROWS_OF_3X4 = 121, 0x9134
_HANDLE = ctypes.c_void_p
_SIGNATURES = {
    "rtcSetGeometryInstancedScene": (None, [_HANDLE] * 2),
    "rtcSetGeometryTransform": (None, [_HANDLE, ctypes.c_uint, ctypes.c_int, _HANDLE]),
}


def can_instance() -> bool:
    """Whether Embree's own interface is there."""
    try:
        return _library() is not None
    except OSError:
        return False


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
        found = [part.traversal() for part in self._parts]
        colored, aside = any(one.colored for one in found), max(one.aside for one in found)
        return found[0]._replace(scene=self.handle, colored=colored, aside=aside)

    def close(self) -> None:
        """Free it; it must not be asked any more."""
        if self.handle:
            self._library.rtcReleaseScene(self.handle)
        self.handle = None

    __del__ = close

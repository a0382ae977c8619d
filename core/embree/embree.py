"""Embree's own C interface: the hierarchy of a mesh, built so that it can be stopped.

The library is the one in the wheel of embreex, whose Python layer is left out: it holds Python's
lock while it builds, and costs half as much as a ray (docs/decisions/0007).
"""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
import importlib.util
import threading
from pathlib import Path

import numba
import numpy as np

from .._jit import c_callback
from .embree_filter import LookFilter
from .embree_rays import Traversal

# How soon a build hears of a cancel. Embree asks several thousand times a build.
POLL_SECONDS = 0.01
# RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED and ..._RAY16_...
_NATIVE_PACKETS_OF_8, _NATIVE_PACKETS_OF_16 = 33, 34
_FILTER_FUNCTIONS = 66  # RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED
# A ray through an edge hits one of its triangles (without: one in 20 slips through, but the others
# take less time).
ROBUST = 4
_INDEX, _VERTEX, _FLOAT3 = 0, 1, 0x9003
# RTC_GEOMETRY_TYPE_... and RTC_FORMAT_UINT... of faces, by their corners
_FACES = {3: (0, 0x5003), 4: (1, 0x5004)}
_OUT_OF_MEMORY, _CANCELLED = 4, 6
_ERRORS = (
    "none",
    "unknown",
    "argument",
    "operation",
    "memory",
    "processor not supported",
    "cancelled",
)
_SMALLEST_PAGE = 4096
_HANDLE, _SIZE = ctypes.c_void_p, ctypes.c_size_t
# RTCIntersectArguments: flags (RTC_RAY_QUERY_FLAG_COHERENT), features (all), context, functions.
_COHERENT = (ctypes.c_uint32 * 8)(1 << 16, 0xFFFFFFFF)
_SIGNATURES = {
    "rtcNewDevice": (_HANDLE, [ctypes.c_char_p]),
    "rtcRetainDevice": (None, [_HANDLE]),
    "rtcReleaseDevice": (None, [_HANDLE]),
    "rtcGetDeviceError": (ctypes.c_int, [_HANDLE]),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, [_HANDLE, ctypes.c_int]),
    "rtcNewScene": (_HANDLE, [_HANDLE]),
    "rtcSetSceneFlags": (None, [_HANDLE, ctypes.c_int]),
    "rtcCommitScene": (None, [_HANDLE]),
    "rtcReleaseScene": (None, [_HANDLE]),
    "rtcSetSceneProgressMonitorFunction": (None, [_HANDLE] * 3),
    "rtcNewGeometry": (_HANDLE, [_HANDLE, ctypes.c_int]),
    "rtcSetSharedGeometryBuffer": (
        None,
        [_HANDLE, ctypes.c_int, ctypes.c_uint, ctypes.c_int, _HANDLE, _SIZE, _SIZE, _SIZE],
    ),
    "rtcSetGeometryTimeStepCount": (None, [_HANDLE, ctypes.c_uint]),
    "rtcSetGeometryUserData": (None, [_HANDLE] * 2),
    "rtcSetGeometryOccludedFilterFunction": (None, [_HANDLE] * 2),
    "rtcSetGeometryIntersectFilterFunction": (None, [_HANDLE] * 2),
    "rtcGetGeometry": (_HANDLE, [_HANDLE, ctypes.c_uint]),
    "rtcCommitGeometry": (None, [_HANDLE]),
    "rtcAttachGeometry": (ctypes.c_uint, [_HANDLE, _HANDLE]),
    "rtcReleaseGeometry": (None, [_HANDLE]),
}


@functools.cache
def can_filter() -> bool:
    """Whether shadow rays can be filtered."""
    try:
        library = load_library()
    except OSError:
        return False
    device = library.rtcNewDevice(b"")
    able = library.rtcGetDeviceProperty(device, _FILTER_FUNCTIONS)
    library.rtcReleaseDevice(device)
    return bool(able)


@functools.cache
def load_library() -> ctypes.CDLL:
    """The libembree4 of the embreex wheel, else the system's. Raises OSError where none loads."""
    problems = []
    for path in _library_paths():
        try:
            library = ctypes.CDLL(str(path))
            for name, (result, arguments) in _SIGNATURES.items():
                function = getattr(library, name)
                function.restype, function.argtypes = result, arguments
            return library
        except (OSError, AttributeError) as error:
            problems.append(f"{path}: {error}")
    raise OSError("Embree 4 does not load: " + ("; ".join(problems) or "no library found"))


def _library_paths() -> list[Path | str]:
    """Where wheels carry it: embreex.libs (Linux, Windows), embreex/.dylibs (macOS)."""
    try:
        spec = importlib.util.find_spec("embreex")
    except ValueError:  # a module without a spec
        spec = None
    packages = [Path(folder) for folder in (spec and spec.submodule_search_locations) or ()]
    folders = [p.parent / "embreex.libs" for p in packages] + [p / ".dylibs" for p in packages]
    found = [path for folder in folders for path in sorted(folder.glob("*embree4*"))]
    system = ctypes.util.find_library("embree4")
    return [*found, system] if system else found


@c_callback(numba.types.boolean(numba.types.CPointer(numba.types.uint8), numba.types.float64))
def _go_on(stop, progress):
    """RTCProgressMonitorFunction: whether to go on building. Needs no Python, so takes no lock."""
    return stop[0] == 0


class EmbreeScene:
    """The hierarchy of one mesh. It lives as long as the object, or until close()."""

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        own_filter: LookFilter | None = None,
        beside: EmbreeScene | None = None,
        aside: float = 0.0,
    ):
        """Ready to be committed. m > 0.

        vertices: float32 (n, 3), or (k, n, 3), where they are at k evenly spaced times from 0 to 1
        faces: triangles, int32 (m, 3), or quads, int32 (m, 4), as Embree knows them: hits tell of
            these (triangle_pairs.py)
        own_filter: which hits count; None: all
        beside: a scene whose device it shares, so that both can be parts of one more
        aside: of Traversal; 0: no ray slips through an edge
        Both arrays are read in place. Faces with a corner that is not finite are never hit.
        Raises OSError where there is no library, MemoryError or RuntimeError.
        """
        self.handle = self.device = None
        self._library = load_library()
        self._arrays = _readable(vertices), faces  # Embree reads them, and owns nothing
        self._filter, self._aside = own_filter, aside
        # Not "threads=N": it would bind all users of TBB in the process, Blender's too.
        if beside is None:
            self.device = self._library.rtcNewDevice(b"")
        else:
            self._library.rtcRetainDevice(beside.device)
            self.device = beside.device
        self.check()
        self.handle = self._library.rtcNewScene(self.device)
        self.check()
        self._library.rtcSetSceneFlags(self.handle, 0 if aside else ROBUST)
        self._attach(*self._arrays)
        self.check()

    def _attach(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        library = self._library
        shape, corners = _FACES[faces.shape[1]]
        geometry = library.rtcNewGeometry(self.device, shape)
        steps = vertices.reshape(-1, *vertices.shape[-2:])
        if len(steps) > 1:
            library.rtcSetGeometryTimeStepCount(geometry, len(steps))
        buffers = [(_VERTEX, _FLOAT3, k, step) for k, step in enumerate(steps)]
        for kind, form, slot, array in (*buffers, (_INDEX, corners, 0, faces)):
            library.rtcSetSharedGeometryBuffer(
                geometry, kind, slot, form, array.ctypes.data, 0, array.strides[0], len(array)
            )
        if self._filter is not None:
            self._ask(geometry, self._filter)
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self.handle, geometry)
        library.rtcReleaseGeometry(geometry)  # the scene keeps it

    def _ask(self, geometry, own: LookFilter | None) -> None:
        library = self._library
        library.rtcSetGeometryUserData(geometry, own and own.data)
        library.rtcSetGeometryOccludedFilterFunction(geometry, own and own.function)
        nearest = (own and own.nearest) or None
        library.rtcSetGeometryIntersectFilterFunction(geometry, nearest)

    def ask(self, own: LookFilter | None) -> None:
        """Another filter for a hierarchy that is built: for single rays. Packets go on as before.

        Nobody may be tracing rays meanwhile.
        """
        self._ask(self._library.rtcGetGeometry(self.handle, 0), own)
        self._filter = own

    def go_on(self) -> None:
        """See Accel: a LookFilter, where there is no other one, which does the same."""
        if self._filter is None:
            self.ask(LookFilter())

    def commit(self, cancelled=lambda: False) -> bool:
        """Build the hierarchy in a thread of its own; whether it was finished.

        ``cancelled`` is asked every 0.01 s, Python's lock is free. A build that was cancelled can
        only be closed. Raises MemoryError or RuntimeError.
        """
        stop, ends = np.zeros(1, np.uint8), []
        self._library.rtcSetSceneProgressMonitorFunction(
            self.handle, _go_on.address, stop.ctypes.data
        )

        def build():
            self._library.rtcCommitScene(self.handle)
            ends.append(self._library.rtcGetDeviceError(self.device))  # kept for each thread

        # Not a daemon: an interpreter that ends would free what Embree works on.
        thread = threading.Thread(target=build, name="iwis-embree")
        thread.start()
        try:
            while thread.is_alive():
                stop[0] = stop[0] or cancelled()
                thread.join(POLL_SECONDS)
        finally:
            stop[0] = 1
            thread.join()
            self._library.rtcSetSceneProgressMonitorFunction(self.handle, None, None)
        if ends[0] != _CANCELLED:
            self.check(ends[0])
        return ends[0] != _CANCELLED

    def traversal(self) -> Traversal:
        """What kernels trace rays with, while this object lives."""
        library = self._library
        names = ("Occluded1", "Occluded8", "Occluded16", "Intersect1", "Intersect8")
        one, eight, sixteen, nearest, sheaf = (
            ctypes.cast(getattr(library, f"rtc{name}"), _HANDLE).value for name in names
        )
        has_eight = bool(library.rtcGetDeviceProperty(self.device, _NATIVE_PACKETS_OF_8))
        sixteen *= bool(library.rtcGetDeviceProperty(self.device, _NATIVE_PACKETS_OF_16))
        colored = self._filter is not None and self._filter.colored
        own = self.handle, one, eight * has_eight, nearest, colored, self._aside, sixteen
        return Traversal(*own, intersect8=sheaf * has_eight, coherent=ctypes.addressof(_COHERENT))

    def close(self) -> None:
        """Free the hierarchy; it must not be asked any more."""
        if self.handle:
            self._library.rtcReleaseScene(self.handle)
        if self.device:
            self._library.rtcReleaseDevice(self.device)
        self.handle = self.device = self._arrays = self._filter = None

    __del__ = close

    def check(self, code: int | None = None) -> None:
        """Raise what went wrong last on the device, or what a code says."""
        code = self._library.rtcGetDeviceError(self.device) if code is None else code
        if code == _OUT_OF_MEMORY:
            raise MemoryError(f"Embree: no memory for {len(self._arrays[1])} faces")
        if code:
            raise RuntimeError(f"Embree: error {code} ({_ERRORS[code]})")


def _readable(vertices: np.ndarray) -> np.ndarray:
    """vertices, or a longer copy where 4 bytes beyond their end might be nobody's.

    Embree reads the last vertex as 16 bytes. That is harmless within a page of memory.
    """
    if (vertices.ctypes.data + vertices.nbytes) % _SMALLEST_PAGE:
        return vertices
    flat = vertices.reshape(-1, 3)
    return np.concatenate([flat, np.zeros((1, 3), np.float32)])[:-1].reshape(vertices.shape)

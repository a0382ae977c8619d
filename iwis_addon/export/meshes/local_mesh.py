"""One evaluated mesh, copied out of Blender in its own space.

``foreach_get`` copies an attribute as a whole (0.003 s for the positions of a million vertices) but
walks other collections one element at a time (0.07 s): so all that can be is derived from
attributes by indexing.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ..errors import ExportCancelled, ExportError

if TYPE_CHECKING:
    from .diced_mesh import Diced


class LocalMesh(NamedTuple):
    """Triangles and normals of a mesh, in object space.

    positions: float32 (n, 3), metres; triangles: int32 (m, 3), rows of positions
    normals: float32 (k, 3), unit normals of vertices or of face corners; None: all flat
    normal_index: int32 (m, 3), row of normals for each corner of each triangle; None as normals
    flat: bool (m,), triangles with their geometric normal all the same; None where none is
    slots: int32 (m,), material slot, never negative; None where all are 0
    corners: int32 (m, 3), the mesh's face corners of each triangle; of what is round, the rows of
        its source (element_values.py)
    digest: bytes that two meshes share only if all of the above is equal; empty if not asked for
    round: whether the triangles stand for points or strands, which are as round as their normals
    radial: whether normals lead away from a centre, and turn and stretch as that does (as those of
        Cycles' points, which keep pointing away from it on what a scale makes an ellipsoid)
    diced: of what is subdivided adaptively (diced_mesh.py); its corners mean nothing
    """

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None
    normal_index: np.ndarray | None
    flat: np.ndarray | None
    slots: np.ndarray | None
    corners: np.ndarray
    digest: bytes
    round: bool = False
    radial: bool = False
    diced: Diced | None = None


def session_uid(data) -> int:
    """The number of bpy data that stays the same in a session; evaluated copies have none."""
    return (data.original or data).session_uid


class LiveMeshes:
    """The meshes of a window's last export, while Blender says that they have not changed.

    The graph of a window lives on and tells what it has evaluated anew. A mesh that it has not is
    where it was, so that owner and address name it, and nothing of it need be read again.
    """

    def __init__(self):
        self._last: dict[tuple, LocalMesh | None] = {}
        self._now: dict[tuple, LocalMesh | None] = {}

    def begin(self, changed: set[int] | None) -> None:
        """A new export. changed: session_uid of what has new geometry; None: trust nothing."""
        kept = {} if changed is None else self._now
        self._last = {k: mesh for k, mesh in kept.items() if not changed & set(k[:3])}
        self._now = {}

    def read(self, owner, obj, data, make, *settings) -> LocalMesh | None:
        """make(), or what it was, of an object's evaluated data. owner: the object, or what
        instances it; settings: what else decides it"""
        key = *map(session_uid, (owner, obj, data)), data.as_pointer(), settings
        if key not in self._now:
            local = self._last.get(key)
            self._now[key] = make() if local is None else local
        return self._now[key]


class _Source(NamedTuple):
    """The arrays that decide a LocalMesh, before anything is derived from them."""

    positions: np.ndarray
    corner_verts: np.ndarray
    face_starts: np.ndarray | None  # None: every face is a triangle
    shading: str  # FACE: all flat; POINT: normals of vertices; CORNER: normals of face corners
    corner_normals: np.ndarray | None  # with CORNER only
    flat_faces: np.ndarray | None
    face_slots: np.ndarray | None


def _read(collection, name, dtype, width=1):
    out = np.empty((len(collection), width) if width > 1 else len(collection), dtype)
    collection.foreach_get(name, out.reshape(-1))
    return out


def _read_attribute(mesh, name, domain, kind, dtype, width=1):
    """The values of an attribute, or None if the mesh has none of this name, domain and kind."""
    attribute = mesh.attributes.get(name)
    if attribute is None or (attribute.domain, attribute.data_type) != (domain, kind):
        return None
    return _read(attribute.data, "vector" if width > 1 else "value", dtype, width)


def _read_flags(mesh, name, domain):
    """A boolean attribute; None where it is absent or nowhere true."""
    flags = _read_attribute(mesh, name, domain, "BOOLEAN", bool)
    return flags if flags is not None and flags.any() else None


def _read_shading(mesh):
    """How Cycles of the running Blender shades a mesh: ``shading`` and ``flat_faces`` of _Source.

    Before 5.2 Cycles let smooth faces beside flat ones keep their vertices' normals, as long as no
    edge is marked sharp; since then it takes Blender's corner normals.
    """
    domain = mesh.normals_domain
    custom = mesh.attributes.get("custom_normal")
    if domain == "FACE":
        return "FACE", None
    if domain == "CORNER" and bpy.app.version < (5, 2) and custom is None:
        if _read_flags(mesh, "sharp_edge", "EDGE") is None:
            domain = "POINT"
    if domain == "CORNER":
        return "CORNER", None
    # Free normals on points: vertex_normals has them only in some versions, corner_normals always.
    return "POINT" if custom is None else "CORNER", _read_flags(mesh, "sharp_face", "FACE")


def _read_source(mesh) -> _Source:
    shading, flat_faces = _read_shading(mesh)
    only_triangles = 3 * len(mesh.polygons) == len(mesh.loops)
    corner_normals = None
    if shading == "CORNER":
        corner_normals = _read(mesh.corner_normals, "vector", np.float32, 3)
    return _Source(
        positions=_read_attribute(mesh, "position", "POINT", "FLOAT_VECTOR", np.float32, 3),
        corner_verts=_read_attribute(mesh, ".corner_vert", "CORNER", "INT", np.int32),
        face_starts=None if only_triangles else _read(mesh.polygons, "loop_start", np.int32),
        shading=shading,
        corner_normals=corner_normals,
        flat_faces=flat_faces,
        face_slots=_read_attribute(mesh, "material_index", "FACE", "INT", np.int32),
    )


def _digest(source: _Source) -> bytes:
    """A hash of all that a LocalMesh depends on: triangles and vertex normals follow from these."""
    state = hashlib.sha256(source.shading.encode())
    for array in source:
        if isinstance(array, np.ndarray):
            state.update(f"{array.dtype}{array.shape}".encode())
            state.update(array)
        else:
            state.update(b"-")
    return state.digest()


def _face_of_triangle(source: _Source, n_faces):
    """Blender cuts each face, in order, into as many triangles as it has corners less two."""
    faces = np.arange(n_faces, dtype=np.int32)
    if source.face_starts is None:
        return faces
    ends = np.append(source.face_starts[1:], len(source.corner_verts))
    return np.repeat(faces, ends - source.face_starts - 2)


def _derive(mesh, source: _Source, digest: bytes) -> LocalMesh:
    if source.face_starts is None:
        corners = np.arange(len(source.corner_verts), dtype=np.int32).reshape(-1, 3)
    else:
        corners = _read(mesh.loop_triangles, "loops", np.int32, 3)
    triangles = source.corner_verts[corners]
    if triangles.min() < 0 or triangles.max() >= len(source.positions):
        raise ExportError(
            f"Mesh {mesh.name}: a face has a vertex that is not there; the mesh is damaged: run "
            f"bpy.data.meshes[{mesh.name!r}].validate()"
        )
    normals, normal_index = source.corner_normals, corners
    if source.shading == "POINT":
        normals, normal_index = _read(mesh.vertex_normals, "vector", np.float32, 3), triangles
    elif source.shading == "FACE":
        normal_index = None
    flat, slots = source.flat_faces, source.face_slots
    if slots is not None and not (slots > 0).any():
        slots = None
    if flat is not None or slots is not None:
        faces = _face_of_triangle(source, len(mesh.polygons))
        flat = None if flat is None else flat[faces]
        slots = None if slots is None else np.maximum(slots, 0)[faces]
    return LocalMesh(
        source.positions, triangles, normals, normal_index, flat, slots, corners, digest
    )


def read_shape(mesh, like: LocalMesh) -> tuple[np.ndarray, np.ndarray] | None:
    """(positions, normals) of an evaluated bpy mesh at another time, in the rows of a LocalMesh of
    it; None where it has other vertices or faces. Normals: float32 (0, 3) where it has none."""
    if len(mesh.vertices) != len(like.positions):
        return None
    positions = _read_attribute(mesh, "position", "POINT", "FLOAT_VECTOR", np.float32, 3)
    if like.normals is None:
        return positions, np.zeros((0, 3), np.float32)
    of_points = like.normal_index is like.triangles
    normals = mesh.vertex_normals if of_points else mesh.corner_normals
    if len(normals) != len(like.normals):
        return None
    return positions, _read(normals, "vector", np.float32, 3)


def read_mesh(
    mesh, known: dict[bytes, LocalMesh] | None = None, cancelled=lambda: False
) -> LocalMesh | None:
    """An evaluated bpy mesh as arrays of our own; None if it has no face.

    known: meshes of earlier frames by digest; an equal one is returned instead of a new one, which
        saves the triangulation. None: no digest is computed.
    Raises ExportCancelled if cancelled() says so half way (two million triangles take 0.4 s),
    ExportError if the mesh is damaged.
    """
    if len(mesh.polygons) == 0:
        return None
    source = _read_source(mesh)
    digest = b"" if known is None else _digest(source)
    if known and digest in known:
        return known[digest]
    if cancelled():
        raise ExportCancelled
    return _derive(mesh, source, digest)

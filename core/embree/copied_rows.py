"""Room in a scene's tables for the triangles of copies that rays have met.

All that asks about a triangle (materials, mattes, coordinates) asks a table by its row. A copy has
no rows. So the triangle that a ray meets on one is written out, where the copy has it, to a row
that belongs to the ray, until its thread looks through the next pixels.
"""

from __future__ import annotations

import contextlib
import dataclasses
import threading
import time

import numpy as np

from .._jit import kernel
from ..data.program import AtRest
from ..scene import Scene, TriangleMesh
from ..settings import RenderSettings

# Passes of a pixel filter that are looked through at once, and pixels of the cells that a tile has
# a part in, beyond its sides.
_PASSES, _BEYOND = 8, 18
# Rays that are asked at once for something else than a picture: near_rays.py.
_OTHERS = 1 << 18
_TRIES, _TRY_SECONDS = 1000, 0.01
_ONE, _TINY = np.float32(1.0), np.float32(1e-30)


class _Share:
    """The rows that one thread writes to: they are free again when it ends."""

    def __init__(self, free: list[int]):
        self._free, self.number, self.next = free, _taken(free), 0

    def __del__(self):
        self._free.append(self.number)


def _taken(free: list[int]) -> int:
    """One of the free shares; the next threads may begin before the last ones have quite ended."""
    for _ in range(_TRIES):
        with contextlib.suppress(IndexError):
            return free.pop()
        time.sleep(_TRY_SECONDS)
    raise RuntimeError("more threads ask for rows of copies than there are shares")


class CopiedRows:
    """A scene with rows for what rays meet of its copies.

    scene: the given one, whose tables have room
    """

    def __init__(self, scene: Scene, settings: RenderSettings, threads: int):
        """threads: the most that will ask at a time, this one beside them"""
        # Twice what a tile looks through at once, in slices of the shutter's time or in one.
        self._most = _PASSES * (settings.tile_px + _BEYOND) ** 2
        self._begin = len(scene.mesh.triangles)
        self._others = max(_OTHERS, self._most)
        self._size = 2 * self._most + self._others
        self._free, self._known = list(range(threads + 1)), threading.local()
        self._tables = _Tables(scene, self._size * (threads + 1))
        self.scene = self._tables.scene

    def slots(self, n: int) -> np.ndarray:
        """int32 (n,): rows for as many rays, whose triangles stay until this thread has asked for
        what a tile looks through at once."""
        if n > self._most:
            raise ValueError(f"{n} rays look at once, {self._most} may")
        share = self._share()
        if share.next + n > 2 * self._most:
            share.next = 0
        first = self._begin + share.number * self._size + share.next
        share.next += n
        return np.arange(first, first + n, dtype=np.int32)

    def show(self, triangle, u, v, copy, slots: np.ndarray | None) -> None:
        """Write out the triangles of hits on copies, and turn the hits into such on these.

        triangle: int32 (n,), rows of originals; u, v: float32 (n,); copy: int32 (n,), which copy,
        below 0: none. slots: of these rays; None: rows that this thread's next question writes over
        """
        which = np.flatnonzero(copy >= 0)
        if not len(which):
            return
        rows = self._passing(len(which)) if slots is None else slots[which]
        self._tables.write(which, rows, triangle, u, v, copy)
        triangle[which] = rows

    def _passing(self, n: int) -> np.ndarray:
        if n > self._others:
            raise ValueError(f"{n} rays ask at once, {self._others} may")
        first = self._begin + self._share().number * self._size + 2 * self._most
        return np.arange(first, first + n, dtype=np.int32)

    def _share(self) -> _Share:
        kept = vars(self._known)
        if "share" not in kept:
            kept["share"] = _Share(self._free)
        return kept["share"]


def written_out(scene: Scene) -> Scene:
    """The scene with all triangles of its copies in its tables; as it was where it has none."""
    copies = scene.copies
    if copies is None:
        return scene
    counts = (copies.end - copies.first)[copies.original]
    n, ends = int(counts.sum()), np.cumsum(counts)
    tables, rows = _Tables(scene, n), np.arange(n, dtype=np.int32)
    copy = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    local = rows - np.repeat(ends - counts, counts)
    triangle = (np.repeat(copies.first[copies.original], counts) + local).astype(np.int32)
    nowhere = np.zeros(n, np.float32)
    rows += np.int32(len(scene.mesh.triangles))
    tables.write(np.arange(n), rows, triangle, nowhere, nowhere.copy(), copy)
    return dataclasses.replace(tables.scene, copies=None)


class _Tables:
    """A scene whose tables of triangles have more rows, which can be written."""

    def __init__(self, scene: Scene, rows: int):
        self.scene, self._copies = _with_room(scene, rows), scene.copies
        shaders, asked = self.scene.shaders, self.scene.asked
        surface = None if shaders is None else shaders.surface
        self._row = np.zeros(0, np.int32) if surface is None else surface.row
        self._uv, self._rest = asked.uv, None if shaders is None else shaders.rest

    def write(self, which, rows, triangle, u, v, copy) -> None:
        """Write the hits ``which``, int64 (m,), to rows, int32 (m,); the rest as in ``show``."""
        mesh = self.scene.mesh
        tables = mesh.vertices, mesh.triangles, mesh.corner_normals
        tables += mesh.material_index, mesh.object_index, self._row
        _write(which, rows, triangle, u, v, copy, self._copies, *tables)
        if self._uv is not None:
            self._uv.row[rows] = self._uv.row[triangle[which]]
        if self._rest is not None:  # materials move no vertex of a copy
            rest, corners = self._rest.mesh, mesh.triangles[rows]
            rest.vertices[corners] = mesh.vertices[corners]
            rest.corner_normals[rows] = mesh.corner_normals[rows]


def _longer(array: np.ndarray, rows: int) -> np.ndarray:
    """The array, and rows below it that nobody has written to yet."""
    longer = np.empty((len(array) + rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def _longer_mesh(mesh: TriangleMesh, rows: int) -> TriangleMesh:
    """Each new triangle has vertices of its own."""
    triangles = _longer(mesh.triangles, rows)
    own = np.arange(3 * rows, dtype=np.int32).reshape(rows, 3)
    np.add(own, np.int32(len(mesh.vertices)), out=triangles[len(mesh.triangles) :])
    return TriangleMesh(
        vertices=_longer(mesh.vertices, 3 * rows),
        triangles=triangles,
        corner_normals=_longer(mesh.corner_normals, rows),
        material_index=_longer(mesh.material_index, rows),
        object_index=_longer(mesh.object_index, rows),
    )


def _with_room(scene: Scene, rows: int) -> Scene:
    """The scene, whose tables of triangles have so many more rows."""
    shaders, asked = scene.shaders, scene.asked
    if shaders is not None and shaders.surface is not None:
        surface = dataclasses.replace(shaders.surface, row=_longer(shaders.surface.row, rows))
        shaders = dataclasses.replace(shaders, surface=surface)
    if shaders is not None and shaders.rest is not None:
        still = np.append(shaders.rest.smooth, np.zeros(rows, np.bool_))
        rest = AtRest(_longer_mesh(shaders.rest.mesh, rows), shaders.rest.objects, still)
        shaders = dataclasses.replace(shaders, rest=rest)
    if asked.uv is not None:
        asked = asked._replace(uv=asked.uv._replace(row=_longer(asked.uv.row, rows)))
    mesh = _longer_mesh(scene.mesh, rows)
    # Not by dataclasses.replace: rows that nobody has written to would not pass its checks.
    other = object.__new__(Scene)
    for own in dataclasses.fields(Scene):
        object.__setattr__(other, own.name, getattr(scene, own.name))
    for name, value in (("mesh", mesh), ("shaders", shaders), ("asked", asked)):
        object.__setattr__(other, name, value)
    return other


@kernel(forceinline=True)
def _write_turned(matrices, k, vectors, row, out, to):
    """Write to out[to] a matrix, float32 (3, 4), times a vector."""
    x, y, z = vectors[row, 0], vectors[row, 1], vectors[row, 2]
    for i in range(3):
        turned = matrices[k, i, 0] * x + matrices[k, i, 1] * y + matrices[k, i, 2] * z
        out[to, i] = turned + matrices[k, i, 3]


@kernel(forceinline=True)
def _is_flat(normals, row):
    """Whether a triangle's corners have one normal, its face's own."""
    for i in range(3):
        for corner in range(1, 3):
            if normals[row, corner, i] != normals[row, 0, i]:
                return False
    return True


@kernel(forceinline=True)
def _write_face_normal(vertices, triangles, normals, row):
    a, b, c = triangles[row, 0], triangles[row, 1], triangles[row, 2]
    px, py = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1]
    pz, qz = vertices[b, 2] - vertices[a, 2], vertices[c, 2] - vertices[a, 2]
    qx, qy = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1]
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    squared = nx * nx + ny * ny + nz * nz
    if squared > _TINY:
        scale = _ONE / np.sqrt(squared)
        for corner in range(3):
            normals[row, corner, 0] = nx * scale
            normals[row, corner, 1] = ny * scale
            normals[row, corner, 2] = nz * scale


@kernel
def _write(
    which, rows, triangle, u, v, copy, copies, vertices, triangles, normals, material, obj, row_of
):
    """Write to rows, int32, what the hits ``which``, int64, are on, and swap u and v where corners
    change places. vertices ... obj: of a TriangleMesh; row_of: of SurfaceData, or empty"""
    for j in range(len(which)):
        k, row = which[j], rows[j]
        c, t = copy[k], triangle[k]
        turned = copies.turned[c]
        if turned:
            u[k], v[k] = v[k], u[k]
        for corner in range(3):
            source = (3 - corner) % 3 if turned else corner
            own = triangles[t, source]
            _write_turned(copies.matrices, c, vertices, own, vertices, triangles[row, corner])
            _write_turned(copies.normals, c, normals[t], source, normals[row], corner)
        if _is_flat(normals, t):
            _write_face_normal(vertices, triangles, normals, row)
        material[row], obj[row] = material[t], copies.objects[c]
        if len(row_of) > 0:
            row_of[row] = row_of[t]

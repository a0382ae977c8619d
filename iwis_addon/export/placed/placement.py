"""Meshes and where they stand to one table of triangles in world space. Needs no Blender.

A mesh is transformed once for each of its instances, many small instances at a time. Normals go
through the cofactors of the matrix: they are the inverse transpose but for a factor, and defined
where a scale is zero, too. A negative scale turns the winding round, so that it goes on agreeing
with the normals, as in Cycles.

Cycles interpolates the normals of a mesh that stands in several places before it transforms them,
of any other mesh after. That differs where the scale is not uniform, so the normals of the former
keep the lengths that their transform gives them: then their interpolation comes out the same.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....core.scene import TriangleMesh
from ..errors import ExportCancelled
from ..meshes.local_mesh import LocalMesh
from ..meshes.triangle_normals import geometric_normals, make_unit, squared_lengths, usable_vertices
from .instances import Instance, Inventory

# Vertices or triangles worked on at a time: their arrays stay in the processor's cache.
CHUNK = 1 << 16
WITHOUT_PLACE = np.float32([1.0, 1.0, 1.0, 0.0])


def transform_points(matrices, points, out):
    """out[k] = matrices[k, :, :3] @ points + matrices[k, :, 3], without the threads of BLAS.

    matrices: float32 (k, 3, 4); points: float32 (n, 3); out: float32 (k, n, 3), written
    """
    for start in range(0, len(points), CHUNK):
        x, y, z = points[start : start + CHUNK].T
        for i in range(3):
            row = matrices[:, i, :, None]
            values = row[:, 0] * x
            values += row[:, 1] * y
            values += row[:, 2] * z
            np.add(values, row[:, 3], out=out[:, start : start + CHUNK, i])


def cofactors_of(matrices):
    """Inverse transposes of the upper 3x3 up to a positive factor, and which of them mirror.

    matrices: float64 (k, 3, 4). Returns float32 (k, 3, 4) with a zero last column, bool (k,).
    The factor makes them rotations where the scale is uniform.
    """
    x, y, z = matrices[:, :, 0], matrices[:, :, 1], matrices[:, :, 2]
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=2)
    mirrors = np.einsum("ki,ki->k", x, cofactors[:, :, 0]) < 0.0
    size = np.cbrt(np.abs(np.linalg.det(cofactors)))
    largest = np.abs(cofactors).max(axis=(1, 2))
    size = np.where(size > 1e-6 * largest, size, largest)  # a scale of zero: any size will do
    size[size == 0.0] = 1.0
    cofactors /= np.where(mirrors, -size, size)[:, None, None]
    return np.pad(cofactors, ((0, 0), (0, 0), (0, 1))).astype(np.float32), mirrors


class Placed(NamedTuple):
    """Instances in world space.

    usable: bool (m,), which triangles can be rendered
    places: int64 (n, 2), the first vertex and the first triangle of each instance
    mirrors: bool (n,), whose winding is turned round
    """

    mesh: TriangleMesh
    usable: np.ndarray
    places: np.ndarray
    mirrors: np.ndarray


class Transforms(NamedTuple):
    """Of all instances: float32 (n, 3, 4) of points and of normals, bool (n,) which mirror."""

    matrices: np.ndarray
    cofactors: np.ndarray
    mirrors: np.ndarray

    @classmethod
    def of(cls, instances: list[Instance]) -> Transforms:
        exact = np.array([instance.object_to_world for instance in instances])
        cofactors, mirrors = cofactors_of(exact.reshape(-1, 4, 4)[:, :3])
        return cls(exact.reshape(-1, 4, 4)[:, :3].astype(np.float32), cofactors, mirrors)


def users_of(inventory: Inventory) -> np.ndarray:
    """How many instances each part has."""
    return np.bincount([i.part for i in inventory.instances], minlength=len(inventory.parts))


def _batches(inventory: Inventory, mirrors, rows) -> Iterator[tuple[Instance, list[int]]]:
    """Those of the rows of instances that differ in nothing but their matrix, few enough for the
    cache.

    Yields an instance that stands for all of them, and their rows.
    """
    groups: dict[tuple, list[int]] = {}
    for row in rows:
        instance = inventory.instances[row]
        groups.setdefault((instance.part, instance.slots, bool(mirrors[row])), []).append(row)
    for (part, _, _), rows in groups.items():
        mesh = inventory.parts[part]
        most = max(CHUNK // max(len(mesh.positions), len(mesh.triangles)), 1)
        for start in range(0, len(rows), most):
            yield inventory.instances[rows[start]], rows[start : start + most]


class _Writer:
    """Writes batches of instances one after another into the arrays of a TriangleMesh.

    Until ``finish_normals`` a corner normal of zero stands for the geometric one.
    """

    def __init__(self, n_vertices, n_triangles, n_instances):
        self.mesh = TriangleMesh(
            vertices=np.empty((n_vertices, 3), np.float32),
            triangles=np.empty((n_triangles, 3), np.int32),
            corner_normals=np.empty((n_triangles, 3, 3), np.float32),
            material_index=np.empty(n_triangles, np.int32),
            object_index=np.empty(n_triangles, np.int32),
        )
        self.places = np.empty((n_instances, 2), np.int64)
        self._vertex = self._triangle = 0

    @classmethod
    def over(cls, placed: Placed) -> _Writer:
        """For instances that move: what does not follow from their matrices is shared."""
        writer = cls(0, 0, 0)
        writer.places = placed.places
        writer.mesh = dataclasses.replace(
            placed.mesh,
            vertices=placed.mesh.vertices.copy(),
            corner_normals=placed.mesh.corner_normals.copy(),
        )
        return writer

    def write(self, part: LocalMesh, slots, rows, mirrored, shared, matrices, cofactors):
        """Append a mesh once for each of the matrices: float32 (k, 3, 4), cofactors likewise.

        slots: material rows; rows: the instances' rows of the objects
        shared: whether the mesh has other instances
        """
        k, n, m = len(rows), len(part.positions), len(part.triangles)
        triangles = slice(self._triangle, self._triangle + k * m)
        first = np.arange(self._vertex, self._vertex + k * n, n)
        self.places[rows, 0] = first
        self.places[rows, 1] = np.arange(triangles.start, triangles.stop, m)
        self.write_moved(part, rows, mirrored, shared, matrices, cofactors)
        out = self.mesh.triangles[triangles].reshape(k, m, 3)
        order = corner_order(mirrored)
        np.add(part.triangles[:, order], first[:, None, None].astype(np.int32), out=out)
        self.mesh.object_index[triangles].reshape(k, m)[:] = np.array(rows)[:, None]
        if part.slots is None:
            self.mesh.material_index[triangles] = slots[0]
        else:  # an index past the last slot means the last one, as in Cycles
            chosen = np.array(slots)[np.minimum(part.slots, len(slots) - 1)]
            self.mesh.material_index[triangles].reshape(k, m)[:] = chosen
        self._vertex, self._triangle = self._vertex + k * n, triangles.stop

    def write_moved(self, part: LocalMesh, rows, mirrored, shared, matrices, cofactors):
        """Of ``write`` what follows from the matrices, of rows that lie one after another."""
        k, n, m = len(rows), len(part.positions), len(part.triangles)
        vertex, triangle = self.places[rows[0]]
        vertices = slice(vertex, vertex + k * n)
        transform_points(matrices, part.positions, self.mesh.vertices[vertices].reshape(k, n, 3))
        triangles = slice(triangle, triangle + k * m)
        turns = matrices * WITHOUT_PLACE if part.radial else cofactors
        self._write_normals(part, corner_order(mirrored), shared, turns, triangles)

    def _write_normals(self, part, order, shared, turns, triangles):
        k = len(turns)
        out = self.mesh.corner_normals[triangles].reshape(k, -1, 3, 3)
        if part.normals is None:
            out[:] = 0.0
            return
        normals = np.empty((k, *part.normals.shape), np.float32)
        transform_points(turns, part.normals, normals)
        if not shared:
            make_unit(normals)
        # "clip": with bounds checks, take() would go through a buffer as large as out.
        np.take(normals, part.normal_index[:, order], axis=1, out=out, mode="clip")
        if part.flat is not None:
            out[:, part.flat] = 0.0

    def finish_normals(self, cancelled, first=0, end=None):
        """Fill in the geometric normals of the triangles from first to end; bool (m,), True where
        one can be rendered."""
        mesh = self.mesh
        has_area = np.empty((len(mesh.triangles) if end is None else end) - first, bool)
        for start in range(0, len(has_area), CHUNK):
            if cancelled():
                raise ExportCancelled
            own = slice(start, min(start + CHUNK, len(has_area)))
            chunk = slice(first + own.start, first + own.stop)
            a, b, c = (
                np.take(mesh.vertices, corner, axis=0, mode="clip")
                for corner in mesh.triangles[chunk].T
            )
            geometric, has_area[own] = geometric_normals(a, b, c)
            normals = mesh.corner_normals[chunk]
            _, good = squared_lengths(normals)
            if not good.any():
                normals[:] = geometric[:, None]
            elif not good.all():
                triangle, corner = np.nonzero(~good)
                normals[triangle, corner] = geometric[triangle]
        return has_area


def corner_order(mirrored):
    """Which corners a triangle of a mirrored, or another, instance has."""
    return [0, 2, 1] if mirrored else slice(None)


def place_instances(
    inventory: Inventory, cancelled=lambda: False, written: np.ndarray | None = None
) -> Placed:
    """Instances in world space. Raises ExportCancelled as soon as cancelled() says so.

    written: bool, one an instance: which ones; None: all
    """
    parts, instances = inventory.parts, inventory.instances
    chosen = range(len(instances)) if written is None else np.flatnonzero(written).tolist()
    own = [parts[instances[row].part] for row in chosen]
    counts = (sum(len(p.positions) for p in own), sum(len(p.triangles) for p in own))
    writer = _Writer(*counts, len(instances))
    users, mesh = users_of(inventory), writer.mesh
    # Broken vertices are told from good ones afterwards; meanwhile their arithmetic may overflow.
    with np.errstate(all="ignore"):
        matrices, cofactors, mirrors = Transforms.of(instances)
        for instance, rows in _batches(inventory, mirrors, chosen):
            if cancelled():
                raise ExportCancelled
            shared = users[instance.part] > 1
            moves = mirrors[rows[0]], shared, matrices[rows], cofactors[rows]
            writer.write(parts[instance.part], instance.slots, rows, *moves)
        has_area = writer.finish_normals(cancelled)
    usable = usable_vertices(mesh.vertices)
    if not usable.all():
        has_area &= usable[mesh.triangles].all(axis=1)
    return Placed(mesh, has_area, writer.places, mirrors)


def move_instances(placed: Placed, inventory: Inventory, rows: list[int]) -> Placed | None:
    """The same where nothing differs but the matrices of some instances: all else is shared.

    None where triangles cannot be rendered, or turn round: then all is to be placed anew.
    """
    instances, users = inventory.instances, users_of(inventory)
    if not placed.usable.all():
        return None
    writer = _Writer.over(placed)
    with np.errstate(all="ignore"):
        matrices, cofactors, mirrors = Transforms.of([instances[row] for row in rows])
        if (mirrors != placed.mirrors[rows]).any():
            return None
        for k, row in enumerate(rows):
            part = inventory.parts[instances[row].part]
            moves = mirrors[k], users[instances[row].part] > 1, matrices[k : k + 1]
            writer.write_moved(part, [row], *moves, cofactors[k : k + 1])
            vertex, first = placed.places[row]
            good = writer.finish_normals(lambda: False, first, first + len(part.triangles))
            moved = writer.mesh.vertices[vertex : vertex + len(part.positions)]
            if not (good.all() and usable_vertices(moved).all()):
                return None
    return placed._replace(mesh=writer.mesh)

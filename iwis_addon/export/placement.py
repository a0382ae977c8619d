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

from collections.abc import Iterator

import numpy as np

from ...core.scene import TriangleMesh
from .errors import ExportCancelled
from .instances import Instance, Inventory
from .local_mesh import LocalMesh

# Vertices or triangles worked on at a time: their arrays stay in the processor's cache.
CHUNK = 1 << 16
# Embree leaves out what lies farther: squares of distances would overflow.
FARTHEST = np.float32(1.8e18)
# Squared lengths below this lose digits in float32 or underflow.
TINY = np.float32(1e-30)


def _transform(matrices, points, out):
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


def _cofactors(matrices):
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


def _squared_lengths(vectors):
    """Of vectors (last axis), and where neither underflow, overflow nor NaN spoils them."""
    squared = np.einsum("...i,...i->...", vectors, vectors)
    return squared, (squared > TINY) & (squared < np.inf)


def _unit(vectors):
    """Scale vectors (last axis) to unit length in place; True where there was a direction."""
    squared, good = _squared_lengths(vectors)
    np.copyto(squared, 1.0, where=~good)
    vectors /= np.sqrt(squared, out=squared)[..., None]
    return good


def _geometric_normals(a, b, c):
    """Unit normals of triangles, and which of them have any: the others have no area.

    a, b, c: float32 (n, 3), corners. Where float32 overflows or underflows, float64 decides.
    """
    b, c = b - a, c - a
    normals = np.empty_like(a)
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(b[:, j], c[:, k], out=normals[:, i])
        normals[:, i] -= b[:, k] * c[:, j]
    good = _unit(normals)
    rest = np.flatnonzero(~good)
    if len(rest):
        exact = np.cross(b[rest].astype(np.float64), c[rest].astype(np.float64))
        length = np.sqrt(np.einsum("ij,ij->i", exact, exact))
        has_area = (length > 0.0) & np.isfinite(length)
        good[rest] = has_area
        normals[rest[has_area]] = exact[has_area] / length[has_area, None]
    return normals, good


def usable_vertices(vertices):
    """bool (n,): rows of float32 (n, 3) that are numbers and not too far away to be rendered."""
    if len(vertices) and np.maximum(vertices.max(), -vertices.min()) <= FARTHEST:  # not if NaN
        return np.ones(len(vertices), bool)
    return (np.abs(vertices) <= FARTHEST).all(axis=1)


def _batches(inventory: Inventory, mirrors) -> Iterator[tuple[Instance, list[int]]]:
    """Rows of instances that differ in nothing but their matrix, few enough for the cache.

    Yields an instance that stands for all of them, and their rows.
    """
    groups: dict[tuple, list[int]] = {}
    for row, instance in enumerate(inventory.instances):
        key = instance.part, instance.slots, bool(mirrors[row])
        groups.setdefault(key, []).append(row)
    for (part, _, _), rows in groups.items():
        mesh = inventory.parts[part]
        most = max(CHUNK // max(len(mesh.positions), len(mesh.triangles)), 1)
        for start in range(0, len(rows), most):
            yield inventory.instances[rows[start]], rows[start : start + most]


class _Writer:
    """Writes batches of instances one after another into the arrays of a TriangleMesh.

    Until ``finish_normals`` a corner normal of zero stands for the geometric one.
    """

    def __init__(self, n_vertices, n_triangles):
        self.mesh = TriangleMesh(
            vertices=np.empty((n_vertices, 3), np.float32),
            triangles=np.empty((n_triangles, 3), np.int32),
            corner_normals=np.empty((n_triangles, 3, 3), np.float32),
            material_index=np.empty(n_triangles, np.int32),
            object_index=np.empty(n_triangles, np.int32),
        )
        self._vertex = self._triangle = 0

    def write(self, part: LocalMesh, slots, rows, mirrored, shared, matrices, cofactors):
        """Append a mesh once for each of the matrices: float32 (k, 3, 4), cofactors likewise.

        slots: material rows; rows: the instances' rows of the objects
        shared: whether the mesh has other instances
        """
        k, n, m = len(rows), len(part.positions), len(part.triangles)
        order = [0, 2, 1] if mirrored else slice(None)
        vertices = slice(self._vertex, self._vertex + k * n)
        triangles = slice(self._triangle, self._triangle + k * m)
        _transform(matrices, part.positions, self.mesh.vertices[vertices].reshape(k, n, 3))
        first = np.arange(vertices.start, vertices.stop, n, dtype=np.int32)
        out = self.mesh.triangles[triangles].reshape(k, m, 3)
        np.add(part.triangles[:, order], first[:, None, None], out=out)
        self._write_normals(part, order, shared, cofactors, triangles)
        self.mesh.object_index[triangles].reshape(k, m)[:] = np.array(rows)[:, None]
        if part.slots is None:
            self.mesh.material_index[triangles] = slots[0]
        else:  # an index past the last slot means the last one, as in Cycles
            chosen = np.array(slots)[np.minimum(part.slots, len(slots) - 1)]
            self.mesh.material_index[triangles].reshape(k, m)[:] = chosen
        self._vertex, self._triangle = vertices.stop, triangles.stop

    def _write_normals(self, part, order, shared, cofactors, triangles):
        k = len(cofactors)
        out = self.mesh.corner_normals[triangles].reshape(k, -1, 3, 3)
        if part.normals is None:
            out[:] = 0.0
            return
        normals = np.empty((k, *part.normals.shape), np.float32)
        _transform(cofactors, part.normals, normals)
        if not shared:
            _unit(normals)
        # "clip": with bounds checks, take() would go through a buffer as large as out.
        np.take(normals, part.normal_index[:, order], axis=1, out=out, mode="clip")
        if part.flat is not None:
            out[:, part.flat] = 0.0

    def finish_normals(self, cancelled):
        """Fill in the geometric normals; bool (m,), True where a triangle can be rendered."""
        mesh = self.mesh
        has_area = np.empty(len(mesh.triangles), bool)
        for start in range(0, len(has_area), CHUNK):
            if cancelled():
                raise ExportCancelled
            chunk = slice(start, start + CHUNK)
            a, b, c = (mesh.vertices[corner] for corner in mesh.triangles[chunk].T)
            geometric, has_area[chunk] = _geometric_normals(a, b, c)
            normals = mesh.corner_normals[chunk]
            _, good = _squared_lengths(normals)
            if not good.any():
                normals[:] = geometric[:, None]
            elif not good.all():
                triangle, corner = np.nonzero(~good)
                normals[triangle, corner] = geometric[triangle]
        usable = usable_vertices(mesh.vertices)
        if not usable.all():
            has_area &= usable[mesh.triangles].all(axis=1)
        return has_area


def place_instances(inventory: Inventory, cancelled=lambda: False):
    """All instances in world space, and bool (m,): which triangles can be rendered.

    Raises ExportCancelled as soon as cancelled() says so.
    """
    parts, instances = inventory.parts, inventory.instances
    writer = _Writer(
        sum(len(parts[instance.part].positions) for instance in instances),
        sum(len(parts[instance.part].triangles) for instance in instances),
    )
    if not instances:
        return writer.mesh, np.zeros(0, bool)
    exact = np.array([instance.object_to_world for instance in instances])[:, :3]
    # Broken vertices are told from good ones afterwards; meanwhile their arithmetic may overflow.
    with np.errstate(all="ignore"):
        cofactors, mirrors = _cofactors(exact)
        matrices = exact.astype(np.float32)
        users = np.bincount([instance.part for instance in instances])
        for instance, rows in _batches(inventory, mirrors):
            if cancelled():
                raise ExportCancelled
            writer.write(
                parts[instance.part],
                instance.slots,
                rows,
                mirrors[rows[0]],
                users[instance.part] > 1,
                matrices[rows],
                cofactors[rows],
            )
        return writer.mesh, writer.finish_normals(cancelled)

"""Instances to one table of triangles in world space.

A mesh is read once and transformed for each of its instances. Normals go through the cofactors of
the matrix: they are the inverse transpose but for a factor, and are defined where a scale is zero,
too. A negative scale turns the winding round, so that it goes on agreeing with the normals, as in
Cycles.
"""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ...core.scene import TriangleMesh
from .errors import ExportCancelled, ExportError
from .instances import Instance, Inventory, collect_instances
from .local_mesh import LocalMesh

# Triangles worked on at a time: their arrays stay in the processor's cache.
CHUNK = 1 << 16
# Embree and TriangleMesh count vertices in int32.
MOST_TRIANGLES = (1 << 31) // 3
# Squared lengths below this lose digits in float32 or underflow.
TINY = np.float32(1e-30)


class MeshExport(NamedTuple):
    """The geometry of a scene and what its rows mean.

    materials: evaluated bpy materials or None, row = TriangleMesh.material_index
    object_pass_index: float32 (n,), row = TriangleMesh.object_index
    """

    mesh: TriangleMesh
    materials: list
    object_pass_index: np.ndarray


class ExportCache:
    """Geometry of the last frame, so that the next one copies only what has changed.

    Every frame of a background render comes with a new dependency graph, which says nothing of the
    last one: so meshes are compared by their content (a hash of all arrays), instances by their
    matrices and slots. When all are equal the very same TriangleMesh is returned, and whoever keeps
    a BVH may compare by ``is``.
    """

    def __init__(self):
        self.parts: dict[bytes, LocalMesh] = {}
        self.key = None
        self.mesh: TriangleMesh | None = None
        self.warnings: list[str] = []

    def remember(self, key, parts, mesh, warnings):
        self.parts = {part.digest: part for part in parts}
        self.key, self.mesh, self.warnings = key, mesh, warnings


def _transform(matrix, points, out):
    """out[:] = matrix[:3, :3] @ points + matrix[:3, 3], without the threads of BLAS."""
    m = matrix.astype(np.float32)
    for i in range(3):
        row = points[:, 0] * m[i, 0]
        row += points[:, 1] * m[i, 1]
        row += points[:, 2] * m[i, 2]
        np.add(row, m[i, 3], out=out[:, i])


def _normal_matrix(matrix) -> np.ndarray:
    """Inverse transpose of the upper 3x3, up to a positive factor; (3, 4) with a zero column."""
    x, y, z = matrix[:3, :3].T
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=1)
    largest = np.abs(cofactors).max()
    if largest > 0.0:
        cofactors /= largest if np.dot(x, cofactors[:, 0]) >= 0.0 else -largest
    return np.pad(cofactors, ((0, 0), (0, 1)))


def _unit(vectors):
    """Scale the rows to unit length in place; True where there was a direction."""
    squared = np.einsum("ij,ij->i", vectors, vectors)
    good = (squared > TINY) & (squared < np.inf)
    np.copyto(squared, 1.0, where=~good)
    vectors /= np.sqrt(squared, out=squared)[:, None]
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


def _write_normals(normals, normal_index, geometric, flat, out):
    """Corner normals of some triangles: the given ones, or the geometric where there are none.

    normals: (unit normals float32 (k, 3), bool (k,) whether each is one), or None
    normal_index: int32 (n, 3); geometric: float32 (n, 3); flat: bool (n,) or None
    out: float32 (n, 3, 3), written
    """
    if normals is None:
        out[:] = geometric[:, None, :]
        return
    values, good = normals
    np.take(values, normal_index, axis=0, out=out, mode="clip")
    if good is not None:
        triangle, corner = np.nonzero(~good[normal_index])
        out[triangle, corner] = geometric[triangle]
    if flat is not None:
        out[flat] = geometric[flat, None, :]


class _Writer:
    """Writes one instance after another into the arrays of a TriangleMesh.

    has_area: bool (m,), triangles that are not to be dropped
    """

    def __init__(self, n_vertices, n_triangles, cancelled):
        self.mesh = TriangleMesh(
            vertices=np.empty((n_vertices, 3), np.float32),
            triangles=np.empty((n_triangles, 3), np.int32),
            corner_normals=np.empty((n_triangles, 3, 3), np.float32),
            material_index=np.empty(n_triangles, np.int32),
            object_index=np.empty(n_triangles, np.int32),
        )
        self.has_area = np.empty(n_triangles, bool)
        self._vertex = self._triangle = 0
        self._cancelled = cancelled

    def write(self, part: LocalMesh, instance: Instance, object_index: int):
        """Append an instance of a mesh; it becomes a row of the objects."""
        matrix = instance.object_to_world
        first = self._vertex
        vertices = self.mesh.vertices[first : first + len(part.positions)]
        _transform(matrix, part.positions, vertices)
        normals = None
        if part.normals is not None:
            values = np.empty_like(part.normals)
            _transform(_normal_matrix(matrix), part.normals, values)
            good = _unit(values)
            normals = values, None if good.all() else good
        order = [0, 2, 1] if np.linalg.det(matrix[:3, :3]) < 0.0 else slice(None)
        slots = np.array(instance.slots, np.int32)
        for start in range(0, len(part.triangles), CHUNK):
            if start and self._cancelled():
                raise ExportCancelled
            self._write_triangles(
                part, slice(start, start + CHUNK), order, vertices, normals, slots
            )
        last = self._triangle
        self.mesh.object_index[last - len(part.triangles) : last] = object_index
        self._vertex += len(vertices)

    def _write_triangles(self, part, chunk, order, vertices, normals, slots):
        local = part.triangles[chunk][:, order]
        rows = slice(self._triangle, self._triangle + len(local))
        geometric, self.has_area[rows] = _geometric_normals(
            vertices[local[:, 0]], vertices[local[:, 1]], vertices[local[:, 2]]
        )
        index = None if normals is None else part.normal_index[chunk][:, order]
        flat = None if part.flat is None else part.flat[chunk]
        _write_normals(normals, index, geometric, flat, self.mesh.corner_normals[rows])
        np.add(local, self._vertex, out=self.mesh.triangles[rows])
        if part.slots is None:
            self.mesh.material_index[rows] = slots[0]
        else:  # an index past the last slot means the last one, as in Cycles
            self.mesh.material_index[rows] = slots[np.minimum(part.slots[chunk], len(slots) - 1)]
        self._triangle = rows.stop


def _drop_triangles(mesh: TriangleMesh, keep, instances, warnings) -> TriangleMesh:
    """Leave out triangles without area and tell which objects had how many."""
    dropped = np.flatnonzero(~keep)
    if len(dropped) == 0:
        return mesh
    finite_vertex = np.isfinite(mesh.vertices).all(axis=1)
    finite = finite_vertex[mesh.triangles[dropped]].all(axis=1)
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for kind, chosen in enumerate((dropped[~finite], dropped[finite])):
        for row, n in enumerate(np.bincount(mesh.object_index[chosen], minlength=len(instances))):
            if n:
                counts[instances[row].name][kind] += int(n)
    for name, (broken, flat) in counts.items():
        warnings.append(
            f"Object {name}: {broken + flat} triangles left out ({flat} without area, "
            f"{broken} with a vertex that is infinite or not a number)"
        )
    mesh.vertices[~finite_vertex] = 0.0  # no triangle names them, but bounds may be taken of all
    return TriangleMesh(
        vertices=mesh.vertices,
        triangles=mesh.triangles[keep],
        corner_normals=mesh.corner_normals[keep],
        material_index=mesh.material_index[keep],
        object_index=mesh.object_index[keep],
    )


def _merge(inventory: Inventory, warnings, cancelled) -> TriangleMesh:
    parts, instances = inventory.parts, inventory.instances
    n_triangles = sum(len(parts[instance.part].triangles) for instance in instances)
    n_vertices = sum(len(parts[instance.part].positions) for instance in instances)
    if max(n_triangles, n_vertices) > MOST_TRIANGLES:
        shares: dict[str, int] = defaultdict(int)
        for instance in instances:
            shares[instance.name] += len(parts[instance.part].triangles)
        name = max(shares, key=shares.get)
        raise ExportError(
            f"The scene has {n_triangles:,} triangles with all its instances; the most is "
            f"{MOST_TRIANGLES:,}. Object {name} has {shares[name]:,} of them: reduce its copies or "
            f"its subdivision, or hide it from renders"
        )
    writer = _Writer(n_vertices, n_triangles, cancelled)
    # Not-a-number and infinite vertices are looked for afterwards; their arithmetic may overflow.
    with np.errstate(all="ignore"):
        for row, instance in enumerate(instances):
            if row % 64 == 0 and cancelled():
                raise ExportCancelled
            writer.write(parts[instance.part], instance, row)
    return _drop_triangles(writer.mesh, writer.has_area, instances, warnings)


def export_mesh(
    depsgraph, warnings: list[str], cache: ExportCache | None = None, cancelled=lambda: False
) -> MeshExport:
    """All geometry that the graph renders, in world space; each triangle is finite and has area.

    warnings: gets a line for each kind of object left out, and for each object with bad triangles
    cache: the same object for every frame of an animation; unchanged geometry is then reused
    Raises ExportError if there is too much, ExportCancelled as soon as cancelled() says so.
    """
    known = None if cache is None else cache.parts
    inventory = collect_instances(depsgraph, warnings, known, cancelled)
    parts, instances = inventory.parts, inventory.instances
    pass_index = np.array([instance.pass_index for instance in instances], np.float32)
    if cache is None:
        return MeshExport(_merge(inventory, warnings, cancelled), inventory.materials, pass_index)
    key = [(i.name, parts[i.part].digest, i.object_to_world.tobytes(), i.slots) for i in instances]
    if cache.mesh is None or key != cache.key:
        lines: list[str] = []
        cache.remember(key, parts, _merge(inventory, lines, cancelled), lines)
    warnings.extend(cache.warnings)
    return MeshExport(cache.mesh, inventory.materials, pass_index)

"""Triangles in the shape that they have at one time, where meshes change theirs.

Between two steps corners go straight, and so do their normals, which are made unit again, as in
Cycles. A whole mesh is never made: only the triangles that rays have met.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..data.object_motion import Pose, Shapes
from ..scene import TriangleMesh

_ONE, _TINY = np.float32(1.0), np.float32(1e-12)


def shaped(
    pose: Pose | None, mesh: TriangleMesh, triangle: np.ndarray
) -> tuple[TriangleMesh, np.ndarray]:
    """(a mesh that has some triangles in the pose's shape, int32 (n,), their rows in it).

    triangle: int32 (n,), rows of ``mesh``, which is returned itself where none has changed. Objects
    are where the mesh table has them.
    """
    return _shaped(pose, mesh, triangle, True)


def shaped_for_nodes(
    pose: Pose | None, mesh: TriangleMesh, triangle: np.ndarray
) -> tuple[TriangleMesh, np.ndarray]:
    """The same, but smooth faces keep the corner normals of ``mesh``: Cycles' normal maps do."""
    return _shaped(pose, mesh, triangle, False)


def _shaped(pose, mesh, triangle, smooth):
    if pose is None or not pose.shapes:
        return mesh, triangle
    own = None
    for shapes in pose.shapes:
        where, rows = _found(shapes, triangle)
        if len(where):
            own = _copied(mesh, triangle) if own is None else own
            step, part = step_at(shapes, pose.time)
            given = shapes, step, part, rows, where, smooth
            _write_shape(*given, own.vertices, own.corner_normals)
    return (mesh, triangle) if own is None else (own, np.arange(len(triangle), dtype=np.int32))


def step_at(shapes: Shapes, time: float) -> tuple[int, np.float32]:
    """(the step before a time, how far it is to the next one)."""
    last = len(shapes.positions) - 1
    step = min(int(time * last), last - 1)
    return step, np.float32(time * last - step)


def _found(shapes: Shapes, triangle: np.ndarray):
    """(which of the triangles a shape has, their rows in it)."""
    rows = np.searchsorted(shapes.triangle, triangle).clip(max=max(len(shapes.triangle) - 1, 0))
    if not len(shapes.triangle):
        return np.zeros(0, np.int64), rows
    where = np.flatnonzero(shapes.triangle[rows] == triangle)
    return where, rows[where]


def _copied(mesh: TriangleMesh, triangle: np.ndarray) -> TriangleMesh:
    n = len(triangle)
    return TriangleMesh(
        vertices=mesh.vertices[mesh.triangles[triangle].reshape(-1)],
        triangles=np.arange(3 * n, dtype=np.int32).reshape(n, 3),
        corner_normals=mesh.corner_normals[triangle],
        material_index=mesh.material_index[triangle],
        object_index=mesh.object_index[triangle],
    )


@kernel
def _write_shape(shapes, step, part, rows, where, smooth, vertices, corner_normals):
    """Overwrite the corners of triangles ``where`` by those of rows of shapes, and their normals.

    smooth: whether faces that have normals at their corners get these, too
    """
    before = _ONE - part
    for k in range(len(where)):
        row, t = rows[k], where[k]
        for c in range(3):
            v = shapes.corners[row, c]
            for a in range(3):
                vertices[3 * t + c, a] = (
                    before * shapes.positions[step, v, a] + part * shapes.positions[step + 1, v, a]
                )
        if shapes.normal_index[row, 0] >= 0 and not smooth:
            continue
        if not _write_smooth(shapes, step, part, row, corner_normals, t):
            _write_flat(vertices, corner_normals, t)


@kernel
def _write_smooth(shapes, step, part, row, corner_normals, t):
    """Write a triangle's corner normals; False where one has none: all are the face's then."""
    before = _ONE - part
    for c in range(3):
        n, squared = shapes.normal_index[row, c], np.float32(0.0)
        if n < 0:
            return False
        for a in range(3):
            value = before * shapes.normals[step, n, a] + part * shapes.normals[step + 1, n, a]
            corner_normals[t, c, a] = value
            squared += value * value
        if not squared > _TINY:
            return False
        scale = _ONE / np.sqrt(squared)
        for a in range(3):
            corner_normals[t, c, a] *= scale
    return True


@kernel
def _write_flat(vertices, corner_normals, t):
    a, b, c = vertices[3 * t], vertices[3 * t + 1], vertices[3 * t + 2]
    squared = np.float32(0.0)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        value = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i])
        corner_normals[t, 0, k] = value
        squared += value * value
    scale = _ONE / np.sqrt(squared) if squared > np.float32(0.0) else np.float32(0.0)
    for k in range(3):
        corner_normals[t, 0, k] *= scale
        corner_normals[t, 1, k] = corner_normals[t, 0, k]
        corner_normals[t, 2, k] = corner_normals[t, 0, k]

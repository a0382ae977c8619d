"""Where moving objects are at one time: shading points to and from the pose of the mesh table.

The table has each object as it is in the middle of the shutter's time, and materials are evaluated
there: so coordinates, tangents and bumps stay on the object, as in Cycles. What a node knows of the
camera or of world space is then of the middle, too. What has changed its shape keeps that at rest,
and object coordinates follow it: so do Cycles'. UV maps and all else that corners have stay on it.
"""

from __future__ import annotations

import numpy as np

from ..data.object_motion import Pose
from ..scene import TriangleMesh
from .shading import ShadingPoints, shading_points
from .shapes import shaped


def _rows(pose: Pose, mesh: TriangleMesh, triangle):
    """(which of some triangles move, their rows in the pose)."""
    row = pose.row[mesh.object_index[triangle]]
    which = np.flatnonzero(row >= 0)
    return which, row[which]


def _vectors(matrices, vectors):
    return np.einsum("nij,nj->ni", matrices[:, :3, :3], vectors).astype(np.float32)


def _unit(vectors):
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return (vectors / np.where(length > 0.0, length, 1.0)[:, None]).astype(np.float32)


def _normals(inverses, normals):
    """Of matrices with these inverses."""
    return _unit(np.einsum("nji,nj->ni", inverses[:, :3, :3], normals))


def _posed(points: ShadingPoints, which, matrices, inverses) -> ShadingPoints:
    """The points, of which some are moved by matrices, float64 (n, 4, 4)."""
    moved = ShadingPoints(*(column.copy() for column in points))
    places = np.einsum("nij,nj->ni", matrices[:, :3, :3], points.position[which])
    moved.position[which] = places + matrices[:, :3, 3]
    moved.wo[which] = _unit(_vectors(matrices, points.wo[which]))
    moved.lift[which] = _vectors(matrices, points.lift[which])
    for name in ("normal", "geometric_normal"):
        getattr(moved, name)[which] = _normals(inverses, getattr(points, name)[which])
    return moved


def points_at_rest(pose: Pose | None, mesh: TriangleMesh, points: ShadingPoints) -> ShadingPoints:
    """Points of a pose where the mesh table has them."""
    if pose is None:
        return points
    which, rows = _rows(pose, mesh, points.triangle)
    if not len(which):
        return points
    return _posed(points, which, pose.backward[rows], pose.forward[rows])


def posed_normals(pose: Pose | None, mesh: TriangleMesh, triangle, normals: np.ndarray):
    """Normals of the mesh table, float32 (n, 3), 0 = none, as they are in the pose."""
    if pose is None:
        return normals
    which, rows = _rows(pose, mesh, triangle)
    if not len(which):
        return normals
    normals = np.array(normals, np.float32)
    normals[which] = _normals(pose.backward[rows], normals[which])
    return normals


def normals_at_rest(pose: Pose | None, mesh: TriangleMesh, triangle, normals: np.ndarray):
    """Normals of a pose, float32 (n, 3), 0 = none, as the mesh table has them."""
    if pose is None:
        return normals
    which, rows = _rows(pose, mesh, triangle)
    normals = np.array(normals, np.float32)
    normals[which] = _normals(pose.forward[rows], normals[which])
    return normals


def _points_in_shape(pose: Pose, mesh, hit, u, v, directions, terminator_offset) -> ShadingPoints:
    """shading_points of rays that met triangles in the shape of the pose."""
    rays = np.flatnonzero(hit >= 0)
    own, faces = shaped(pose, mesh, hit[rays])
    if own is mesh:
        return shading_points(mesh, hit, u, v, directions, terminator_offset)
    met = np.full(len(hit), -1, np.int32)
    met[rays] = faces
    points = shading_points(own, met, u, v, directions, terminator_offset)
    return points._replace(triangle=hit[points.pixel])


def posed_points(
    pose: Pose | None, mesh: TriangleMesh, hit, u, v, directions, terminator_offset=None
) -> ShadingPoints:
    """See shading_points; of rays that met objects where they are in the pose."""
    if pose is None:
        return shading_points(mesh, hit, u, v, directions, terminator_offset)
    rays = np.flatnonzero(hit >= 0)
    which, rows = _rows(pose, mesh, hit[rays])
    if not len(which):
        return _points_in_shape(pose, mesh, hit, u, v, directions, terminator_offset)
    at_rest = np.array(directions, np.float32)
    at_rest[rays[which]] = _unit(_vectors(pose.backward[rows], directions[rays[which]]))
    points = _points_in_shape(pose, mesh, hit, u, v, at_rest, terminator_offset)
    moved = _posed(points, which, pose.forward[rows], pose.backward[rows])
    moved.wo[:] = -directions[points.pixel]
    return moved

"""Shading points of what is as round as its normals (scene.ROUND): strands and points.

In Cycles they are whole primitives, and a ray that leaves one does not meet it again, wherever it
goes. Here they are triangles: rays to light from behind, or from all round, start beyond them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..scene import ROUND, Scene, TriangleMesh
from .shading import ShadingPoints

# Of the turn of the normals round a tube: they turn less along it.
_STRAIGHT = np.float32(0.4)
_CLEAR = np.float32(1.02)
_STEEPEST, _LEAST = 1.0, 0.05  # of slopes; of the radius at a tip
_TINY = np.float32(1e-20)


class Circles(NamedTuple):
    """What m points are on: tubes that may be cones, or spheres.

    radius: float32 (m,), metres, of the circle that corners beside the point would be on; reach: of
        the one that rays start on, which from every place of a facet is outside of the facets
    axis: float32 (m, 3), unit, of a tube; 0 of a sphere
    slope: float32 (m,), of the radius along it
    """

    radius: np.ndarray
    reach: np.ndarray
    axis: np.ndarray
    slope: np.ndarray


def is_round(scene: Scene, triangle: np.ndarray) -> np.ndarray:
    """bool (n,): whether triangles are parts of strands and points."""
    if scene.terminator_offset is None:
        return np.zeros(len(triangle), np.bool_)
    return scene.terminator_offset[scene.mesh.object_index[triangle]] >= ROUND


def circles(mesh: TriangleMesh, triangle: np.ndarray, position: np.ndarray) -> Circles:
    """Those of m points on triangles, int (m,), at float32 (m, 3).

    Two corners of a triangle and their normals are on a circle. Of its three edges that of the
    smallest: along a tube, and aslant, it is larger. The edge along it tells its slope.
    """
    places = mesh.vertices[mesh.triangles[triangle]]
    normals = mesh.corner_normals[triangle]
    edges = np.roll(places, -1, axis=1) - places
    turns = np.linalg.norm(np.roll(normals, -1, axis=1) - normals, axis=2)
    sizes = np.linalg.norm(edges, axis=2) / np.maximum(turns, _TINY)
    row, round_, straight = np.arange(len(triangle)), sizes.argmin(axis=1), turns.argmin(axis=1)
    radius, turn = sizes[row, round_], turns[row, round_]
    cosine = np.sqrt(np.maximum(1.0 - 0.25 * turn**2, 0.25))  # of half the angle of a side
    # At right angles to the mean normal where the tube bends, and is no cone.
    along, out = edges[row, straight], normals[row, straight] + normals[row, (straight + 1) % 3]
    out = out / np.maximum(np.linalg.norm(out, axis=1), _TINY)[:, None]
    rise = np.einsum("ij,ij->i", along, out)
    axis = along - rise[:, None] * out
    length = np.maximum(np.linalg.norm(axis, axis=1), _TINY)
    tube = turns[row, straight] < _STRAIGHT * turn
    axis = np.where(tube[:, None], axis / length[:, None], 0.0)
    slope = np.where(tube, np.clip(rise / length, -_STEEPEST, _STEEPEST), 0.0)
    ahead = np.einsum("ij,ij->i", position - places[row, round_], axis)
    radius = np.maximum(radius + slope * ahead, _LEAST * radius)
    return Circles(*map(np.float32, (radius, _CLEAR * radius / cosine, axis, slope)))


def beyond(
    points: ShadingPoints, rows: np.ndarray, normal: np.ndarray, way: np.ndarray, behind: np.ndarray
) -> ShadingPoints:
    """The same points, some of them outside of the round thing that they are on.

    rows: int (m,), of points on round things; normal: float32 (m, 3), unit, of those, towards the
    viewer; way: float32 (m,), metres along it; behind: bool (m,), which of them look away from him
    """
    position, face = points.position.copy(), points.geometric_normal.copy()
    below = points.lift_below.copy()
    position[rows] += way[:, None] * normal
    face[rows] = np.where(behind[:, None], -normal, normal)
    below[rows] = 0.0
    return points._replace(position=position, geometric_normal=face, lift_below=below)


def normals_of_strands(normal: np.ndarray, tangent: np.ndarray) -> np.ndarray:
    """float32 (m, 3): unit normals at right angles to unit tangents."""
    across = normal - np.einsum("ij,ij->i", normal, tangent)[:, None] * tangent
    length = np.linalg.norm(across, axis=1)[:, None]
    return np.float32(across / np.maximum(length, _TINY))

"""Faces that shine on objects that move, or change their shape: where their light comes from then.

Lamps themselves stand as in the middle of the shutter's time: so do Cycles'.
"""

from __future__ import annotations

import numpy as np

from ..data.lamps import MESH, Lamps
from ..data.object_motion import Pose
from ..geometry.shapes import shaped
from ..scene import Scene
from .emitter_tree import areas_of, face_nodes

# All faces that shine times slices of the shutter's time: 60 bytes each, 1.6 us.
_MOST_FACES = 1 << 21


def faces_in_motion(scene: Scene) -> np.ndarray:
    """int64 (k,): rows of LampFaces that move, or change their shape."""
    face, motion = scene.lamps.faces.face, scene.motion
    moves = np.isin(scene.mesh.object_index[face], motion.objects)
    for shapes in motion.shapes:
        moves |= np.isin(face, shapes.triangle)
    return np.flatnonzero(moves)


def shines_from_rest(scene: Scene) -> bool:
    """Whether there are too many faces to have them at each slice of the shutter's time."""
    count = len(scene.lamps.faces.face) * len(scene.motion.times)
    return count > _MOST_FACES and len(faces_in_motion(scene)) > 0


def posed_lamps(scene: Scene, pose: Pose) -> Lamps:
    """The scene's lamps as they are in the pose."""
    lamps, which = scene.lamps, faces_in_motion(scene)
    if not len(which) or shines_from_rest(scene):
        return lamps
    corners = lamps.faces.corners.copy()
    corners[which] = _carried(scene, pose, lamps.faces.face[which], corners[which])
    before, now = areas_of(lamps.faces.corners), areas_of(corners)
    grown = np.divide(now, before, out=np.zeros_like(now), where=before > 0.0)
    power = lamps.faces.power * grown[:, None]
    nodes, position, size = lamps.faces.nodes.copy(), lamps.position.copy(), lamps.size.copy()
    for row in np.flatnonzero(lamps.kind == MESH):
        first, end, root = lamps.span[row]
        own, leaves = face_nodes(corners[first:end], power[first:end])
        nodes[root : root + len(leaves)] = own
        low, high = own[0, :3], own[0, 3:6]
        position[row], size[row, 0] = 0.5 * (low + high), max(np.linalg.norm(high - low), 1e-6)
    faces = lamps.faces._replace(corners=corners, power=power, nodes=nodes)
    return lamps._replace(position=position, size=size, faces=faces)


def _carried(scene: Scene, pose: Pose, face, corners) -> np.ndarray:
    """float32 (n, 3, 3): corners of parts of triangles, carried along by these."""
    mesh = scene.mesh
    at_rest = mesh.vertices[mesh.triangles[face]].astype(np.float64)
    own, rows = shaped(pose, mesh, face)
    posed = own.vertices[own.triangles[rows]].astype(np.float64)
    moves = pose.row[mesh.object_index[face]]
    which = np.flatnonzero(moves >= 0)
    matrices = pose.forward[moves[which]]
    turned = np.einsum("nij,nkj->nki", matrices[:, :3, :3], posed[which])
    posed[which] = turned + matrices[:, None, :3, 3]
    side, other = (at_rest[:, k] - at_rest[:, 0] for k in (1, 2))
    away = corners - at_rest[:, :1]
    aa, ab, bb = (
        np.einsum("ni,ni->n", *pair)[:, None]
        for pair in ((side, side), (side, other), (other,) * 2)
    )
    a, b = (np.einsum("nki,ni->nk", away, edge) for edge in (side, other))
    whole = aa * bb - ab * ab
    inverse = np.divide(1.0, whole, out=np.zeros_like(whole), where=whole > 0.0)
    u, v = (bb * a - ab * b) * inverse, (aa * b - ab * a) * inverse
    weights = np.stack([1.0 - u - v, u, v], -1)
    return np.einsum("nkc,nci->nki", weights, posed).astype(np.float32)

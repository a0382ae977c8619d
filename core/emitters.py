"""Faces that shine become lamps: rows of kind MESH, whose faces have a radiance each.

All of them are one lamp, or several where there are many: halves of the same power, along the
longest side of what they fill, until there are _LAMPS in all. So near faces are sampled more than
far ones (lamp_light.py), and no point's work grows with their number.
"""

from __future__ import annotations

import numpy as np

from .emission_parts import Told, parts_that_shine
from .emitter_tree import face_tree, powers_of_faces
from .lamps import MESH, NO_LAMPS, LampFaces, Lamps, make_lamps
from .scene import Scene, TriangleMesh

_LAMPS = 8  # one sample of each is what a pass takes
_LEAST = 32  # faces of a part that is worth dividing


def with_emitters(
    rows: list[dict],
    mesh: TriangleMesh,
    emission: np.ndarray,
    scene: Scene | None = None,
    told: Told | None = None,
    link: np.ndarray | None = None,
    group: np.ndarray | None = None,
) -> Lamps:
    """The lamps of some rows (see make_lamps) and of all faces whose material shines.

    emission: float32 (n, 3), radiance of each material; costs nothing where none shines
    scene: whose programs say what an emission is that varies; told: gets materials whose
    emission is more than a lamp can have
    link, group: int32 (n_objects,), Lamps.link and Lamps.group of what shines on each object; None:
    all of them light all, and are of no group
    """
    falloffs: list[np.ndarray] = []
    parts = parts_that_shine(mesh, emission, scene, told or Told([], [], []), falloffs)
    if not len(parts.face):
        return make_lamps(rows) if rows else NO_LAMPS
    trees, rows, end, root = [], list(rows), 0, 0
    owner = mesh.object_index[parts.face]
    none = np.full(len(owner), -1, np.int32)
    kinds = [none if column is None else column[owner] for column in (link, group)]
    kinds.append(parts.falloff)
    _, kind = np.unique(kinds, axis=1, return_inverse=True)
    for own in _groups(parts, kind.reshape(-1)):
        tree = face_tree(parts.corners[own], parts.radiance[own], parts.face[own])
        low, high = tree.corners.min((0, 1)), tree.corners.max((0, 1))
        width = max(float(np.linalg.norm(high - low)), 1e-6)
        shape = {"kind": MESH, "position": 0.5 * (low + high), "size": (width, 0.0)}
        shape |= {"link": kinds[0][own[0]], "group": kinds[1][own[0]]}
        if kinds[2][own[0]] >= 0:
            shape["falloff"] = falloffs[kinds[2][own[0]]]
        first, end = end, end + len(tree.power)
        rows.append(shape | {"span": (first, end, root)})
        root += len(tree.leaves)
        trees.append(tree)
    return make_lamps(rows, LampFaces(*map(np.concatenate, zip(*trees, strict=True))))


def _groups(parts, kind: np.ndarray) -> list[np.ndarray]:
    """Rows of the parts of each lamp, all of one kind."""
    power = powers_of_faces(parts.corners, parts.radiance)
    center = parts.corners.mean(axis=1)
    groups = [np.flatnonzero(kind == own) for own in np.unique(kind)]
    faces = len(np.unique(parts.face))  # a picture on two faces is one lamp, however it is cut
    while len(groups) < min(_LAMPS, faces // (_LEAST // 2)):
        largest = max(range(len(groups)), key=lambda k: len(groups[k]))
        groups += _halves(groups.pop(largest), center, power)
    return groups


def _halves(part, center, power):
    """Two parts of the same power, or nearly."""
    order = part[np.argsort(center[part][:, np.ptp(center[part], axis=0).argmax()], kind="stable")]
    sums = np.cumsum(power[order])
    middle = int(np.clip(np.searchsorted(sums, 0.5 * sums[-1]), 1, len(order) - 1))
    return [order[:middle], order[middle:]]

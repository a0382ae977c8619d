"""Faces that shine become lamps: rows of kind MESH, whose faces have a radiance each.

All of them are one lamp, or as many as there are light groups, links and falloffs among them, and
what can be looked through is one of its own. What a sample of it goes to is chosen by the tree
(lamp_meshes.py), so near faces are sampled more than far ones, and no point's work grows with their
number.
"""

from __future__ import annotations

import numpy as np

from ..data.lamps import MESH, NO_LAMPS, LampFaces, Lamps, make_lamps
from ..geometry.closed_meshes import hidden_sides
from ..scene import SHADOW_RAYS, Scene, TriangleMesh
from ..see_through.clear_materials import cut_materials
from .emission_parts import Told, parts_that_shine
from .emitter_tree import face_tree

_LAYERS = 8  # faces of what can be looked through that a sample of the BSDF finds


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
    clear = _clear(mesh, scene)
    kinds += [parts.falloff, none + clear[parts.face]]
    _, kind = np.unique(kinds, axis=1, return_inverse=True)
    seldom = hidden_sides(mesh, parts.face, clear)
    for one in range(kind.max() + 1):
        own = np.flatnonzero(kind.reshape(-1) == one)
        tree = face_tree(parts.corners[own], parts.radiance[own], parts.face[own], seldom[own])
        low, high = tree.corners.min((0, 1)), tree.corners.max((0, 1))
        width = max(float(np.linalg.norm(high - low)), 1e-6)
        shape = {"kind": MESH, "position": 0.5 * (low + high), "size": (width, 0.0)}
        shape |= {"link": kinds[0][own[0]], "group": kinds[1][own[0]]}
        shape["layers"] = _LAYERS if clear[parts.face[own[0]]] else 1
        if kinds[2][own[0]] >= 0:
            shape["falloff"] = falloffs[kinds[2][own[0]]]
        first, end = end, end + len(tree.power)
        rows.append(shape | {"span": (first, end, root)})
        root += len(tree.leaves)
        trees.append(tree)
    return make_lamps(rows, LampFaces(*map(np.concatenate, zip(*trees, strict=True))))


def _clear(mesh: TriangleMesh, scene: Scene | None) -> np.ndarray:
    """bool (m,): triangles behind which others are seen, as they let rays through."""
    found = np.zeros(len(mesh.triangles), np.bool_)
    materials = None if scene is None else cut_materials(scene)
    if materials is not None:
        found |= materials[mesh.material_index]
    if scene is not None and scene.object_flags is not None:
        found |= (scene.object_flags & SHADOW_RAYS == 0)[mesh.object_index]
    return found

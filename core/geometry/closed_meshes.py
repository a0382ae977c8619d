"""Sides of faces that nothing sees but what is inside: of objects whose surface is closed.

Both sides of a face that shines give light. Of a bulb, a tube or a letter one side lights the
inside only, and its samples end at the object's other faces: half of all, or more. They are drawn
seldom, for there may be something inside.
"""

from __future__ import annotations

import numpy as np

from ..scene import TriangleMesh

# Of the power that decides how often a hidden side is drawn.
_SELDOM = 0.1
_NONE = -1
_MIX = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9)


def hidden_sides(mesh: TriangleMesh, face: np.ndarray, clear: np.ndarray) -> np.ndarray:
    """float64 (n, 2): factors of how often front and back of faces are drawn.

    face: int (n,), rows of mesh.triangles; their objects are looked at as a whole
    clear: bool (m,), triangles that let rays through
    """
    shines = np.zeros(int(mesh.object_index.max()) + 1, np.bool_)
    shines[mesh.object_index[face]] = True
    rows = np.flatnonzero(shines[mesh.object_index])
    owner = mesh.object_index[rows]
    hidden = _hidden(mesh.vertices[mesh.triangles[rows]], owner, len(shines))
    hidden[owner[clear[rows]]] = _NONE
    found, side = np.ones((len(face), 2)), hidden[mesh.object_index[face]]
    which = np.flatnonzero(side != _NONE)
    found[which, side[which]] = _SELDOM
    return found


def _hidden(corners, owner, n_objects: int) -> np.ndarray:
    """int8 (n_objects,): the hidden side of an object's triangles, 0 front, 1 back, _NONE: their
    surface has a border, or turns over, or is flat. corners: float32 (m, 3, 3); owner: int (m,)"""
    reach = np.zeros(n_objects, np.float32)
    np.maximum.at(reach, owner, np.nan_to_num(np.abs(corners).max(axis=(1, 2)), posinf=0.0))
    # Corners at one place are one, whatever seams there are: rounded as the largest coordinate.
    corners = corners + np.float32(4.0) * reach[owner, None, None]
    place = _keys(corners, owner)
    ends = np.concatenate([place[:, [0, 1]], place[:, [1, 2]], place[:, [2, 0]]])
    around = ends[:, 0] != ends[:, 1]
    ends, own = ends[around], np.tile(owner, 3)[around]
    there, back = (ends[:, k] * _MIX[0] + ends[:, 1 - k] for k in (0, 1))
    order = np.argsort(there)
    there = there[order]
    open_edges = there[np.minimum(np.searchsorted(there, back), len(there) - 1)] != back
    twice = order[1:][there[1:] == there[:-1]]
    volume = _volumes(corners.astype(np.float64), owner, n_objects)
    hidden = np.where(np.abs(volume) > 0.0, volume > 0.0, _NONE).astype(np.int8)
    hidden[own[open_edges]] = hidden[own[twice]] = _NONE
    return hidden


def _keys(corners, owner) -> np.ndarray:
    """uint64 (m, 3): a number for the place of each corner and its object. (Two that have the same
    one by chance make noise, no error.)"""
    x, y, z = np.moveaxis(corners.view(np.uint32).astype(np.uint64), 2, 0)
    key = owner.astype(np.uint64)[:, None]
    for part in (x, y, z):
        key = (key ^ part) * _MIX[1]
        key ^= key >> np.uint64(29)
    return key


def _volumes(corners, owner, n_objects: int) -> np.ndarray:
    """float64 (n_objects,), six times what closed surfaces enclose; below 0: turned inwards. NaN
    of what is not finite."""
    count = np.maximum(np.bincount(owner, minlength=n_objects), 1)
    middle = [np.bincount(owner, axis, n_objects) / count for axis in corners.mean(axis=1).T]
    with np.errstate(invalid="ignore", over="ignore"):
        a, b, c = np.moveaxis(corners - np.stack(middle, -1)[owner][:, None], 1, 0)
        return np.bincount(owner, (a * np.cross(b, c)).sum(axis=1), n_objects)

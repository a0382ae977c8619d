"""Sides of faces that nothing sees but what is inside: of objects whose surface is closed.

Both sides of a face that shines give light. Of a bulb, a tube or a letter one side lights the
inside only, and its samples end at the object's other faces: half of all, or more. They are drawn
seldom, for there may be something inside.
"""

from __future__ import annotations

import numpy as np

from .scene import TriangleMesh

# Of the power that decides how often a hidden side is drawn.
_SELDOM = 0.1


def hidden_sides(mesh: TriangleMesh, face: np.ndarray, clear: np.ndarray) -> np.ndarray:
    """float64 (n, 2): factors of how often front and back of faces are drawn.

    face: int (n,), rows of mesh.triangles; their objects are looked at as a whole
    clear: bool (m,), triangles that let rays through
    """
    found, owner = np.ones((len(face), 2)), mesh.object_index[face]
    for row in np.unique(owner):
        own = mesh.object_index == row
        if clear[own].any():
            continue
        hidden = _hidden(mesh.vertices, mesh.triangles[own])
        if hidden is not None:
            found[owner == row, hidden] = _SELDOM
    return found


def _hidden(vertices, triangles) -> int | None:
    """The hidden side of triangles, 0 front, 1 back; None: their surface has a border, or turns
    over, or is flat."""
    corners = vertices[triangles.ravel()]
    if not np.isfinite(corners).all():
        return None
    # Corners at one place are one, whatever seams the mesh has: rounded as its largest coordinate.
    corners = corners + np.float32(4.0) * np.abs(corners).max()
    _, place = np.unique(corners.view(np.void(12).dtype).ravel(), return_inverse=True)
    place = place.reshape(-1, 3)
    ends = np.concatenate([place[:, [0, 1]], place[:, [1, 2]], place[:, [2, 0]]]).astype(np.int64)
    ends = ends[ends[:, 0] != ends[:, 1]]
    there, back = (np.sort(a * (len(corners) + 1) + b) for a, b in (ends.T, ends.T[::-1]))
    if not len(there) or (there != back).any() or (there[1:] == there[:-1]).any():
        return None
    a, b, c = np.moveaxis(
        (corners - corners.mean(axis=0)).astype(np.float64).reshape(-1, 3, 3), 1, 0
    )
    volume = float((a * np.cross(b, c)).sum())
    return None if volume == 0.0 else int(volume > 0.0)

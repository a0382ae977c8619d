"""Faces that shine become lamps: rows of kind MESH, of one radiance each.

All faces of a material are one lamp, or several where it is spread over space: halves of the same
area, along the longest side of what they fill, until there are _LAMPS in all. So near faces are
sampled more than far ones (lamp_light.py), and no point's work grows with their number.
"""

from __future__ import annotations

import numpy as np

from .lamps import BLOCK, MESH, NO_LAMPS, LampFaces, Lamps, make_lamps
from .scene import TriangleMesh

_LAMPS = 8  # one sample of each is what a pass takes
_LEAST = 32  # faces of a part that is worth dividing


def with_emitters(rows: list[dict], mesh: TriangleMesh, emission: np.ndarray) -> Lamps:
    """The lamps of some rows (see make_lamps) and of all faces whose material shines.

    emission: float32 (n, 3), radiance of each material; costs nothing where none shines
    """
    emission = np.maximum(emission, 0.0)
    shines = (emission > 0.0).any(axis=1)
    groups = [] if not shines.any() else _groups(mesh, shines)
    if not groups:
        return make_lamps(rows) if rows else NO_LAMPS
    faces, rows, end = [], list(rows), 0
    for material, own in groups:
        part = _table(mesh.vertices[mesh.triangles[own]])
        first, end = end, end + len(part.area)
        low, high = part.corners.min((0, 1)), part.corners.max((0, 1))
        width = max(float(np.linalg.norm(high - low)), 1e-6)
        shape = {"kind": MESH, "position": 0.5 * (low + high), "size": (width, 0.0)}
        rows.append(shape | {"radiance": emission[material], "span": (first, end)})
        faces.append(part)
    columns = zip(*faces, strict=True)
    return make_lamps(rows, LampFaces(*map(np.concatenate, columns)))


def _groups(mesh: TriangleMesh, shines) -> list[tuple[int, np.ndarray]]:
    """(material, rows of its faces that have an area), one for each lamp."""
    rows = np.flatnonzero(shines[mesh.material_index])
    area = _areas(mesh.vertices[mesh.triangles[rows]])
    rows, area = rows[area > 0.0], area[area > 0.0]
    center = mesh.vertices[mesh.triangles[rows]].mean(axis=1)
    material = mesh.material_index[rows]
    parts = [np.flatnonzero(material == k) for k in np.unique(material)]
    while 0 < len(parts) < _LAMPS:
        largest = max(range(len(parts)), key=lambda k: len(parts[k]))
        if len(parts[largest]) < _LEAST:
            break
        parts += _halves(parts.pop(largest), center, area)
    return [(int(material[part[0]]), rows[part]) for part in parts]


def _halves(part, center, area):
    """Two parts of the same area, or nearly."""
    order = part[np.argsort(center[part][:, np.ptp(center[part], axis=0).argmax()], kind="stable")]
    sums = np.cumsum(area[order])
    middle = int(np.clip(np.searchsorted(sums, 0.5 * sums[-1]), 1, len(order) - 1))
    return [order[:middle], order[middle:]]


def _areas(corners) -> np.ndarray:
    """float64 (n,): 0 for what is not finite, too."""
    corners = corners.astype(np.float64)
    sides = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.where(np.isfinite(area), area, 0.0)


def _table(corners) -> LampFaces:
    """The faces of one lamp, near ones side by side, in whole blocks."""
    corners = corners[_order(corners.mean(axis=1))]
    empty = np.repeat(corners[-1:, :1], 3, axis=1)
    corners = np.concatenate([corners, np.repeat(empty, -len(corners) % BLOCK, axis=0)])
    blocks = corners.reshape(-1, BLOCK * 3, 3).astype(np.float64)
    center = 0.5 * (blocks.min(axis=1) + blocks.max(axis=1))
    radius = np.linalg.norm(blocks - center[:, None], axis=2).max(axis=1)
    balls = np.concatenate([center, 1.00001 * radius[:, None]], axis=1)
    return LampFaces(np.ascontiguousarray(corners), np.cumsum(_areas(corners)), balls)


def _order(places) -> np.ndarray:
    """Along Morton's curve [Morton66] of 1024 steps a side."""
    low, size = places.min(axis=0), max(float(np.ptp(places, axis=0).max()), 1e-30)
    cells = np.clip((places - low) / size * 1023.0, 0.0, 1023.0).astype(np.int64)
    code = np.zeros(len(places), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")

"""Point clouds, and points that geometry nodes make: a sphere for each point."""

from __future__ import annotations

import hashlib

import numpy as np

from .element_values import (
    attribute_of,
    attribute_values,
    random_of_rows,
    read_values,
)
from .local_mesh import LocalMesh
from .mesh_size import check_made
from .point_spheres import count_triangles, divisions, make_spheres

_RADIUS = 0.01  # metres, where a cloud has none


class PointSource:
    """What materials ask of a point cloud, one row a point; read while the graph lives."""

    def __init__(self, data):
        self._data = data

    def rows(self, name: str) -> np.ndarray | None:
        """float32 (n, width) of a name of element_values.py; None where there is none."""
        kind, _, rest = name.partition(":")
        if kind == "element":
            return self._element(rest)
        if kind in ("attribute", "color", "uv") and rest:
            attribute = attribute_of(self._data, rest, "FLOAT2" if kind == "uv" else None)
            return None if attribute is None else attribute_values(attribute)
        return None

    def _element(self, name):
        if name == "Position":
            return _positions(self._data)
        if name == "Radius":
            return _radii(self._data)[:, None]
        return random_of_rows(len(self._data.points)) if name == "Random" else None


def _positions(data) -> np.ndarray:
    return read_values(data.attributes["position"].data, "vector", 3, np.float32)


def _radii(data) -> np.ndarray:
    attribute = attribute_of(data, "radius", "FLOAT", "POINT")
    if attribute is None:
        return np.full(len(data.points), _RADIUS, np.float32)
    return np.maximum(attribute_values(attribute)[:, 0], 0.0)


def centers_and_radii(data) -> tuple[np.ndarray, np.ndarray]:
    """float32 (n, 3), (n,), of an evaluated bpy point cloud that has any point."""
    return _positions(data), _radii(data)


def read_point_cloud(name: str, data, known: dict[bytes, LocalMesh] | None) -> LocalMesh | None:
    """An evaluated bpy point cloud; None if it has no point of any size.

    name: of its object; known: as for read_mesh
    Raises ExportError where it does not fit into memory.
    """
    if len(data.points) == 0:
        return None
    positions, radii = centers_and_radii(data)
    sized = np.flatnonzero(radii > 0.0)
    if not len(sized):
        return None
    digest = b""
    if known is not None:
        digest = hashlib.sha256(b"points" + positions.tobytes() + radii.tobytes()).digest()
        if digest in known:
            return known[digest]
    divided = divisions(radii[sized])
    check_made(name, f"{len(sized):,} points", count_triangles(divided))
    made = make_spheres(positions[sized], radii[sized], divided)
    rows = sized[made.point].astype(np.int32)
    return LocalMesh(
        made.positions,
        made.triangles,
        made.normals,
        made.normal_index,
        None,
        None,
        np.broadcast_to(rows[:, None], (len(rows), 3)),
        digest,
        round=True,
        radial=True,
    )

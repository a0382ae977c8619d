"""Where points lie on triangles; kernels for that."""

from __future__ import annotations

import numpy as np

from ..data.rows import any_in_row
from ..scene import TriangleMesh
from .values import normalized


def barycentric_of(mesh: TriangleMesh, triangle, position) -> np.ndarray:
    """float32 (n, 2): weights of the second and third corner at places on triangles.

    From the place again, so that what traces rays need not carry them along.
    """
    found = np.empty((len(triangle), 2), np.float32)
    position = np.ascontiguousarray(position, np.float32)
    kernels().barycentric_at(mesh.vertices, mesh.triangles, triangle, position, found)
    return found


def tangents_of(normal, size) -> tuple[np.ndarray, np.ndarray]:
    """Two float32 (n, 3) in the plane of a face, at right angles, of a size (n,): the first one is
    (1, 1, 1) x the normal, or (-1, 1, 1) x it. Bumps ask for heights there, as Cycles' do."""
    x, y, z = normal.T
    t = np.stack([z - y, x - z, y - x], -1)
    even = ~any_in_row(t)
    t[even] = np.stack([z - y, x + z, -y - x], -1)[even]
    t = normalized(t)
    scale = np.asarray(size, np.float32)[:, None]
    return (t * scale).astype(np.float32), (np.cross(normal, t) * scale).astype(np.float32)


def in_shape(pose, mesh: TriangleMesh, triangle):
    """See shapes.shaped_for_nodes, a kernel, which is loaded for what moves alone."""
    if pose is None:
        return mesh, triangle
    from ..geometry import shapes

    return shapes.shaped_for_nodes(pose, mesh, triangle)


def kernels():
    """Kernels: the exporters load without numba."""
    from ..geometry import element_places

    return element_places

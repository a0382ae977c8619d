"""Where points lie on triangles; kernels for that."""

from __future__ import annotations

import numpy as np

from ..scene import TriangleMesh


def barycentric_of(mesh: TriangleMesh, triangle, position) -> np.ndarray:
    """float32 (n, 2): weights of the second and third corner at places on triangles.

    From the place again, so that what traces rays need not carry them along.
    """
    found = np.empty((len(triangle), 2), np.float32)
    position = np.ascontiguousarray(position, np.float32)
    kernels().barycentric_at(mesh.vertices, mesh.triangles, triangle, position, found)
    return found


def in_shape(pose, mesh: TriangleMesh, triangle):
    """See shapes.shaped_for_nodes, a kernel, which is loaded for what moves alone."""
    if pose is None:
        return mesh, triangle
    from .. import shapes

    return shapes.shaped_for_nodes(pose, mesh, triangle)


def kernels():
    """Kernels: the exporters load without numba."""
    from .. import element_places

    return element_places

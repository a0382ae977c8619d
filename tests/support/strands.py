"""A strand, as export makes them of triangles."""

import numpy as np

from iwis.core.scene import TriangleMesh


def cone_mesh(sides=8, low=0.3, high=0.2, length=2.0) -> TriangleMesh:
    """A cone of triangles along z, with normals across it as strands' tubes have them."""
    angle = np.arange(sides) * 2.0 * np.pi / sides
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], -1)
    top = ring * high + (0.0, 0.0, length)
    following = (np.arange(sides) + 1) % sides
    first = np.stack([np.arange(sides), following, following + sides], -1)
    second = np.stack([np.arange(sides), following + sides, np.arange(sides) + sides], -1)
    triangles = np.concatenate([first, second]).astype(np.int32)
    normals = np.concatenate([ring, ring]).astype(np.float32)
    n = len(triangles)
    return TriangleMesh(
        vertices=np.concatenate([ring * low, top]).astype(np.float32),
        triangles=triangles,
        corner_normals=normals[triangles],
        material_index=np.zeros(n, np.int32),
        object_index=np.zeros(n, np.int32),
    )

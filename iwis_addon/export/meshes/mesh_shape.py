"""What the Geometry node tells of a mesh's shape: Pointiness and Random Per Island, as Cycles'."""

from __future__ import annotations

import numpy as np

from ....core.nodes.hashing import hash_words
from .element_values import random_of_words, read_values


def _edges(mesh) -> np.ndarray:
    return read_values(mesh.edges, "vertices", 2, np.int32)


def islands(mesh) -> np.ndarray:
    """float32 (vertices, 1): a random number for each set of vertices that edges join."""
    from ....core.geometry.islands import island_roots  # a kernel: the exporters load without numba

    roots = island_roots(_edges(mesh), len(mesh.vertices))
    return random_of_words(hash_words(roots.astype(np.uint32)))


def pointiness(mesh) -> np.ndarray:
    """float32 (vertices, 1): the angle between the normal and the mean of the edges that leave
    a vertex, over 180 degrees, and the mean of this with the vertices around. Vertices at one
    place count as one."""
    positions = read_values(mesh.vertices, "co", 3, np.float32)
    _, one = np.unique(positions, axis=0, return_inverse=True)
    one, count = one.reshape(-1), int(one.max(initial=-1)) + 1
    places = np.empty((count, 3))
    places[one] = positions
    normals = _summed(read_values(mesh.vertex_normals, "vector", 3, np.float32), one, count)
    ends = np.unique(np.sort(one[_edges(mesh)], axis=1), axis=0)
    both, others = ends.ravel("F"), ends[:, ::-1].ravel("F")
    degree = np.bincount(both, minlength=count)
    leaving = _summed(_unit(places[others] - places[both]), both, count)
    mean = leaving / np.maximum(degree, 1)[:, None]
    cosine = (_unit(normals) * mean).sum(1)
    angle = np.where(degree > 0, np.arccos(np.clip(cosine, -1.0, 1.0)) / np.pi, 0.0)
    around = np.bincount(both, angle[others], count)
    return ((angle + around) / (degree + 1)).astype(np.float32)[one, None]


def _summed(vectors, rows, count) -> np.ndarray:
    """The sum of the vectors of each of count rows."""
    return np.stack([np.bincount(rows, axis, count) for axis in vectors.T], -1)


def _unit(vectors) -> np.ndarray:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0.0)

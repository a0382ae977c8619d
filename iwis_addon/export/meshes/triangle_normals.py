"""Lengths and normals in float32, where meshes have no area, or numbers that are none."""

from __future__ import annotations

import numpy as np

# Embree leaves out what lies farther: squares of distances would overflow.
FARTHEST = np.float32(1.8e18)
# Squared lengths below this lose digits in float32 or underflow.
TINY = np.float32(1e-30)


def squared_lengths(vectors):
    """Of vectors (last axis), and where neither underflow, overflow nor NaN spoils them."""
    squared = np.einsum("...i,...i->...", vectors, vectors)
    return squared, (squared > TINY) & (squared < np.inf)


def make_unit(vectors):
    """Scale vectors (last axis) to unit length in place; True where there was a direction."""
    squared, good = squared_lengths(vectors)
    np.copyto(squared, 1.0, where=~good)
    vectors /= np.sqrt(squared, out=squared)[..., None]
    return good


def geometric_normals(a, b, c):
    """Unit normals of triangles, and which of them have any: the others have no area.

    a, b, c: float32 (n, 3), corners. Where float32 overflows or underflows, float64 decides.
    """
    b, c = b - a, c - a
    normals = np.empty_like(a)
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(b[:, j], c[:, k], out=normals[:, i])
        normals[:, i] -= b[:, k] * c[:, j]
    good = make_unit(normals)
    rest = np.flatnonzero(~good)
    if len(rest):
        exact = np.cross(b[rest].astype(np.float64), c[rest].astype(np.float64))
        length = np.sqrt(np.einsum("ij,ij->i", exact, exact))
        has_area = (length > 0.0) & np.isfinite(length)
        good[rest] = has_area
        normals[rest[has_area]] = exact[has_area] / length[has_area, None]
    return normals, good


def usable_vertices(vertices):
    """bool (n,): rows of float32 (n, 3) that are numbers and not too far away to be rendered."""
    if len(vertices) and np.maximum(vertices.max(), -vertices.min()) <= FARTHEST:  # not if NaN
        return np.ones(len(vertices), bool)
    return (np.abs(vertices) <= FARTHEST).all(axis=1)

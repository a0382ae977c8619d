"""Points with a radius as spheres of triangles, in bulk. Needs no Blender.

Each sphere is an icosahedron, divided as often as its share of the surface of all earns it. Its
corners lie a little outside, so that from a mean direction it covers what the sphere would.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

# Triangles of all spheres together, as far as that is possible: a sphere has 20 at least.
_WANTED = 1 << 20
_LEAST_FACES, _MOST_DIVIDED = 20, 4


class Spheres(NamedTuple):
    """positions: float32 (n, 3); triangles: int32 (m, 3); normals: float32 (k, 3), unit;
    normal_index: int32 (m, 3), rows of normals; point: int32 (m,), whose sphere it is"""

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    normal_index: np.ndarray
    point: np.ndarray


class _Ball(NamedTuple):
    """corners: float32 (n, 3), unit; faces: int32 (m, 3), counterclockwise from outside;
    scale: of the corners, so that a fourth of the surface is that of a unit disk"""

    corners: np.ndarray
    faces: np.ndarray
    scale: float


def _icosahedron():
    g = (1.0 + 5.0**0.5) / 2.0
    corners = [(a, b * g, 0.0) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    corners = np.array([np.roll(c, k) for k in range(3) for c in corners])
    faces = []
    for a in range(12):
        for b in range(12):
            for c in range(12):
                p, q, r = corners[[a, b, c]]
                near = all(abs(np.linalg.norm(e) - 2.0) < 1e-9 for e in (p - q, q - r, r - p))
                if near and a < min(b, c) and np.cross(q - p, r - p) @ p > 0.0:
                    faces.append((a, b, c))
    return corners / np.linalg.norm(corners[0]), np.array(faces)


@functools.cache
def ball(divided: int) -> _Ball:
    """A unit sphere of 20 * 4^divided triangles."""
    corners, faces = _icosahedron()
    for _ in range(divided):
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        pairs, row = np.unique(edges, axis=0, return_inverse=True)
        middles = corners[pairs].mean(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        (a, b, c), (ab, bc, ca) = faces.T, (row.reshape(-1, 3) + len(corners)).T
        corners = np.concatenate([corners, middles])
        faces = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], -1).reshape(-1, 3)
    p, q, r = (corners[column] for column in faces.T)
    surface = 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1).sum()
    scale = float(np.sqrt(4.0 * np.pi / surface))
    return _Ball(corners.astype(np.float32), faces.astype(np.int32), scale)


def divisions(radii: np.ndarray) -> np.ndarray:
    """int64 (n,): how often each sphere is divided, by its part of the surface of all."""
    squares = radii.astype(np.float64) ** 2
    total = squares.sum()
    if not 0.0 < total < np.inf:
        return np.zeros(len(radii), np.int64)
    faces = np.maximum(_WANTED * squares / total, _LEAST_FACES)
    return np.clip(np.log2(faces / _LEAST_FACES) // 2, 0, _MOST_DIVIDED).astype(np.int64)


def count_triangles(divided: np.ndarray) -> int:
    """Of spheres that are divided so often."""
    return int((_LEAST_FACES * 4**divided).sum())


def make_spheres(centers: np.ndarray, radii: np.ndarray, divided: np.ndarray) -> Spheres:
    """centers: float32 (n, 3); radii: float32 (n,), > 0; divided: of ``divisions``"""
    parts, first, first_normal = [], 0, 0
    for level in np.unique(divided):
        rows, made = np.flatnonzero(divided == level), ball(int(level))
        n, k = len(rows), len(made.corners)
        positions = made.corners * (radii[rows] * np.float32(made.scale))[:, None, None]
        positions += centers[rows, None]
        steps = np.arange(first, first + n * k, k, dtype=np.int32)
        triangles = (made.faces + steps[:, None, None]).reshape(-1, 3)
        normals = np.broadcast_to(made.faces + np.int32(first_normal), (n, *made.faces.shape))
        owner = np.repeat(rows.astype(np.int32), len(made.faces))
        own = positions.reshape(-1, 3), triangles, made.corners, normals.reshape(-1, 3), owner
        parts.append(own)
        first, first_normal = first + n * k, first_normal + k
    if len(parts) == 1:
        return Spheres(*parts[0])
    return Spheres(*map(np.concatenate, zip(*parts, strict=True)))

"""Triangles two by two, as Embree's quads: half the hierarchy, and rays take less time.

Meshes of quads come as triangles of which two that follow each other share an edge. Embree treats
a quad (a, b, c, d) as the triangles (a, b, d) and (c, d, b); where two share no edge, one of them
stands alone as (a, b, c, c). docs/decisions/0031-triangles-in-pairs.md
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel

# Quads a triangle: with more, so many stand alone that the triangles themselves are faster.
_MOST_QUADS = 0.6
_ALONE = 9
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


class Pairs(NamedTuple):
    """The triangles of a mesh as quads, in the same order.

    corners: int32 (n, 4), vertices; first: int32 (n,), the first of a quad's two triangles, the
    second is the next one
    turn: uint8 (n,), which corner of the first triangle begins the quad, and three times which one
        of the second is opposite to it; 9: there is no second
    """

    corners: np.ndarray
    first: np.ndarray
    turn: np.ndarray


def paired(triangles: np.ndarray) -> Pairs | None:
    """Pairs of triangles, int32 (m, 3), that follow each other; None where too few do."""
    most = int(_MOST_QUADS * len(triangles))
    pairs = Pairs(np.empty((most, 4), np.int32), np.empty(most, np.int32), np.empty(most, np.uint8))
    n = _pair(triangles, *pairs)
    return None if n < 0 else Pairs(*(array[:n] for array in pairs))


@kernel
def _turn_of(triangles, t):
    """Pairs.turn of triangle t and the next one; 9 where they have no edge with two sides."""
    for a in range(3):
        one, other = triangles[t, (a + 1) % 3], triangles[t, (a + 2) % 3]
        for c in range(3):
            if triangles[t + 1, (c + 1) % 3] == other and triangles[t + 1, (c + 2) % 3] == one:
                return a + 3 * c
    return _ALONE


@kernel
def _pair(triangles, corners, first, turn):
    """Write Pairs; returns how many, or -1 where they have no room."""
    t, n = 0, 0
    while t < len(triangles):
        if n == len(first):
            return -1
        way = _turn_of(triangles, t) if t + 1 < len(triangles) else _ALONE
        a = 0 if way == _ALONE else way % 3
        first[n], turn[n] = t, way
        corners[n, 0], corners[n, 1] = triangles[t, a], triangles[t, (a + 1) % 3]
        last = triangles[t, (a + 2) % 3]
        corners[n, 2], corners[n, 3] = last, last
        if way != _ALONE:
            corners[n, 2] = triangles[t + 1, way // 3]
        t += 1 if way == _ALONE else 2
        n += 1
    return n


@kernel
def count_as_triangles(first, turn, hit, u, v):
    """Turn hits of quads into those of the triangles that they are made of, in place.

    first, turn: of Pairs; hit: int32 (n,), quads, -1 = none; u, v: float32 (n,), a quad's as
    Embree has them; then those that weigh a triangle's second and third corner
    """
    for k in range(len(hit)):
        if hit[k] < 0:
            continue
        quad = hit[k]
        way, b, c = turn[quad], u[k], v[k]
        corner, second = 0, 0
        if way != _ALONE:
            corner = way % 3
            if b + c > _ONE:
                corner, second = way // 3, 1
                b, c = _ONE - b, _ONE - c
        a = max(_ONE - b - c, _ZERO)
        hit[k] = first[quad] + second
        # The weights of three corners, of which the first one is the triangle's own ``corner``.
        u[k] = b if corner == 0 else (a if corner == 1 else c)
        v[k] = c if corner == 0 else (b if corner == 1 else a)

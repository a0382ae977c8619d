"""Which points are beside a face that shines, where samples of a lamp need those of the BSDF."""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..data.lamps import MESH

# Squared distance over the squared diagonal of a leaf, of four faces, within which it is near.
_NEAR = np.float32(2.25)
_ZERO = np.float32(0.0)


@kernel(forceinline=True)
def _squared_distance(box, position, p):
    """From point p to a node's box, 0 within."""
    squared = _ZERO
    for axis in range(3):
        x = position[p, axis]
        beyond = max(box[axis] - x, x - box[axis + 3], _ZERO)
        squared += beyond * beyond
    return squared


@kernel(forceinline=True)
def _squared_width(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * x + y * y + z * z


@kernel(forceinline=True)
def is_near_mesh(lamps, i, position, p):
    """Whether point p may be nearer to a face of a MESH than that is wide: of samples that are even
    over its area few are then where most of its light comes from.

    Asked of one leaf, on the way down to which each half is nearer than the other one.
    """
    if lamps.kind[i] != MESH:
        return False
    faces, node = lamps.faces, lamps.span[i, 2]
    while faces.leaves[node] > 1:
        node, other = node + 1, node + 2 * faces.leaves[node + 1]
        own = _squared_distance(faces.nodes[node], position, p)
        others = _squared_distance(faces.nodes[other], position, p)
        if others < own or (others == own and _is_smaller(faces.nodes, other, node)):
            node = other
    box = faces.nodes[node]
    return _squared_distance(box, position, p) < _NEAR * _squared_width(box)


@kernel(forceinline=True)
def _is_smaller(nodes, k, other):
    return _squared_width(nodes[k]) < _squared_width(nodes[other])


@kernel
def near_meshes(lamps, position, p):
    """Whether is_near_mesh is true of any lamp."""
    for i in range(len(lamps.kind)):
        if is_near_mesh(lamps, i, position, p):
            return True
    return False

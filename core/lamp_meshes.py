"""A place on the faces of a MESH that a point sees, its density, and where a direction meets them.

The face is found by going down a tree (emitter_tree.py): at each node by what its two halves may
bring to the point, power x cosine / squared distance, and nothing of what lies below the surface
[Conty18]. One number decides all the way down, so even numbers lie evenly over the mesh (two in
turn were no better). float64, as the other shapes, but for the promises.
"""

from __future__ import annotations

import math

import numpy as np

from ._jit import kernel
from .lamps import BLOCK, MESH

_NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1)
_MISSED = (0.0, 0.0, 0.0, -1)
# Widths of a face, were all of a lamp's alike, within which it is near.
_NEAR = np.float32(3.0)
_ZERO, _HALF, _TINY = np.float32(0.0), np.float32(0.5), np.float32(1e-24)


@kernel(forceinline=True)
def _corner(corners, k, c, px, py, pz):
    """A corner of face k, from a point."""
    return (
        np.float64(corners[k, c, 0]) - px,
        np.float64(corners[k, c, 1]) - py,
        np.float64(corners[k, c, 2]) - pz,
    )


@kernel(forceinline=True)
def _less(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel(forceinline=True)
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel(forceinline=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(forceinline=True)
def _promise(nodes, k, p, n):
    """What the faces below a node may bring to a surface at p with normal n; 0: nothing."""
    x, ex = _HALF * (nodes[k, 0] + nodes[k, 3]) - p[0], _HALF * (nodes[k, 3] - nodes[k, 0])
    y, ey = _HALF * (nodes[k, 1] + nodes[k, 4]) - p[1], _HALF * (nodes[k, 4] - nodes[k, 1])
    z, ez = _HALF * (nodes[k, 2] + nodes[k, 5]) - p[2], _HALF * (nodes[k, 5] - nodes[k, 2])
    height = n[0] * x + n[1] * y + n[2] * z + abs(n[0]) * ex + abs(n[1]) * ey + abs(n[2]) * ez
    if height <= _ZERO:
        return _ZERO
    squared = max(x * x + y * y + z * z, ex * ex + ey * ey + ez * ez, _TINY)
    far = math.sqrt(squared)
    return nodes[k, 6] * min(height, far) / (squared * far)


@kernel(forceinline=True)
def _first_half(faces, node, p, n):
    """(the chance of a node's first half, its second half's row); -1: neither brings anything."""
    other = node + 2 * faces.leaves[node + 1]
    own, others = _promise(faces.nodes, node + 1, p, n), _promise(faces.nodes, other, p, n)
    total = np.float64(own) + others
    return (own / total if total > 0.0 else -1.0), other


@kernel(forceinline=True)
def _power_of_leaf(faces, leaf):
    total = 0.0
    for k in range(leaf * BLOCK, leaf * BLOCK + BLOCK):
        total += faces.power[k]
    return total


@kernel
def _draw_face(faces, node, leaf, p, n, a):
    """(a face below a node, its chance, a number that is even again); chance 0: none."""
    chance = 1.0
    while faces.leaves[node] > 1:
        share, other = _first_half(faces, node, p, n)
        if share < 0.0:
            return 0, 0.0, a
        if a < share:
            a, chance, node = a / share, chance * share, node + 1
        else:
            a, chance = (a - share) / max(1.0 - share, 1e-300), chance * (1.0 - share)
            leaf, node = leaf + faces.leaves[node + 1], other
    total = _power_of_leaf(faces, leaf)
    k, last, a = leaf * BLOCK, leaf * BLOCK + BLOCK - 1, a * total
    while k < last and a >= faces.power[k]:
        a -= faces.power[k]
        k += 1
    power = faces.power[k]
    if not power > 0.0:  # by rounding: the filling of a block
        return 0, 0.0, a
    return k, chance * power / total, min(a / power, 1.0)


@kernel
def _chance_of(faces, node, leaf, k, p, n):
    """The chance that _draw_face has of face k."""
    chance, wanted = 1.0, k // BLOCK
    while faces.leaves[node] > 1:
        share, other = _first_half(faces, node, p, n)
        middle = leaf + faces.leaves[node + 1]
        if wanted < middle:
            chance, node = chance * share, node + 1
        else:
            chance, leaf, node = chance * (1.0 - share), middle, other
        if not chance > 0.0:
            return 0.0
    return chance * faces.power[k] / _power_of_leaf(faces, leaf)


@kernel(forceinline=True)
def _float32(x, y, z):
    return np.float32(x), np.float32(y), np.float32(z)


@kernel
def sample_mesh(lamps, i, px, py, pz, nx, ny, nz, a, b):
    """sample_lamp of a MESH, and the row of its radiance: 2 face + (1: its back); -1: none."""
    faces, p, n = lamps.faces, _float32(px, py, pz), _float32(nx, ny, nz)
    root, leaf = lamps.span[i, 2], lamps.span[i, 0] // BLOCK
    k, chance, a = _draw_face(faces, root, leaf, p, n, a)
    if not chance > 0.0:
        return _NOTHING
    origin = _corner(faces.corners, k, 0, px, py, pz)
    side = _less(_corner(faces.corners, k, 1, px, py, pz), origin)
    other = _less(_corner(faces.corners, k, 2, px, py, pz), origin)
    a = math.sqrt(a)
    u, v = a * (1.0 - b), a * b
    x = origin[0] + u * side[0] + v * other[0]
    y = origin[1] + u * side[1] + v * other[1]
    z = origin[2] + u * side[2] + v * other[2]
    normal = _cross(side, other)
    far = math.sqrt(x * x + y * y + z * z)
    length = math.sqrt(_dot(normal, normal))
    slope = _dot(normal, (x, y, z))  # far x length x cosine, negative: its front
    if not abs(slope) > 1e-9 * far * length:
        return _NOTHING
    scale = 1.0 / far
    pdf = 2.0 * chance * far * far * far / abs(slope)  # length / 2 is the area
    row = 2 * k + (1 if slope > 0.0 else 0)
    return x * scale, y * scale, z * scale, far, 1.0, pdf, row


@kernel(forceinline=True)
def _meet_face(corners, k, px, py, pz, ray):
    """(distance along a ray to face k, slope) [Moller97]; distance 0: it misses.

    slope: twice the area times the cosine, negative where the ray meets the front
    """
    origin = _corner(corners, k, 0, px, py, pz)
    side = _less(_corner(corners, k, 1, px, py, pz), origin)
    other = _less(_corner(corners, k, 2, px, py, pz), origin)
    normal = _cross(side, other)
    length, slope = math.sqrt(_dot(normal, normal)), _dot(normal, ray)
    if not abs(slope) > 1e-9 * length:
        return 0.0, 0.0
    turned = _cross(origin, ray)
    u, v = _dot(turned, other) / slope, -_dot(turned, side) / slope
    if u < 0.0 or v < 0.0 or u + v > 1.0:
        return 0.0, 0.0
    return _dot(origin, normal) / slope, slope


@kernel(forceinline=True)
def _inverse(x):
    return 1.0 / x if abs(x) > 1e-30 else 1e30


@kernel(forceinline=True)
def _meets_box(nodes, k, px, py, pz, inverse, nearest):
    """Whether a ray passes through a node's box before it is ``nearest`` away."""
    x0, x1 = (nodes[k, 0] - px) * inverse[0], (nodes[k, 3] - px) * inverse[0]
    y0, y1 = (nodes[k, 1] - py) * inverse[1], (nodes[k, 4] - py) * inverse[1]
    z0, z1 = (nodes[k, 2] - pz) * inverse[2], (nodes[k, 5] - pz) * inverse[2]
    start = max(min(x0, x1), min(y0, y1), min(z0, z1), 0.0)
    end = min(max(x0, x1), max(y0, y1), max(z0, z1), nearest)
    return start <= end * 1.0000001


@kernel
def _nearest_face(faces, node, leaf, px, py, pz, ray):
    """(distance, slope, face) of the nearest face below a node; -1: none."""
    inverse = _inverse(ray[0]), _inverse(ray[1]), _inverse(ray[2])
    nearest, slope, found = np.inf, 1.0, -1
    end = node + 2 * faces.leaves[node] - 1
    while node < end:
        leaves = faces.leaves[node]
        if not _meets_box(faces.nodes, node, px, py, pz, inverse, nearest):
            leaf, node = leaf + leaves, node + 2 * leaves - 1
            continue
        if leaves == 1:
            for k in range(leaf * BLOCK, leaf * BLOCK + BLOCK):
                far, steep = _meet_face(faces.corners, k, px, py, pz, ray)
                if 0.0 < far < nearest:
                    nearest, slope, found = far, steep, k
            leaf += 1
        node += 1
    return nearest, slope, found


@kernel
def meet_mesh(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz):
    """meet_lamp of a MESH: its nearest face, and the row of its radiance as of sample_mesh."""
    faces, root, leaf = lamps.faces, lamps.span[i, 2], lamps.span[i, 0] // BLOCK
    far, slope, k = _nearest_face(faces, root, leaf, px, py, pz, (dx, dy, dz))
    if k < 0:
        return _MISSED
    chance = _chance_of(faces, root, leaf, k, _float32(px, py, pz), _float32(nx, ny, nz))
    pdf = 2.0 * chance * far * far / abs(slope)
    return far, 1.0, pdf, 2 * k + (1 if slope > 0.0 else 0)


@kernel(forceinline=True)
def is_near_mesh(lamps, i, position, p):
    """Whether point p may be nearer to a face of a MESH than that is wide: of samples that are even
    over its area few are then where most of its light comes from."""
    if lamps.kind[i] != MESH:
        return False
    box, squared = lamps.faces.nodes[lamps.span[i, 2]], _ZERO
    for axis in range(3):
        x = position[p, axis]
        beyond = max(box[axis] - x, x - box[axis + 3], _ZERO)
        squared += beyond * beyond
    width = _NEAR * lamps.size[i, 0]
    return squared * np.float32(lamps.span[i, 1] - lamps.span[i, 0]) < width * width


@kernel
def near_meshes(lamps, position, p):
    """Whether is_near_mesh is true of any lamp."""
    for i in range(len(lamps.kind)):
        if is_near_mesh(lamps, i, position, p):
            return True
    return False

"""A place on the faces of a MESH that a point sees, its density, and where a direction meets them.

The face is found by going down a tree (emitter_tree.py): at each node by what its two halves may
bring to the point, power x cosines / squared distance, and nothing of what lies below the surface
[Conty18]; at a leaf by what each face does. One number decides all the way down, so even numbers
lie evenly over the mesh (two in turn were no better). float64, as the other shapes, but for the
promises of nodes.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..data.lamps import BLOCK

_NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1)
_MISSED = (0.0, 0.0, 0.0, -1)
_ZERO, _HALF, _TINY = np.float32(0.0), np.float32(0.5), np.float32(1e-24)
_TWO, _LEAST = np.float32(2.0), np.float32(0.02)


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
    size = ex * ex + ey * ey + ez * ez
    squared = max(x * x + y * y + z * z, size, _TINY)
    far = math.sqrt(squared)
    return nodes[k, 6] * min(height, far) * _turned(nodes, k, x, y, z, size) / (squared * squared)


@kernel(forceinline=True)
def _turned(nodes, k, x, y, z, size):
    """Mean cosine of a node's faces towards a point, times the distance; x, y, z: from the point
    to its middle; size: square of the box's half diagonal. More than 0.

    The root mean square in place of the mean of |n d|, a little more as the box is near; less what
    the sides that shine more, or are not hidden, are turned away.
    """
    squares = x * x * nodes[k, 7] + y * y * nodes[k, 8] + z * z * nodes[k, 9]
    squares += _TWO * (x * y * nodes[k, 10] + x * z * nodes[k, 11] + y * z * nodes[k, 12])
    away = x * nodes[k, 13] + y * nodes[k, 14] + z * nodes[k, 15]
    both = math.sqrt(max(squares, _ZERO) + size)
    return max(both - away, _LEAST * both) + _TINY


@kernel(forceinline=True)
def _first_half(faces, node, p, n):
    """(the chance of a node's first half, its second half's row); -1: neither brings anything."""
    other = node + 2 * faces.leaves[node + 1]
    own, others = _promise(faces.nodes, node + 1, p, n), _promise(faces.nodes, other, p, n)
    total = np.float64(own) + others
    return (own / total if total > 0.0 else -1.0), other


@kernel(forceinline=True)
def _face_promise(faces, k, px, py, pz, n):
    """What face k may bring to a surface at a point with normal n; 0: nothing."""
    origin = _corner(faces.corners, k, 0, px, py, pz)
    side = _less(_corner(faces.corners, k, 1, px, py, pz), origin)
    other = _less(_corner(faces.corners, k, 2, px, py, pz), origin)
    normal = _cross(side, other)
    length, slope = math.sqrt(_dot(normal, normal)), _dot(normal, origin)
    high, first, second = _dot(n, origin), _dot(n, side), _dot(n, other)
    height = high + max(0.0, first, second)
    power = faces.power[k, 1] if slope > 0.0 else faces.power[k, 0]
    if not (height > 0.0 and abs(slope) > 0.0 and power > 0.0):
        return 0.0
    third = 1.0 / 3.0
    x = origin[0] + third * (side[0] + other[0])
    y = origin[1] + third * (side[1] + other[1])
    z = origin[2] + third * (side[2] + other[2])
    squared = max(x * x + y * y + z * z, 0.25 * length)
    near = max(math.sqrt(squared) - math.sqrt(length), 0.0)  # to its nearest place, about
    above = abs(slope) / length
    cosines = above / max(near, above) * (height / max(near, height))
    return power * cosines / squared


@kernel(forceinline=True)
def _leaf_promises(faces, leaf, place, n):
    """(_face_promise of each of a leaf's four faces, their sum)."""
    k = leaf * BLOCK
    one, two = _face_promise(faces, k, *place, n), _face_promise(faces, k + 1, *place, n)
    three, four = _face_promise(faces, k + 2, *place, n), _face_promise(faces, k + 3, *place, n)
    return (one, two, three, four), one + two + three + four


@kernel
def _draw_face(faces, node, leaf, place, p, n, a):
    """(a face below a node, its chance, a number that is even again); chance 0: none.

    place: the point in float64; p, n: it and its normal in float32
    """
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
    promises, total = _leaf_promises(faces, leaf, place, n)
    found, own, a, below = -1, 0.0, a * total, 0.0
    for k in range(BLOCK):
        if promises[k] > 0.0 and (found < 0 or a >= below):
            found, own, a, below = k, promises[k], a - below, promises[k]
    if found < 0:
        return 0, 0.0, a
    return leaf * BLOCK + found, chance * own / total, min(a / own, 1.0)


@kernel
def _chance_of(faces, node, leaf, k, place, p, n):
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
    promises, total = _leaf_promises(faces, wanted, place, n)
    return chance * promises[k - wanted * BLOCK] / total if total > 0.0 else 0.0


@kernel(forceinline=True)
def _float32(x, y, z):
    return np.float32(x), np.float32(y), np.float32(z)


@kernel
def sample_mesh(lamps, i, px, py, pz, nx, ny, nz, a, b):
    """sample_lamp of a MESH, and the row of its radiance: 2 face + (1: its back); -1: none."""
    faces, p, n = lamps.faces, _float32(px, py, pz), _float32(nx, ny, nz)
    root, leaf = lamps.span[i, 2], lamps.span[i, 0] // BLOCK
    k, chance, a = _draw_face(faces, root, leaf, (px, py, pz), p, n, a)
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
def _nearest_face(faces, node, leaf, px, py, pz, ray, beyond):
    """(distance, slope, face) of the nearest face below a node farther than that; -1: none."""
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
                if beyond < far < nearest:
                    nearest, slope, found = far, steep, k
            leaf += 1
        node += 1
    return nearest, slope, found


@kernel
def meet_mesh(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz, beyond):
    """meet_lamp of a MESH: its nearest face farther than ``beyond``, and the row of its radiance as
    of sample_mesh."""
    faces, root, leaf = lamps.faces, lamps.span[i, 2], lamps.span[i, 0] // BLOCK
    far, slope, k = _nearest_face(faces, root, leaf, px, py, pz, (dx, dy, dz), beyond)
    if k < 0:
        return _MISSED
    p, n = _float32(px, py, pz), _float32(nx, ny, nz)
    chance = _chance_of(faces, root, leaf, k, (px, py, pz), p, n)
    pdf = 2.0 * chance * far * far / abs(slope)
    return far, 1.0, pdf, 2 * k + (1 if slope > 0.0 else 0)

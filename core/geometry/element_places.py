"""Places on triangles and in objects' own space: kernels of core/nodes/context.py."""

from __future__ import annotations

import numpy as np

from .._jit import kernel

_ONE = np.float32(1.0)


@kernel(forceinline=True)
def _in_plane(vertices, triangles, t, x, y, z):
    """What an offset in the plane of triangle t adds to the weights of its second and third corner.

    All float64; (0, 0) of a triangle without an area.
    """
    bb = bc = cc = ob = oc = 0.0
    offset = x, y, z
    for k in range(3):
        a = np.float64(vertices[triangles[t, 0], k])
        b, c = vertices[triangles[t, 1], k] - a, vertices[triangles[t, 2], k] - a
        bb, bc, cc = bb + b * b, bc + b * c, cc + c * c
        ob, oc = ob + offset[k] * b, oc + offset[k] * c
    whole = bb * cc - bc * bc
    inverse = 1.0 / whole if whole != 0.0 else 0.0
    return (cc * ob - bc * oc) * inverse, (bb * oc - bc * ob) * inverse


@kernel
def barycentric_at(vertices, triangles, triangle, position, out):
    """Write weights of the second and third corner, float32 (n, 2), 0 to 1, at places on triangles.

    vertices: float32 (m, 3); triangles: int32 (k, 3); triangle: int32 (n,); position: float32
    (n, 3)
    """
    for n in range(len(triangle)):
        t = triangle[n]
        first = triangles[t, 0]
        x = np.float64(position[n, 0]) - vertices[first, 0]
        y = np.float64(position[n, 1]) - vertices[first, 1]
        z = np.float64(position[n, 2]) - vertices[first, 2]
        u, v = _in_plane(vertices, triangles, t, x, y, z)
        out[n, 0], out[n, 1] = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)


@kernel
def move_barycentric(vertices, triangles, triangle, offset, out):
    """Add to weights, float32 (n, 2), what an offset, float32 (n, 3), in the planes does."""
    for n in range(len(triangle)):
        x, y, z = np.float64(offset[n, 0]), np.float64(offset[n, 1]), np.float64(offset[n, 2])
        u, v = _in_plane(vertices, triangles, triangle[n], x, y, z)
        out[n, 0] += u
        out[n, 1] += v


@kernel
def interpolate(table, row, triangle, flipped, barycentric, out):
    """Write values of corners at points of triangles, float32 (n, width).

    table: float32 (rows, 3, width); row: int32, one a triangle, -1 = 0 everywhere; flipped: bool
    (n,), whether the second corner of the table is the triangle's third
    """
    for n in range(len(triangle)):
        r = row[triangle[n]]
        u, v = barycentric[n, 0], barycentric[n, 1]
        if flipped[n]:
            u, v = v, u
        for k in range(out.shape[1]):
            value = np.float32(0.0)
            if r >= 0:  # by differences: what is equal at all three corners stays as it is
                first = table[r, 0, k]
                value = first + u * (table[r, 1, k] - first) + v * (table[r, 2, k] - first)
            out[n, k] = value


@kernel
def invert(matrices, which, done, out):
    """Write the inverses of those matrices that are needed; of one that has none, that of 1.

    matrices, out: float64 (m, 4, 4), last row 0, 0, 0, 1; which: int32 (n,); done: bool (m,), False
    """
    for n in range(len(which)):
        m = which[n]
        if done[m]:
            continue
        done[m] = True
        a, b = matrices[m], out[m]
        whole = 0.0
        for k in range(3):
            j, i = (k + 1) % 3, (k + 2) % 3
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                b[c, k] = a[j, d] * a[i, e] - a[j, e] * a[i, d]
            whole += a[k, 0] * b[0, k]
        for c in range(3):
            for k in range(3):
                b[c, k] = b[c, k] / whole if whole != 0.0 else np.float64(c == k)
        for c in range(3):
            b[3, c] = 0.0
            moved = 0.0
            for k in range(3):
                moved -= b[c, k] * a[k, 3]
            b[c, 3] = moved if whole != 0.0 else 0.0
        b[3, 3] = 1.0


@kernel(forceinline=True)
def _turned(matrices, m, x, y, z, k, transposed):
    if transposed:
        return matrices[m, 0, k] * x + matrices[m, 1, k] * y + matrices[m, 2, k] * z
    return matrices[m, k, 0] * x + matrices[m, k, 1] * y + matrices[m, k, 2] * z


@kernel
def turn(matrices, which, vectors, transposed, unit, out):
    """Write vectors turned by the upper left of matrices, float32 (n, 3).

    matrices: float64 (m, 4, 4); which: int32 (n,), of each; vectors: float32 (n, 3)
    unit: whether to make them as long as 1; 0 stays 0
    """
    for n in range(len(which)):
        m, size = which[n], 0.0
        x, y, z = vectors[n, 0], vectors[n, 1], vectors[n, 2]
        for k in range(3):
            value = _turned(matrices, m, x, y, z, k, transposed)
            out[n, k] = value
            size += value * value
        if unit and size > 0.0:
            scale = np.float32(1.0 / np.sqrt(size))
            for k in range(3):
                out[n, k] *= scale


@kernel
def place(matrices, which, positions, out):
    """Write positions moved by whole matrices; as turn."""
    for n in range(len(which)):
        m = which[n]
        x, y, z = positions[n, 0], positions[n, 1], positions[n, 2]
        for k in range(3):
            out[n, k] = _turned(matrices, m, x, y, z, k, False) + matrices[m, k, 3]


@kernel
def corner_normals_at(corner_normals, triangle, barycentric, matrices, which, out):
    """Write the corners' normals, turned by transposed matrices and made unit, interpolated.

    corner_normals: float32 (k, 3, 3); float32 (n, 3), shorter than 1 between corners that differ
    """
    for n in range(len(triangle)):
        t, m = triangle[n], which[n]
        u, v = barycentric[n, 0], barycentric[n, 1]
        for k in range(3):
            out[n, k] = 0.0
        for corner in range(3):
            x = corner_normals[t, corner, 0]
            y = corner_normals[t, corner, 1]
            z = corner_normals[t, corner, 2]
            a = _turned(matrices, m, x, y, z, 0, True)
            b = _turned(matrices, m, x, y, z, 1, True)
            c = _turned(matrices, m, x, y, z, 2, True)
            size = a * a + b * b + c * c
            weight = np.float64(u if corner == 1 else (v if corner == 2 else _ONE - u - v))
            weight = weight / np.sqrt(size) if size > 0.0 else 0.0
            out[n, 0] += weight * a
            out[n, 1] += weight * b
            out[n, 2] += weight * c

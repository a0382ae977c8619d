"""Shadow rays of coarse smooth meshes start on the surface that their normals promise [Hanika21].

A smooth normal lets a facet be lit from directions in which it, or its neighbours, hide the sun:
dark facets along the terminator. Blender's objects have a "Shadow Terminator Geometry Offset"
against it: rays that graze the surface by less than that start a little above the facet, on a
parabolic patch through its corners that follows the corner normals; from there a ray may also go
below the facet's own plane. Heights and cut-off are those of Cycles.
"""

import numpy as np

from .._jit import kernel

ZERO, HALF, ONE, TWO = (np.float32(x) for x in (0.0, 0.5, 1.0, 2.0))


@kernel(forceinline=True)
def _along(vertices, i, j, normals, triangle, corner, side):
    """How far vertex j is above vertex i along a corner's normal (on the viewer's side)."""
    height = ZERO
    for a in range(3):
        height += (vertices[j, a] - vertices[i, a]) * normals[triangle, corner, a]
    return height * side


@kernel(forceinline=True)
def _bend(vertices, i, j, normals, triangle, corner_i, corner_j, side):
    """How much the normals turn along the edge from vertex i to j: > 0 where it is convex."""
    return _along(vertices, i, j, normals, triangle, corner_j, side) - _along(
        vertices, i, j, normals, triangle, corner_i, side
    )


@kernel(forceinline=True)
def _envelope(vertices, i, j, k, normals, triangle, corner, position, p, side):
    """Height over the point of the plane that touches the patch at corner i, raised to j and k."""
    rise = max(
        _along(vertices, i, j, normals, triangle, corner, side),
        _along(vertices, i, k, normals, triangle, corner, side),
    )
    height = max(rise, ZERO)
    for a in range(3):
        height += (vertices[i, a] - position[p, a]) * normals[triangle, corner, a] * side
    return max(height, ZERO)


@kernel
def patch_height(vertices, i0, i1, i2, normals, triangle, bu, bv, position, p, side):
    """Height of the smooth patch over shading point p, metres >= 0, 0 on flat faces.

    i0, i1, i2: the triangle's vertices; bu, bv: weights of i1 and i2; side: 1 or -1, turns the
    corner normals float32 (m, 3, 3) to the viewer
    """
    bw = ONE - bu - bv
    across = _bend(vertices, i0, i1, normals, triangle, 0, 1, side)
    down = _bend(vertices, i1, i2, normals, triangle, 1, 2, side)
    back = _bend(vertices, i0, i2, normals, triangle, 0, 2, side)
    parabola = across * bw * bu + down * bu * bv + back * bw * bv
    h0 = _envelope(vertices, i0, i1, i2, normals, triangle, 0, position, p, side)
    h1 = _envelope(vertices, i1, i0, i2, normals, triangle, 1, position, p, side)
    h2 = _envelope(vertices, i2, i0, i1, normals, triangle, 2, position, p, side)
    return max(min(min(h0, h1), h2), parabola * HALF)


@kernel(forceinline=True)
def lift_share(cos_face, cos_shading, below):
    """How much of the patch's height a ray gets, 0 ... 1; below: the object's offset, > 0."""
    share = ONE - cos_face / below
    if cos_shading < below:
        share = TWO - (cos_face + cos_shading) / below
    return min(max(share, ZERO), ONE)

"""Direction <-> square: the two area-preserving maps that the wavelets live on.

The sphere: Clarberg's equal-area octahedral map [Clarberg08], density 4 pi everywhere. The
hemisphere: concentric disc [ShirleyChiu97] lifted by z = 1 - r^2, density 2 pi everywhere. So a
cell of a 2^n grid covers 4 pi / 4^n (2 pi / 4^n) steradians and cell averages are all that the Haar
transform needs: no Jacobian.

The square's x runs right with columns, its y down with rows, both in [0, 1].
"""

import math

import numpy as np

from .._jit import kernel

PI = math.pi
# No corner of a cell of a grid over the sphere's square is farther from its centre than this many
# radii of a disc of its solid angle (measured).
CELL_REACH = 2.15


@kernel(forceinline=True)
def square_to_sphere(x, y):
    """The unit direction (dx, dy, dz), float64, of a point of the square."""
    u = 2.0 * x - 1.0
    v = 2.0 * y - 1.0
    abs_u, abs_v = abs(u), abs(v)
    signed = 1.0 - abs_u - abs_v
    r = 1.0 - abs(signed)
    phi = (0.25 * PI) if r == 0.0 else ((abs_v - abs_u) / r + 1.0) * (0.25 * PI)
    z = 1.0 - r * r
    if signed < 0.0:
        z = -z
    radius = r * math.sqrt(max(0.0, 2.0 - r * r))
    return math.copysign(math.cos(phi), u) * radius, math.copysign(math.sin(phi), v) * radius, z


@kernel(forceinline=True)
def sphere_to_square(dx, dy, dz):
    """The point (x, y), float64, of a unit direction; inverse of square_to_sphere."""
    r = math.sqrt(max(0.0, 1.0 - abs(dz)))
    v = (2.0 / PI) * math.atan2(abs(dy), abs(dx)) * r
    u = r - v
    if dz < 0.0:
        u, v = 1.0 - v, 1.0 - u
    return 0.5 * (math.copysign(u, dx) + 1.0), 0.5 * (math.copysign(v, dy) + 1.0)


@kernel
def square_to_hemisphere(x, y):
    """The unit direction (dx, dy, dz >= 0), float64, local frame, of a point of the square."""
    u = 2.0 * x - 1.0
    v = 2.0 * y - 1.0
    if u == 0.0 and v == 0.0:
        return 0.0, 0.0, 1.0
    if abs(u) > abs(v):
        r, phi = u, (0.25 * PI) * (v / u)
    else:
        r, phi = v, 0.5 * PI - (0.25 * PI) * (u / v)
    radius = r * math.sqrt(max(0.0, 2.0 - r * r))
    return math.cos(phi) * radius, math.sin(phi) * radius, 1.0 - r * r


@kernel
def hemisphere_to_square(dx, dy, dz):
    """The point (x, y), float64, of a unit direction with dz >= 0."""
    r = math.sqrt(max(0.0, 1.0 - dz))
    if dx == 0.0 and dy == 0.0:
        return 0.5, 0.5
    phi = math.atan2(dy, dx)
    if phi < -0.25 * PI:
        phi += 2.0 * PI
    if phi < 0.25 * PI:
        u, v = r, phi * r / (0.25 * PI)
    elif phi < 0.75 * PI:
        u, v = -(phi - 0.5 * PI) * r / (0.25 * PI), r
    elif phi < 1.25 * PI:
        u, v = -r, (phi - PI) * r / (-0.25 * PI)
    else:
        u, v = (phi - 1.5 * PI) * r / (0.25 * PI), -r
    return 0.5 * (u + 1.0), 0.5 * (v + 1.0)


@kernel
def fill_sphere_grid(side, directions):
    """Write the directions of the cell centres of a side x side grid, row by row.

    directions: float32 (side * side, 3), written
    """
    for i in range(side):
        for j in range(side):
            x, y, z = square_to_sphere((j + 0.5) / side, (i + 0.5) / side)
            k = i * side + j
            directions[k, 0], directions[k, 1], directions[k, 2] = x, y, z


@kernel
def fill_hemisphere_grid(side, directions):
    """Write the local directions of the cell centres of a side x side grid, row by row.

    directions: float32 (side * side, 3), written
    """
    for i in range(side):
        for j in range(side):
            x, y, z = square_to_hemisphere((j + 0.5) / side, (i + 0.5) / side)
            k = i * side + j
            directions[k, 0], directions[k, 1], directions[k, 2] = x, y, z


def sphere_grid(side: int) -> np.ndarray:
    """float32 (side * side, 3): directions of the sphere's cell centres, row by row."""
    directions = np.empty((side * side, 3), np.float32)
    fill_sphere_grid(side, directions)
    return directions


def hemisphere_grid(side: int) -> np.ndarray:
    """float32 (side * side, 3): local directions of the hemisphere's cell centres, row by row."""
    directions = np.empty((side * side, 3), np.float32)
    fill_hemisphere_grid(side, directions)
    return directions

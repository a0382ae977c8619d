"""Places, normals and values of what was made of patches."""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from .dicing import part_at, place_on
from .micropolygons import Micropolygons

_ZERO, _ONE, _THREE = np.float32(0.0), np.float32(1.0), np.float32(3.0)


@kernel
def _cubic(t, k):
    q = _ONE - t
    if k == 0:
        return q * q * q
    if k == 1:
        return _THREE * t * q * q
    return _THREE * t * t * q if k == 2 else t * t * t


@kernel
def _square(t, k):
    q = _ONE - t
    return q * q if k == 0 else (np.float32(2.0) * t * q if k == 1 else t * t)


@kernel(allocates=True)
def _evaluate(surface, patch, uv, places, normals):
    along, across = np.empty(3, np.float32), np.empty(3, np.float32)
    for k in range(len(patch)):
        f, u, v = patch[k], uv[k, 0], uv[k, 1]
        if f < 0:
            continue
        places[k, 0], places[k, 1], places[k, 2] = place_on(surface, f, u, v)
        f, u, v = part_at(surface[1], f, u, v)
        p = surface[0][f]
        along[:], across[:] = _ZERO, _ZERO
        for i in range(4):
            for j in range(3):
                a, b = _cubic(v, i) * _square(u, j), _cubic(u, i) * _square(v, j)
                for axis in range(3):
                    along[axis] += a * (p[i, j + 1, axis] - p[i, j, axis])
                    across[axis] += b * (p[j + 1, i, axis] - p[j, i, axis])
        x = along[1] * across[2] - along[2] * across[1]
        y = along[2] * across[0] - along[0] * across[2]
        z = along[0] * across[1] - along[1] * across[0]
        length = np.sqrt(x * x + y * y + z * z)
        if length > _ZERO:
            normals[k, 0], normals[k, 1], normals[k, 2] = x / length, y / length, z / length


def evaluate(points: np.ndarray, steps: int, made: Micropolygons) -> tuple[np.ndarray, np.ndarray]:
    """float32 (n, 3) each: places of vertices, and unit normals, 0 where there is none.

    points, steps: of Patches
    """
    patch, uv = made.vertex_patch, made.vertex_uv
    places, normals = (np.zeros((len(patch), 3), np.float32) for _ in range(2))
    _evaluate((points, steps), patch, uv, places, normals)
    return places, normals


@kernel
def _mix_corners(values, steps, patch, uv, out):
    for row in range(len(patch)):
        for k in range(3):
            f, u, v = part_at(steps, patch[row], uv[row, k, 0], uv[row, k, 1])
            for axis in range(values.shape[2]):
                low = values[f, 0, axis] + u * (values[f, 1, axis] - values[f, 0, axis])
                high = values[f, 3, axis] + u * (values[f, 2, axis] - values[f, 3, axis])
                out[row, k, axis] = low + v * (high - low)


def at_corners(values: np.ndarray, made: Micropolygons, steps: int = 0) -> np.ndarray:
    """float32 (m, 3, d): values of corners of patches, or of their parts after some steps, float32
    (f, 4, d), at those of triangles."""
    out = np.empty((len(made.patch), 3, values.shape[2]), np.float32)
    _mix_corners(np.ascontiguousarray(values, np.float32), steps, made.patch, made.uv, out)
    return out


def at_vertices(values: np.ndarray, made: Micropolygons) -> np.ndarray:
    """float32 (n, d): the same at vertices; of those on no patch those of the first one."""
    values, at = values.astype(np.float32), np.maximum(made.vertex_patch, 0)
    u, v = made.vertex_uv[:, :1], made.vertex_uv[:, 1:]
    low = values[at, 0] * (1 - u) + values[at, 1] * u
    return low * (1 - v) + (values[at, 3] * (1 - u) + values[at, 2] * u) * v

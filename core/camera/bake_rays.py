"""The rays of a bake: each ends at the point of a surface that a texel stands for.

As Cycles': a texel's rays fill its square, what leaves the triangle comes back into it, and a point
is seen from along its normal; or from the camera, as far as that is in front of the surface.
"""

from __future__ import annotations

import numpy as np

from ..data.bake_points import BakePoints
from ..geometry.shading import ShadingPoints, shading_points
from ..scene import ORTHOGRAPHIC, Camera

_INWARD = np.float32(1e-3)  # from a corner, where several faces meet, to the triangle's middle
_GRAZING = np.float32(0.2)  # the least cosine that a camera sees a point at
_ABOVE = np.float32(1e-5)  # the same of the face itself


def bake_hits(bake: BakePoints, x: np.ndarray, y: np.ndarray):
    """(triangle, u, v), int32 and float32 (n,), as an Accel's hits, at places of the image.

    x, y: float64 (n,), texels from its lower left corner; nothing is hit outside of it
    """
    height, width = bake.triangle.shape
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    at = np.where(inside, row * width + column, 0)
    triangle = np.where(inside, bake.triangle.reshape(-1)[at], np.int32(-1))
    aside, up = (x - column - 0.5).astype(np.float32), (y - row - 0.5).astype(np.float32)
    first, second = bake.weights.reshape(-1, 2)[at].T
    steps = bake.steps.reshape(-1, 4)[at]
    first, second = _off_corners(first, second)
    first = _folded(first + steps[:, 0] * aside + steps[:, 1] * up, np.float32(1.0))
    second = _folded(second + steps[:, 2] * aside + steps[:, 3] * up, 1 - first)
    third = np.maximum(np.float32(1.0) - first - second, np.float32(0.0))
    return triangle, *((third, second) if bake.mirrored else (second, third))


def _off_corners(first, second):
    """Weights of points at a corner, a little inward: they start no ray in the faces beside it."""
    corner = np.isin(first, (0.0, 1.0)) & np.isin(second, (0.0, 1.0))
    third = np.float32(1.0 / 3.0)
    return (np.where(corner, w + _INWARD * (third - w), w) for w in (first, second))


def _folded(weight: np.ndarray, most) -> np.ndarray:
    """Weights brought back into 0 ... most, as in a mirror at either end."""
    part = np.divide(weight, most, out=np.zeros_like(weight), where=np.asarray(most) > 0.0)
    whole = np.floor(part)
    part = part - whole
    return np.where(whole.astype(np.int64) & 1, 1 - part, part) * most


def bake_rays(bake: BakePoints, camera: Camera, x: np.ndarray, y: np.ndarray):
    """(origins, directions, reach, hits): the arrays of CameraRays; directions are 0 where a texel
    shows nothing. camera: whose place counts, with bake.from_camera"""
    hits = bake_hits(bake, x, y)
    n = len(x)
    origins, directions = (np.zeros((n, 3), np.float32) for _ in range(2))
    points = shading_points(bake.mesh, *hits, directions)  # that look at nothing: front sides
    wo = _towards_camera(camera, points) if bake.from_camera else points.normal
    directions[points.pixel] = -wo
    origins[points.pixel] = points.position + wo
    reach = np.where(hits[0] >= 0, np.float32(np.inf), np.float32(0.0))
    return origins, directions, reach, hits


def _towards_camera(camera: Camera, points: ShadingPoints) -> np.ndarray:
    """float32 (n, 3), unit: from points to the camera, those behind to their normal, by degrees."""
    place = np.asarray(camera.camera_to_world, np.float64)
    if camera.kind == ORTHOGRAPHIC:
        wo = np.broadcast_to(place[:3, 2].astype(np.float32), points.position.shape)
    else:
        wo = _unit((place[:3, 3] - points.position).astype(np.float32))
    normal = points.normal
    cosine = _dot(wo, normal)
    wo = np.where(cosine <= _GRAZING, _unit(wo - normal * (cosine - _GRAZING)), wo)
    behind = np.clip(-cosine, np.float32(0.0), np.float32(1.0))
    wo = _unit(wo + behind * (normal - wo))
    below = _dot(wo, points.geometric_normal)
    return np.where(below <= _ABOVE, _unit(wo - points.geometric_normal * (below - _ABOVE)), wo)


def _dot(a, b):
    return np.einsum("ij,ij->i", a, b)[:, None]


def _unit(vectors):
    return vectors / np.maximum(np.sqrt(_dot(vectors, vectors)), np.float32(1e-30))

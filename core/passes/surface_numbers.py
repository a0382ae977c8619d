"""Mist and UV passes: numbers of the surfaces that a pixel's rays hit, averaged over its rays."""

from __future__ import annotations

import numpy as np

from ..camera.camera import Camera, view_distance
from ..data.asked_passes import Mist
from ..geometry.element_places import barycentric_at, interpolate
from ..geometry.poses import points_at_rest
from ..geometry.shading import ShadingPoints
from ..geometry.shapes import shaped
from ..scene import Scene


class TileMist:
    """Of n pixels: how far what they show lies in the mist, 1 where that is the world."""

    layer = "mist"

    def __init__(self, n: int):
        self._clear = np.zeros(n)

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray) -> None:
        """Add points, int32 (k,) place: which pixel each belongs to."""
        clear = _clear_share(scene.asked.mist, scene.camera, points.position)
        np.add.at(self._clear, place, clear * points.through.mean(axis=1))

    def add_panes(self, scene: Scene, panes: ShadingPoints, place: np.ndarray, taken) -> None:
        """Add what shows nothing but takes a part of the light, float (k, 3)."""
        clear = _clear_share(scene.asked.mist, scene.camera, panes.position)
        np.add.at(self._clear, place, clear * taken.mean(axis=1))

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """(k, 1): the layer of the pixels ``rows``."""
        return 1.0 - (self._clear[rows] / passes)[:, None]


class TileUv:
    """Of n pixels: where their points are on their objects' UV maps, and 1 for each on one."""

    layer = "uv"

    def __init__(self, n: int):
        self._sum = np.zeros((n, 3))

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray, weight=None) -> None:
        """Add points, int32 (k,) place: which pixel each belongs to; weight: (k,), None = 1."""
        mesh, maps = scene.mesh, scene.asked.uv
        points = points_at_rest(scene.pose, mesh, points)
        triangle = points.triangle
        weights, uv = (np.empty((len(place), 2), np.float32) for _ in range(2))
        own, faces = shaped(scene.pose, mesh, triangle)
        barycentric_at(own.vertices, own.triangles, faces, points.position, weights)
        mirrored = maps.mirrored[mesh.object_index[triangle]]
        interpolate(maps.corners, maps.row, triangle, mirrored, weights, uv)
        value = np.append(uv, maps.row[triangle, None] >= 0, axis=1)
        np.add.at(self._sum, place, value if weight is None else value * weight[:, None])

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """(k, 3): the layer of the pixels ``rows``."""
        return self._sum[rows] / passes[:, None]


def _clear_share(mist: Mist, camera: Camera, position: np.ndarray) -> np.ndarray:
    """float64 (n,): 1 minus the mist of places; of no depth there is none, as in Cycles."""
    if not mist.depth > 0.0:
        return np.ones(len(position))
    away = view_distance(camera, position).astype(np.float64)
    return 1.0 - np.clip((away - mist.start) / mist.depth, 0.0, 1.0) ** mist.power

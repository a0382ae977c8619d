"""The Vector pass: how far what a pixel shows has moved on the picture, from and to the next frame.

As Cycles': pixels, x to the right and y up, from here to where it was a frame before, and from
where it will be a frame later to here. The mean over the rays that hit something, or see the world,
which is infinitely far. (So it is in Cycles' panoramas; before its perspective cameras the world
moves up to a fifth less towards the corners.)
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..data.object_motion import PixelMotion, Pose
from ..geometry.element_places import barycentric_at
from ..geometry.shading import ShadingPoints
from ..geometry.shapes import shaped
from ..scene import ORTHOGRAPHIC, Camera, Scene
from .camera import frame_places

_FAR = 1e9  # metres
_TIMES = (0.0, 1.0)  # of PixelMotion.shapes


class TileVectors:
    """Of n pixels."""

    layer = "vector"

    def __init__(self, n: int):
        self._sum, self._hits = np.zeros((n, 4)), np.zeros(n)

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray, weight=None) -> None:
        """Add points, int32 (k,) place: which pixel each belongs to; weight: (k,), None = 1."""
        there = [_moved(scene, points, k) for k in range(2)]
        self._add(scene, place, points.position, there, weight)

    def add_missed(self, scene: Scene, place: np.ndarray, directions: np.ndarray) -> None:
        """Add rays that see the world, likewise. directions: float32 (k, 3)"""
        if scene.camera.kind == ORTHOGRAPHIC:  # sees one point of it all over
            return
        cameras = [_camera_at(scene.camera, scene.pixel_motion, k) for k in range(2)]
        here, *there = (
            _FAR * directions.astype(np.float64) + camera.camera_to_world[:3, 3]
            for camera in (scene.camera, *cameras)
        )
        self._add(scene, place, here, there)

    def _add(self, scene: Scene, place, here, there, weight=None) -> None:
        """here, there: (k, 3), positions now, and a frame before and later."""
        camera, vectors = scene.camera, np.empty((len(place), 4))
        size, now = np.array([camera.width, camera.height]), frame_places(camera, here)
        for k in range(2):
            then = frame_places(_camera_at(camera, scene.pixel_motion, k), there[k])
            vectors[:, 2 * k : 2 * k + 2] = (then - now if k == 0 else now - then) * size
        known = np.isfinite(vectors).all(axis=1)
        weight = np.ones(len(place)) if weight is None else weight
        np.add.at(self._sum, place[known], vectors[known] * weight[known, None])
        np.add.at(self._hits, place[known], weight[known])

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """(k, 4): the layer of the pixels ``rows``."""
        hits = self._hits[rows, None]
        return np.divide(self._sum[rows], hits, out=np.zeros((len(hits), 4)), where=hits > 0.0)


def _camera_at(camera: Camera, motion: PixelMotion, k: int) -> Camera:
    return dataclasses.replace(
        camera,
        camera_to_world=motion.camera_moves[k] @ camera.camera_to_world,
        window=tuple(np.add(camera.window, motion.window_changes[k])),
    )


def _moved(scene: Scene, points: ShadingPoints, k: int) -> np.ndarray:
    """float64 (n, 3): where the points are a frame before (k = 0) or later."""
    motion, mesh = scene.pixel_motion, scene.mesh
    places = points.position.astype(np.float64)
    pose = Pose(motion.row, motion.matrices[k], motion.matrices[k], _TIMES[k], motion.shapes)
    own, rows = shaped(pose, mesh, points.triangle)
    if own is not mesh:
        weights = np.empty((len(rows), 2), np.float32)
        barycentric_at(mesh.vertices, mesh.triangles, points.triangle, points.position, weights)
        places += _between(own, rows, weights) - _between(mesh, points.triangle, weights)
    row = motion.row[mesh.object_index[points.triangle]]
    which = np.flatnonzero(row >= 0)
    matrices = motion.matrices[k][row[which]]
    turned = np.einsum("nij,nj->ni", matrices[:, :3, :3], places[which])
    places[which] = turned + matrices[:, :3, 3]
    return places


def _between(mesh, triangle, weights) -> np.ndarray:
    """float64 (n, 3): places on triangles, by the weights of their second and third corners."""
    a, b, c = (mesh.vertices[corner].astype(np.float64) for corner in mesh.triangles[triangle].T)
    return a + weights[:, :1] * (b - a) + weights[:, 1:] * (c - a)

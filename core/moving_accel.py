"""The hierarchy of a mesh of which some objects move while the shutter is open.

What stands still is one part, and each set of objects that move alike another; Embree instances
them for each slice of the shutter's time (docs/decisions/0024-moving-objects.md).
"""

from __future__ import annotations

import numpy as np

from ._jit import kernel
from .accel import Accel, nearest_hits, ray_offset
from .embree import EmbreeScene
from .embree_filter import Opacity, ShadowFilter
from .embree_instances import InstanceScene
from .embree_rays import NOTHING
from .object_motion import ObjectMotion
from .scene import Scene, TriangleMesh
from .watch import Cancelled


class MovingAccel(Accel):
    """An Accel of the pose that the mesh table has; ``at`` is one of a slice."""

    def __init__(
        self,
        mesh: TriangleMesh,
        motion: ObjectMotion,
        cancelled=lambda: False,
        opacity: Opacity | None = None,
    ):
        """See Accel."""
        self.mesh, self._motion = mesh, motion
        # Also where they are at other times, and an instance's own arithmetic is off as much again.
        self.offset = 2.0 * max(ray_offset(mesh.vertices), _moved_offset(mesh, motion))
        alike, set_of = np.unique(
            motion.matrices.transpose(1, 0, 2, 3).reshape(len(motion.objects), -1),
            axis=0,
            return_inverse=True,
        )
        part_of = np.zeros(int(mesh.object_index.max(initial=0)) + 1, np.int64)
        there = motion.objects < len(part_of)
        part_of[motion.objects[there]] = 1 + set_of.reshape(-1)[there]
        part = part_of[mesh.object_index]
        order = np.argsort(part, kind="stable").astype(np.int32)
        used, first = np.unique(part[order], return_index=True)
        self._rows, self._first = order, first.astype(np.int64)
        self._parts: list[EmbreeScene] = []
        for begin, end in zip(first, [*first[1:], len(order)], strict=True):
            self._add_part(order[begin:end], opacity, cancelled)
        k = len(motion.times)
        moving = alike.reshape(-1, k, 4, 4)
        still = np.broadcast_to(np.eye(4), (k, 4, 4))
        poses = np.array([moving[s - 1] if s else still for s in used]).reshape(-1, k, 4, 4)
        rest = np.broadcast_to(np.eye(4), (len(used), 4, 4))
        self._slices = [self._pose(poses[:, s]) for s in range(k)]
        self._take(self._pose(rest))

    def _add_part(self, rows, opacity, cancelled):
        own = None if opacity is None else ShadowFilter(opacity._replace(row=opacity.row[rows]))
        beside = self._parts[0] if self._parts else None
        triangles = np.ascontiguousarray(self.mesh.triangles[rows])
        scene = EmbreeScene(self.mesh.vertices, triangles, own, beside)
        if not scene.commit(cancelled) or cancelled():
            raise Cancelled
        self._parts.append(scene)

    def _pose(self, matrices) -> InstanceScene | None:
        return InstanceScene(self._parts, matrices[:, :3]) if self._parts else None

    def _take(self, scene: InstanceScene | None):
        self._scene = scene
        self.traversal = NOTHING if scene is None else scene.traversal()

    def at(self, number: int, scene: Scene | None = None) -> MovingAccel:
        """The same at a slice of the shutter's time; scene: is not asked, see SceneRays.at."""
        other = object.__new__(MovingAccel)
        other.__dict__.update(self.__dict__)
        other._take(self._slices[number])
        return other

    def intersect(self, origins: np.ndarray, directions: np.ndarray):
        """See Accel."""
        triangle, u, v, part = nearest_hits(self.traversal, origins, directions)
        _to_rows(triangle, part, self._first, self._rows)
        return triangle, u, v


@kernel
def _to_rows(triangle, part, first, rows):
    """Count triangles as the whole mesh does. rows: int32, by parts, a part's from first, int64."""
    for k in range(len(triangle)):
        if triangle[k] >= 0:
            triangle[k] = rows[first[part[k]] + triangle[k]]


def _moved_offset(mesh: TriangleMesh, motion: ObjectMotion) -> float:
    """ray_offset of where the moving objects' vertices get, by the boxes around them."""
    row = np.full(int(max(mesh.object_index.max(initial=0), motion.objects.max())) + 1, -1)
    row[motion.objects] = np.arange(len(motion.objects))
    row = row[mesh.object_index]
    order = np.argsort(row, kind="stable")[np.count_nonzero(row < 0) :]
    if not len(order):
        return 0.0
    rows, first = np.unique(row[order], return_index=True)
    corners = mesh.vertices[mesh.triangles[order]]
    low = np.minimum.reduceat(corners.min(axis=1), first).astype(np.float64)
    high = np.maximum.reduceat(corners.max(axis=1), first).astype(np.float64)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    matrices = motion.matrices[:, rows]
    places = np.einsum("kmij,mj->kmi", matrices[..., :3], middle)[..., :3] + matrices[..., :3, 3]
    reach = np.einsum("kmij,mj->kmi", np.abs(matrices[..., :3, :3]), half)
    farthest = float((np.abs(places) + reach).max())
    return ray_offset(np.float32([[farthest, 0.0, 0.0]]))

"""The hierarchy of a mesh of which some objects move while the shutter is open.

What stands still is one part, and each set of objects that move alike another; Embree instances
them for each slice of the shutter's time (docs/decisions/0024-moving-objects.md). What changes its
shape is a part with Embree's motion blur, of which rays see one time
(docs/decisions/0036-changing-shapes.md).
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..data.object_motion import ObjectMotion
from ..machine.watch import Cancelled
from ..scene import Scene, TriangleMesh
from .accel import Accel, ray_offset
from .embree import EmbreeScene
from .embree_filter import ShadowFilter
from .embree_instances import InstanceScene
from .embree_rays import NOTHING
from .opacity_grids import Opacity


class MovingAccel(Accel):
    """An Accel of the pose that the mesh table has; ``at`` is one of a slice."""

    _beside: EmbreeScene | None = None  # whose device parts share

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
        k, kinds = len(motion.times), len(motion.shapes) + 1
        moving, set_of = _sets(mesh, motion)
        shape_of = np.zeros(len(mesh.triangles), np.int64)
        for number, shapes in enumerate(motion.shapes):
            shape_of[shapes.triangle] = 1 + number
        part = set_of[mesh.object_index] * kinds + shape_of
        order = np.argsort(part, kind="stable").astype(np.int32)
        used, first = np.unique(part[order], return_index=True)
        self._rows, self._first = order, first.astype(np.int64)
        self._parts: list[EmbreeScene] = []
        for own, some in zip(
            used, np.split(order, first[1:]), strict=False
        ):  # none: one empty part
            self._add_part(own % kinds, some, opacity, cancelled)
        still = np.broadcast_to(np.eye(4), (k, 4, 4))
        sets = used // kinds
        poses = np.array([moving[s - 1] if s else still for s in sets]).reshape(-1, k, 4, 4)
        rest = np.broadcast_to(np.eye(4), (len(used), 4, 4))
        resting = self._pose(rest)
        self._slices = [resting] * k
        if len(moving):
            self._slices = [self._pose(poses[:, s]) for s in range(k)]
        self._take(resting, 0.5)

    def _add_part(self, kind: int, rows, opacity, cancelled):
        """kind: 0, or 1 and up: of the motion's shapes; rows: of the mesh, ascending"""
        own = None if opacity is None else ShadowFilter(opacity.among(rows))
        beside = self._parts[0] if self._parts else self._beside
        vertices, triangles = self.mesh.vertices, self.mesh.triangles[rows]
        if kind:
            shapes = self._motion.shapes[kind - 1]
            vertices = np.ascontiguousarray(shapes.positions)
            triangles = shapes.corners[np.searchsorted(shapes.triangle, rows)]
        scene = EmbreeScene(vertices, np.ascontiguousarray(triangles), own, beside)
        if not scene.commit(cancelled) or cancelled():
            raise Cancelled
        self._parts.append(scene)

    @property
    def _hierarchies(self) -> list[EmbreeScene]:
        return self._parts

    def _pose(self, matrices) -> InstanceScene | None:
        return InstanceScene(self._parts, matrices[:, :3]) if self._parts else None

    def _take(self, scene: InstanceScene | None, time: float):
        self._scene = scene
        self.traversal = NOTHING if scene is None else scene.traversal()._replace(time=time)

    def at(self, number: int, scene: Scene | None = None) -> MovingAccel:
        """The same at a slice of the shutter's time; scene: is not asked, see SceneRays.at."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._take(self._slices[number], float(self._motion.times[number]))
        return other

    def as_triangles(self, face, u, v, instance, slots=None):
        """See Accel."""
        _to_rows(face, instance, self._first, self._rows)
        return face, u, v


@kernel
def _to_rows(triangle, part, first, rows):
    """Count triangles as the whole mesh does. rows: int32, by parts, a part's from first, int64."""
    for k in range(len(triangle)):
        if triangle[k] >= 0:
            triangle[k] = rows[first[part[k]] + triangle[k]]


def _sets(mesh: TriangleMesh, motion: ObjectMotion):
    """(matrices of sets of objects that move alike, float64 (s, k, 4, 4); 1 + the set of each
    object of the mesh, 0: it stands still)."""
    k, m = len(motion.times), len(motion.objects)
    set_of = np.zeros(int(mesh.object_index.max(initial=0)) + 1, np.int64)
    if not m:
        return np.zeros((0, k, 4, 4)), set_of
    matrices = motion.matrices.transpose(1, 0, 2, 3).reshape(m, -1)
    alike, own = np.unique(matrices, axis=0, return_inverse=True)
    there = motion.objects < len(set_of)
    set_of[motion.objects[there]] = 1 + own.reshape(-1)[there]
    return alike.reshape(-1, k, 4, 4), set_of


def _boxes(mesh: TriangleMesh, motion: ObjectMotion, rows):
    """float32 (m, 3) each: lowest and highest corner of triangles in all of their shapes."""
    corners = mesh.vertices[mesh.triangles[rows]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    if motion.shapes:
        place = np.full(len(mesh.triangles), -1)
        place[rows] = np.arange(len(rows))
    for shapes in motion.shapes:
        own = place[shapes.triangle]
        least, most = shapes.positions.min(axis=0), shapes.positions.max(axis=0)
        low[own[own >= 0]] = least[shapes.corners[own >= 0]].min(axis=1)
        high[own[own >= 0]] = most[shapes.corners[own >= 0]].max(axis=1)
    return low, high


def _moved_offset(mesh: TriangleMesh, motion: ObjectMotion) -> float:
    """ray_offset of where vertices get that move, by the boxes around objects."""
    farthest = max((float(np.abs(s.positions).max(initial=0.0)) for s in motion.shapes), default=0)
    own = ray_offset(np.float32([[farthest, 0.0, 0.0]]))
    if not len(motion.objects):
        return own
    row = np.full(int(max(mesh.object_index.max(initial=0), motion.objects.max())) + 1, -1)
    row[motion.objects] = np.arange(len(motion.objects))
    row = row[mesh.object_index]
    order = np.argsort(row, kind="stable")[np.count_nonzero(row < 0) :]
    if not len(order):
        return own
    rows, first = np.unique(row[order], return_index=True)
    low, high = _boxes(mesh, motion, order)
    low = np.minimum.reduceat(low, first).astype(np.float64)
    high = np.maximum.reduceat(high, first).astype(np.float64)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    matrices = motion.matrices[:, rows]
    places = np.einsum("kmij,mj->kmi", matrices[..., :3], middle)[..., :3] + matrices[..., :3, 3]
    reach = np.einsum("kmij,mj->kmi", np.abs(matrices[..., :3, :3]), half)
    farthest = float((np.abs(places) + reach).max())
    return max(own, ray_offset(np.float32([[farthest, 0.0, 0.0]])))

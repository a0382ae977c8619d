"""Rays against a mesh whose objects have moved since its hierarchy was built.

The hierarchy is not built anew. It stands where it was, and once more for each large object that
has moved, as an instance under that object's matrix; a filter lets each instance show its own
triangles alone. Small objects get a hierarchy of their own (docs/decisions/0026-moved-objects.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..machine.watch import Cancelled
from ..scene import TriangleMesh
from .accel import Accel, ray_offset, to_triangles
from .embree import EmbreeScene
from .embree_filter import GroupFilter, ShadowFilter
from .embree_instances import InstanceScene

# An object of more triangles is shown by an instance: what a hierarchy of its own takes would be
# seen (.75 s a million triangles). Each instance is one more that rays go through in vain.
_LARGE = 30_000
_MOST_LARGE, _MOST_SMALL = 4, 200_000
_ELSEWHERE = 255  # the group of what no instance shows


class Moves(NamedTuple):
    """Objects that have moved.

    objects: int64 (m,), their rows; matrices: float64 (m, 4, 4), from where to where
    """

    objects: np.ndarray
    matrices: np.ndarray


def moves_between(before: np.ndarray, after: np.ndarray) -> Moves | None:
    """Of objects with these matrices, float64 (n, 4, 4); None where one had no size before."""
    objects = np.flatnonzero((before != after).any(axis=(1, 2)))
    try:
        matrices = after[objects] @ np.linalg.inv(before[objects])
    except np.linalg.LinAlgError:
        return None
    return Moves(objects, matrices) if np.isfinite(matrices).all() else None


class MovedAccel(Accel):
    """An Accel of a mesh that is another's but for where objects are; made by ``moved``."""

    def __init__(self, base: Accel, mesh: TriangleMesh, moves: Moves, large, cancelled):
        """large: which of the moves are shown by an instance, int"""
        self.mesh, self.opacity, self.pairs, self._base = mesh, base.opacity, base.pairs, base
        # An instance's own arithmetic is off as much again.
        self.offset = 2.0 * max(base.offset, ray_offset(mesh.vertices))
        group = np.zeros(int(mesh.object_index.max()) + 1, np.uint8)
        group[moves.objects[moves.objects < len(group)]] = _ELSEWHERE
        group[moves.objects[large]] = 1 + np.arange(len(large))
        groups = group[mesh.object_index]
        parts, matrices = [base.scene] * (1 + len(large)), [np.eye(4), *moves.matrices[large]]
        self._rows = np.flatnonzero(groups == _ELSEWHERE).astype(np.int32)
        self._small = len(parts)
        if len(self._rows):
            parts.append(self._own_hierarchy(cancelled))
            matrices.append(np.eye(4))
        if base.pairs is not None:  # both of a pair are of one object
            groups = groups[base.pairs.first]
        base.scene.ask(GroupFilter(groups, base.opacity))
        self._scene = InstanceScene(parts, np.array(matrices)[:, :3])
        # Packets ask no filter.
        self.traversal = self._scene.traversal()._replace(occluded8=0, intersect8=0)

    def _own_hierarchy(self, cancelled) -> EmbreeScene:
        own, opacity = self._base.own_filter, self.opacity
        if opacity is not None:
            own = opacity.among(self._rows)
            if len(own.normals):
                own = own._replace(normals=self.mesh.corner_normals[self._rows])
            own = ShadowFilter(own)
        triangles = self.mesh.triangles[self._rows]
        scene = EmbreeScene(self.mesh.vertices, triangles, own, self._base.scene)
        if not scene.commit(cancelled) or cancelled():
            raise Cancelled
        return scene

    def as_triangles(self, face, u, v, instance, slots=None):
        """See Accel."""
        small = instance == self._small
        own = self._rows[face[small]]
        weights = u[small], v[small]
        face[small] = -1
        to_triangles(self.pairs, face, u, v)
        face[small], u[small], v[small] = own, *weights
        return face, u, v


def moved(base: Accel, mesh: TriangleMesh, moves: Moves, cancelled=lambda: False) -> Accel | None:
    """An Accel of a mesh that differs from that of ``base`` by the moves; it asks base's hierarchy.

    So base is not to be asked itself any more, until ``settled``. None where a new hierarchy does
    better. Raises Cancelled as Accel does.
    """
    if base.scene is None:
        return base if len(mesh.triangles) == 0 else None
    counts = np.bincount(mesh.object_index, minlength=int(moves.objects.max(initial=0)) + 1)
    counts = counts[moves.objects]
    large = np.flatnonzero(counts > _LARGE)
    if len(large) > _MOST_LARGE or counts[counts <= _LARGE].sum() > _MOST_SMALL:
        return None
    return MovedAccel(base, mesh, moves, large, cancelled)


def settled(base: Accel) -> None:
    """Have the hierarchy show all its triangles where they were built."""
    if base.scene is not None:
        base.scene.ask(base.own_filter)


def warm_up() -> None:
    """Have what moved objects need compiled, or read from disk, before somebody waits for it."""
    corners = np.float32([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    mesh = TriangleMesh(
        vertices=corners,
        triangles=np.arange(3, dtype=np.int32)[None],
        corner_normals=np.zeros((1, 3, 3), np.float32),
        material_index=np.zeros(1, np.int32),
        object_index=np.zeros(1, np.int32),
    )
    moves = Moves(np.zeros(1, np.int64), np.eye(4)[None])
    ray = np.float32([[0.2, 0.2, 1.0]]), np.float32([[0.0, 0.0, -1.0]])
    rays = moved(Accel(mesh), mesh, moves)
    if rays is not None:
        rays.intersect(*ray)
        rays.occluded(*ray)

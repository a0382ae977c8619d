"""The hierarchy of a mesh of which some objects stand in many places: Embree's instances.

What stands in one place is one part, and each original of copies another, around its own middle: so
its numbers are as small as it is. docs/decisions/0043-copies.md
"""

from __future__ import annotations

import copy

import numpy as np

from .._jit import kernel
from ..data.copies import Copies
from ..machine.watch import Cancelled
from ..scene import TriangleMesh
from .accel import Accel, ray_offset
from .copied_rows import CopiedRows
from .embree import EmbreeScene
from .embree_filter import ShadowFilter
from .embree_instances import InstanceArray, InstanceScene
from .embree_rays import NOTHING
from .opacity_grids import Opacity
from .triangle_pairs import Pairs, count_as_triangles, paired

_ALONE = 9  # of Pairs.turn
_MOST_SINGLE = 1 << 16  # instances; of more Embree is told as an array


class CopiedAccel(Accel):
    """An Accel that tells hits on copies as ones on rows which CopiedRows has written them out to.

    So it is to be asked for nearest hits as ``with_rows`` gives it.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        copies: Copies,
        mask: np.ndarray | None = None,
        cancelled=lambda: False,
        opacity: Opacity | None = None,
    ):
        """See Accel. mask: bool (m,), the triangles of mesh that it is of; None: all; opacity: of
        the whole mesh. Hits are on rows of mesh, whatever the mask is."""
        self.mesh, self._table = mesh, None
        self.opacity = self.pairs = None
        self._parts: list[EmbreeScene] = []
        self._rows, self._pairs, self._begin, self._count = [], [], [0], 0
        self._boxes, self._middles, self._part = self._add_parts(copies, mask, opacity, cancelled)
        if self._parts:
            self._settle()
        self._stand(copies)

    def _stand(self, copies: Copies) -> None:
        """Have the copies stand where they do."""
        self.copies, shown = copies, np.flatnonzero(self._part[copies.original] >= 0)
        own, original = copies.matrices[shown].astype(np.float64), copies.original[shown]
        # An instance's own arithmetic is off as much again.
        far = max(ray_offset(self.mesh.vertices), _copied_offset(own, self._boxes[original]))
        self.offset = 2.0 * far
        self._scene, self.traversal, n = None, NOTHING, len(self._parts)
        if not n:
            return
        matrices = np.tile(np.eye(3, 4), (n + len(shown), 1, 1))
        matrices[n:] = own
        parts = np.append(np.arange(n), self._part[original])
        shift = np.einsum("nij,nj->ni", matrices[:, :, :3], self._middles[parts])
        matrices[:, :, 3] += shift
        self._array = InstanceArray(self._parts, parts.astype(np.uint32), np.float32(matrices))
        self._copy = np.append(np.full(n, -1), shown).astype(np.int32)
        self._scene = self._instanced()
        self.traversal = self._scene.traversal()

    def _instanced(self) -> InstanceScene:
        array = self._array
        if len(array.part_of) > _MOST_SINGLE:
            return InstanceScene([], np.zeros((0, 3, 4)), array)
        return InstanceScene([array.parts[k] for k in array.part_of], array.matrices)

    @property
    def array(self) -> InstanceArray | None:
        """Its instances, as those of another scene; None: it has none."""
        return self._array if self._parts else None

    def with_copies(self, copies: Copies) -> CopiedAccel:
        """The same of other copies of the same originals."""
        other = copy.copy(self)
        other._stand(copies)
        return other

    def _add_parts(self, copies: Copies, mask, opacity, cancelled):
        """(boxes of the originals, float64 (p, 2, 3); middles of the parts, float64 (parts, 3);
        which part each original is, int32 (p,), -1 = none)."""
        mesh = self.mesh
        there = np.ones(len(mesh.triangles), np.bool_) if mask is None else mask.copy()
        boxes, middles = np.zeros((len(copies.first), 2, 3)), []
        part_of = np.full(len(copies.first), -1, np.int32)
        for number, (first, end) in enumerate(zip(copies.first, copies.end, strict=True)):
            rows = first + np.flatnonzero(there[first:end])
            there[first:end] = False
            if not len(rows):
                continue
            corners = mesh.vertices[mesh.triangles[rows]].reshape(-1, 3)
            boxes[number] = corners.min(axis=0), corners.max(axis=0)
            part_of[number] = len(self._parts)
            middles.append(boxes[number].mean(axis=0))
            self._add_part(rows, middles[-1], opacity, cancelled)
        rest = np.flatnonzero(there)
        if len(rest):
            middles.append(np.zeros(3))
            self._add_part(rest, None, opacity, cancelled)
        return boxes, np.array(middles).reshape(-1, 3), part_of

    def _add_part(self, rows, middle, opacity, cancelled):
        """rows: of the mesh, ascending; middle: float64 (3,), that its hierarchy has as its origin;
        None: the world's"""
        vertices, triangles = self.mesh.vertices, self.mesh.triangles[rows]
        if middle is not None:
            first, last = triangles.min(), triangles.max()
            vertices = (vertices[first : last + 1] - middle).astype(np.float32)
            triangles = triangles - first
        own = None if opacity is None else ShadowFilter(opacity.among(rows))
        pairs = paired(triangles) if own is None else None  # its filter asks for triangles
        faces = triangles if pairs is None else pairs.corners
        beside = self._parts[0] if self._parts else None
        scene = EmbreeScene(vertices, np.ascontiguousarray(faces), own, beside)
        if not scene.commit(cancelled) or cancelled():
            raise Cancelled
        if pairs is None:
            alone = np.full(len(rows), _ALONE, np.uint8)
            pairs = Pairs(faces, np.arange(len(rows), dtype=np.int32), alone)
        self._pairs.append(pairs._replace(first=pairs.first + np.int32(self._count)))
        self._count += len(rows)
        self._rows.append(rows.astype(np.int32))
        self._begin.append(self._begin[-1] + len(pairs.first))
        self._parts.append(scene)

    def _settle(self) -> None:
        """The tables of all parts' faces, one after another."""
        self._first = np.concatenate([pairs.first for pairs in self._pairs])
        self._turn = np.concatenate([pairs.turn for pairs in self._pairs])
        self._rows, self._begin = np.concatenate(self._rows), np.array(self._begin, np.int32)
        self._pairs = None

    @property
    def _hierarchies(self) -> list[EmbreeScene]:
        return self._parts

    def with_rows(self, table: CopiedRows) -> CopiedAccel:
        """The same, that writes hits on copies to a table."""
        other = copy.copy(self)
        other._table, other.mesh = table, table.scene.mesh
        return other

    def slots(self, n: int) -> np.ndarray | None:
        """See Accel."""
        return None if self._table is None else self._table.slots(n)

    def as_triangles(self, face, u, v, instance, slots=None):
        """See Accel."""
        if not self._parts:
            return face, u, v
        number = np.empty(len(face), np.int32)
        _count_from_the_first(face, instance, self._array.part_of, self._begin, self._copy, number)
        count_as_triangles(self._first, self._turn, face, u, v)
        _to_rows(face, self._rows)
        self._table.show(face, u, v, number, slots)
        return face, u, v


@kernel
def _count_from_the_first(face, instance, part_of, begin, copies, number):
    """Count faces of parts as those of all together, in place; write the copy that each is on to
    number, int32 (n,), -1 = none. begin: int32, of parts; copies: int32, of instances"""
    for k in range(len(face)):
        number[k] = -1
        if face[k] >= 0:
            face[k] += begin[part_of[instance[k]]]
            number[k] = copies[instance[k]]


@kernel
def _to_rows(face, rows):
    for k in range(len(face)):
        if face[k] >= 0:
            face[k] = rows[face[k]]


def _copied_offset(matrices, boxes) -> float:
    """ray_offset of where copies have their vertices. matrices: float64 (n, 3, 4); boxes: float64
    (n, 2, 3), of their originals"""
    if not len(matrices):
        return 0.0
    middle, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
    places = np.einsum("nij,nj->ni", matrices[:, :, :3], middle) + matrices[:, :, 3]
    reach = np.einsum("nij,nj->ni", np.abs(matrices[:, :, :3]), half)
    return ray_offset(np.float32((np.abs(places) + reach).max(axis=1))[:, None])

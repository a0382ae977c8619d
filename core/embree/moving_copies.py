"""MovingAccel beside copies: what moves while the shutter is open, among what stands still.

Copies stand still, as one array of Embree's instances after those of the parts that move.
"""

from __future__ import annotations

import copy

import numpy as np

from ..data.copies import Copies
from ..data.object_motion import ObjectMotion
from ..scene import TriangleMesh
from .accel import among
from .copied_accel import CopiedAccel
from .copied_rows import CopiedRows
from .embree import EmbreeScene
from .embree_instances import InstanceScene
from .moving_accel import MovingAccel
from .opacity_grids import Opacity


class MovingCopies(MovingAccel):
    """A MovingAccel whose hits are on rows of the whole mesh, and of CopiedRows."""

    def __init__(
        self,
        mesh: TriangleMesh,
        motion: ObjectMotion,
        copies: Copies,
        mask: np.ndarray | None = None,
        cancelled=lambda: False,
        opacity: Opacity | None = None,
    ):
        """See MovingAccel and CopiedAccel; neither copies nor their originals may move."""
        own = np.ones(len(mesh.triangles), np.bool_) if mask is None else mask
        copied = np.zeros(len(own), np.bool_)
        for first, end in zip(copies.first, copies.end, strict=True):
            copied[first:end] = own[first:end]
        self.copies = copies
        self._copied = CopiedAccel(mesh, copies, copied, cancelled, opacity)
        array = self._copied.array
        self._beside = array and array.parts[0]
        self._own_rows = np.flatnonzero(own & ~copied).astype(np.int32)
        if opacity is not None:
            opacity = opacity.among(self._own_rows)
        own = motion.among(self._own_rows)
        super().__init__(among(mesh, self._own_rows), own, cancelled, opacity)
        self.mesh, self.offset = mesh, max(self.offset, self._copied.offset)

    def _pose(self, matrices) -> InstanceScene | None:
        array = self._copied.array
        if array is None:
            return super()._pose(matrices)
        return InstanceScene(self._parts, matrices[:, :3], array)

    @property
    def _hierarchies(self) -> list[EmbreeScene]:
        return self._parts + self._copied._hierarchies

    def with_rows(self, table: CopiedRows) -> MovingCopies:
        """See CopiedAccel."""
        other = copy.copy(self)
        other._copied, other.mesh = self._copied.with_rows(table), table.scene.mesh
        return other

    def slots(self, n: int) -> np.ndarray | None:
        """See Accel."""
        return self._copied.slots(n)

    def as_triangles(self, face, u, v, instance, slots=None):
        """See Accel."""
        of_copies = (instance >= len(self._parts)) & (face >= 0)
        copied, rows = np.where(of_copies, face, np.int32(-1)), face
        rows[of_copies] = -1
        number = instance - np.int32(len(self._parts))
        copied, u, v = self._copied.as_triangles(copied, u, v, number, slots)
        rows, u, v = super().as_triangles(rows, u, v, instance)
        met = rows >= 0
        rows[met] = self._own_rows[rows[met]]
        rows[of_copies] = copied[of_copies]
        return rows, u, v

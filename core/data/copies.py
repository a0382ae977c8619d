"""Objects of a scene that show the triangles of another one elsewhere, and have none themselves.

A forest is a few trees in many places. Written out, its triangles fill the memory, and rays wait
for it; so the mesh table has each tree once, its original, and Embree an instance for each copy
(docs/decisions/0043-copies.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Copies(NamedTuple):
    """The copies of a scene.

    first, end: int64 (p,), the triangles of each original in the mesh table: rows first to end - 1
    original: int32 (n,), which of these a copy shows; objects: int32 (n,), its row of the objects
    matrices: float32 (n, 3, 4), from where the original stands to where the copy does
    normals: float32 (n, 3, 4), the same of normals, which go through cofactors; last column 0
    turned: bool (n,), whether that turns the winding round: corners 1 and 2 then change places
    """

    first: np.ndarray
    end: np.ndarray
    original: np.ndarray
    objects: np.ndarray
    matrices: np.ndarray
    normals: np.ndarray
    turned: np.ndarray

    @property
    def triangles(self) -> int:
        """What all copies show, together."""
        return int((self.end - self.first)[self.original].sum())

    def same_originals(self, other: Copies | None) -> bool:
        """Whether others are copies of the same."""
        return other is not None and all(map(np.array_equal, self[:2], other[:2]))

    def move(self, motion, object_index: np.ndarray) -> bool:
        """Whether any of them, or of their originals, moves or changes its shape.

        motion: an ObjectMotion, or None; object_index: of the mesh table
        """
        if motion is None:
            return False
        own = np.append(self.objects, object_index[self.first])
        if np.isin(motion.objects, own).any():
            return True
        changing = (object_index[shapes.triangle] for shapes in motion.shapes)
        return any(np.isin(np.unique(rows), own).any() for rows in changing)

"""Objects that move, or change their shape, while the shutter is open: data alone.

See docs/decisions/0024-moving-objects.md and 0036-changing-shapes.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Shapes(NamedTuple):
    """Triangles of objects that change their shape, all in the same number of steps.

    triangle: int32 (m,), rows of TriangleMesh, ascending; corners: int32 (m, 3), rows of positions
    positions: float32 (k, n, 3), where TriangleMesh has the objects, at evenly spaced times from
        the first to the last; between two of them each goes straight; k is odd, the middle one is
        that of TriangleMesh
    normals: float32 (k, q, 3), as TriangleMesh.corner_normals; normal_index: int32 (m, 3), rows of
        normals, negative: the triangle's own
    """

    triangle: np.ndarray
    corners: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    normal_index: np.ndarray

    def among(self, rows: np.ndarray) -> Shapes:
        """The same of a mesh that has some rows of TriangleMesh, ascending, alone."""
        place = np.searchsorted(rows, self.triangle).clip(max=max(len(rows) - 1, 0))
        there = np.flatnonzero(rows[place] == self.triangle) if len(rows) else np.zeros(0, int)
        return self._replace(
            triangle=place[there].astype(np.int32),
            corners=np.ascontiguousarray(self.corners[there]),
            normal_index=np.ascontiguousarray(self.normal_index[there]),
        )


class ObjectMotion(NamedTuple):
    """What objects do while the shutter is open, at the middles of evenly bright slices of time.

    objects: int32 (m,), rows of those that move; times: float64 (k,), 0 to 1 of the shutter's time;
    k is a multiple of 4
    matrices: float64 (k, m, 4, 4), from where TriangleMesh has an object to where it is
    shapes: of what changes its shape, which may move as well
    """

    objects: np.ndarray
    times: np.ndarray
    matrices: np.ndarray
    shapes: tuple[Shapes, ...] = ()

    def among(self, rows: np.ndarray) -> ObjectMotion:
        """See Shapes."""
        return self._replace(shapes=tuple(own.among(rows) for own in self.shapes))


class PixelMotion(NamedTuple):
    """What objects and the camera do from the frame before to the next one.

    row: int32 (n_objects,), in the matrices, -1 = it stands
    matrices: float64 (2, m, 4, 4), from where TriangleMesh has an object to where it is before, and
        later; shapes: at three times
    camera_moves: float64 (2, 4, 4), likewise, of the world; window_changes: float64 (2, 4), of
        Camera.window
    """

    row: np.ndarray
    matrices: np.ndarray
    shapes: tuple[Shapes, ...]
    camera_moves: np.ndarray
    window_changes: np.ndarray


class Pose(NamedTuple):
    """Where objects are in one slice of ObjectMotion, and in what shape.

    row: int32 (n_objects,), in the matrices, -1 = it does not move
    forward, backward: float64 (m, 4, 4), of ObjectMotion.matrices, and their inverses
    time: 0 to 1 of the shutter's time; shapes: of ObjectMotion
    """

    row: np.ndarray
    forward: np.ndarray
    backward: np.ndarray
    time: float = 0.5
    shapes: tuple[Shapes, ...] = ()

"""Objects that move while the shutter is open: data, see docs/decisions/0024-moving-objects.md."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class ObjectMotion(NamedTuple):
    """What objects do while the shutter is open, at the middles of evenly bright slices of time.

    objects: int32 (m,), rows of those that move; times: float64 (k,), 0 to 1 of the shutter's time;
    k is a multiple of 4
    matrices: float64 (k, m, 4, 4), from where TriangleMesh has an object to where it is
    """

    objects: np.ndarray
    times: np.ndarray
    matrices: np.ndarray


class Pose(NamedTuple):
    """Where objects are in one slice of ObjectMotion.

    row: int32 (n_objects,), in the matrices, -1 = it does not move
    forward, backward: float64 (m, 4, 4), of ObjectMotion.matrices, and their inverses
    """

    row: np.ndarray
    forward: np.ndarray
    backward: np.ndarray

"""What neighbours say of a sample's spread, for some points and without scratch."""

import numpy as np

from iwis.core.sampling.neighbours import Neighbours, pool_spread


def relative_spread(sums, neighbours: Neighbours, floor: float, points: np.ndarray) -> np.ndarray:
    """r, float32, one for each of some points.

    sums: incremental.PixelSums of all points; floor: a visibility; points: int32
    """
    n = len(neighbours.group)
    spread = np.empty(len(points), np.float32)
    room = np.empty((n, 4)), np.empty(n)
    pool_spread(points, len(points), sums, neighbours, floor, *room, spread)
    return spread

"""Figure 2: Halton points, and where the product of light and BRDF takes them, n by n.

Each column is warped anew from its own points, so that it shows, not assumes, that the old ones
stay where they were.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.paper_mode.paper import PaperSampler
from ..core.surfaces.seen_points import SeenPoints
from ..core.unit_square.sequence import PixelSequence, common_points, sequence_point
from ..core.unit_square.sphere_map import hemisphere_to_square
from .runs import Run

DENSITY_SIDE = 64
_DENSITY_POINTS = 60_000


class Figure2(NamedTuple):
    """points, warped: of n, 2n and 3n, float64 (count, 2) each, in the unit square
    density: float64 (64, 64), where many points go, mean 1; row 0 at y = 0
    """

    points: tuple[np.ndarray, ...]
    warped: tuple[np.ndarray, ...]
    density: np.ndarray


class Warp:
    """The warp of one shading point, in the square of its hemisphere. seen: of that point."""

    def __init__(self, run: Run, seen: SeenPoints):
        job = run.job()
        zero = np.zeros(1, np.uint32)
        sequence = PixelSequence(common_points(1, "NONE"), zero, zero, False)
        rest = seen.rows, job.tables, sequence, job.accel.offset
        self._sampler = PaperSampler(seen.points, seen.lobes, *rest)

    def directions(self, points: np.ndarray) -> np.ndarray:
        """Where points go, float64 (n, 3), unit, in world space."""
        return np.array([self._sampler.direction(0, x, y) for x, y in points])

    def warped(self, points: np.ndarray) -> np.ndarray:
        """The same in the square of the slice's hemisphere, float64 (n, 2)."""
        frame = self._sampler.frame(0)
        local = self.directions(points) @ frame.T.astype(np.float64)
        local[:, 2] = np.maximum(local[:, 2], 0.0)
        return np.array([hemisphere_to_square(*direction) for direction in local])

    def density(self) -> np.ndarray:
        """Where many points go: float64 (64, 64), mean 1."""
        side = int(np.sqrt(_DENSITY_POINTS))
        even = (np.arange(side) + 0.5) / side
        grid = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)
        x, y = self.warped(grid).T
        counts, _, _ = np.histogram2d(y, x, DENSITY_SIDE, [[0, 1], [0, 1]])
        return counts / counts.mean()


def halton_points(count: int) -> np.ndarray:
    """Halton's points as they are, float64 (count, 2)."""
    zero = np.zeros(1, np.uint32)
    sequence = PixelSequence(common_points(count, "NONE"), zero, zero, False)
    return np.array([sequence_point(sequence, 0, k) for k in range(count)])


def figure2(run: Run, point: int, n: int) -> Figure2:
    """point: row of run.seen(); n: points of the first column."""
    seen = run.seen().at(slice(point, point + 1))
    warps = [Warp(run, seen) for _ in range(3)]
    points = tuple(halton_points((k + 1) * n) for k in range(3))
    warped = tuple(warp.warped(p) for warp, p in zip(warps, points, strict=True))
    return Figure2(points, warped, warps[0].density())

"""Values that nodes of materials write into passes of their own: Blender's AOVs.

Of what a pixel's rays end at, holdouts too; what fractional alpha lets through counts by its share.
"""

from __future__ import annotations

import numpy as np

from .program import Aov
from .scene import Scene
from .shading import ShadingPoints
from .surface import materials_of


class TileAov:
    """An Aov in n pixels of one tile."""

    def __init__(self, aov: Aov, n: int):
        self.layer, self._aov = aov.layer, aov
        self._sums = np.zeros((n, aov.channels), np.float32)

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray) -> None:
        """See SurfacePasses.add."""
        for which, number, evaluation in materials_of(scene, points, self._aov.programs):
            value = self._aov.values[number]
            if self._aov.channels == 1:
                written = evaluation.number(value)[:, None]
            else:
                color = evaluation.vector(value)
                written = np.column_stack([color, np.ones(len(color), np.float32)])
            np.add.at(self._sums, place[which], written)

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """float32 (k, channels), of rows of the tile; passes: int (k,), rays of each."""
        return self._sums[rows] / passes[:, None].astype(np.float32)

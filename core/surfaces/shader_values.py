"""Values that nodes of materials and of the world write into passes of their own: Blender's AOVs.

Of what a pixel's rays end at, holdouts too; what fractional alpha lets through counts by its share.
The world writes where it is seen; a transparent film does not see it.
"""

from __future__ import annotations

import numpy as np

from ..data.program import Aov, Value
from ..geometry.shading import ShadingPoints
from ..nodes import Evaluation
from ..nodes.world import WorldContext
from ..nodes.world_map import ready
from ..scene import Scene
from .surface import materials_of


class TileAov:
    """An Aov in n pixels of one tile."""

    def __init__(self, aov: Aov, n: int):
        self.layer, self._aov, world = aov.layer, aov, aov.world
        self._world = None if world is None else ready(world.program, world.value)
        self._sums = np.zeros((n, aov.channels), np.float32)

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray) -> None:
        """See SurfacePasses.add."""
        for which, number, evaluation in materials_of(scene, points, self._aov.programs):
            self._write(evaluation, self._aov.values[number], place[which])

    def add_missed(self, scene: Scene, place: np.ndarray, directions: np.ndarray) -> None:
        """See SurfacePasses.add_missed."""
        hidden = scene.transparent_film or not scene.environment.visible_to_camera
        if self._world is None or hidden or not len(place):
            return
        context = WorldContext(np.ascontiguousarray(directions))
        self._write(Evaluation(self._world, context), self._aov.world.value, place)

    def _write(self, evaluation: Evaluation, value: Value, place: np.ndarray) -> None:
        if self._aov.channels == 1:
            written = evaluation.number(value)[:, None]
        else:
            color = evaluation.vector(value)
            written = np.column_stack([color, np.ones(len(color), np.float32)])
        np.add.at(self._sums, place, written)

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """float32 (k, channels), of rows of the tile; passes: int (k,), rays of each."""
        return self._sums[rows] / passes[:, None].astype(np.float32)

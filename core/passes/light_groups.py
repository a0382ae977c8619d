"""Light groups: what the lights of each group bring to a picture, in layers of their own.

Lamps and shining faces know their group (Lamps.group), and have columns of their own in what they
bring (lamp_light.py). Here is the rest: the environment's light, and what is seen of lights.
"""

from __future__ import annotations

import numpy as np

from ..geometry.shading import ShadingPoints
from ..scene import Scene

# What the environment brings, of film.LAYERS that know of no lamp yet: light and its color.
_BY_COLOR = (("diffuse_direct", "diffuse_color"), ("glossy_direct", "glossy_color"))


class TileGroups:
    """What n pixels of one tile see of the lights of each group; costs nothing where there is none.

    wanted: whether there are groups
    """

    def __init__(self, scene: Scene, n: int):
        self._groups, self._object_of = scene.asked.groups, scene.mesh.object_index
        self.wanted = len(self._groups.layers) > 0
        self._seen = np.zeros((n if self.wanted else 0, 3 * len(self._groups.layers)))

    def add_emission(self, points: ShadingPoints, place: np.ndarray, emission: np.ndarray) -> None:
        """Add what points shine themselves.

        place: int32 (k,), their pixels, -1 = none; emission: float32 (k, 3)
        """
        if not self.wanted:
            return
        group = self._groups.objects[self._object_of[points.triangle]]
        which = np.flatnonzero((group >= 0) & (place >= 0) & emission.any(axis=1))
        columns = 3 * group[which, None] + np.arange(3)
        np.add.at(self._seen, (place[which, None], columns), emission[which])

    def add_glow(self, place: np.ndarray, glow: np.ndarray) -> None:
        """Add what rays see of lamps. glow: of lamp_glow; the rest as above"""
        if self.wanted:
            inside = place >= 0
            np.add.at(self._seen, place[inside], glow[inside, 3:])

    def write(self, layers: dict[str, np.ndarray], rows, weight) -> None:
        """Write a tile's layers of the groups, but what lamps bring.

        layers: developed, without catchers' pictures and without lamps; rows: the tile's pixels;
        weight: float64, of what each has seen
        """
        if not self.wanted:
            return
        seen = self._seen[rows] * np.reshape(weight, (-1, 1))
        for k, name in enumerate(self._groups.layers):
            light = seen[:, 3 * k : 3 * k + 3].reshape(layers["emission"].shape)
            if k == self._groups.world:
                light = light + _of_world(layers, self._groups.shows_world)
            layers[name] = light.astype(np.float32)


def _of_world(layers, shown: bool) -> np.ndarray:
    """The light of the environment, and it itself, in developed layers."""
    seen = layers["environment"] if shown else np.float32(0.0)
    return sum((layers[light] * layers[color] for light, color in _BY_COLOR), seen)

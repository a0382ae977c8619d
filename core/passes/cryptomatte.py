"""Cryptomatte: which parts of a pixel show which object, material or asset [Friedman15].

A matte's id is a hash of its name, taken for a float32. A pixel's mattes are ranked by how much of
it they cover, and written as pairs of id and coverage, two pairs to four channels, as Cycles does.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..data.asked_passes import Matte, channels_of
from ..geometry.shading import ShadingPoints
from ..scene import Scene, TriangleMesh

_SPARE = 4  # mattes of a pixel that are kept beyond those shown: a late one may cover more
_NONE = np.int32(-1)


class TileMattes:
    """The mattes of one kind of n pixels, added up over their points."""

    def __init__(self, matte: Matte, mesh: TriangleMesh, n: int):
        self.layer, self._levels = matte.layer, matte.levels
        self._rows = mesh.material_index if matte.by_material else mesh.object_index
        self._number_of = matte.number
        self._ids = np.append(matte.ids, np.float32(0.0))  # of _NONE, the last one
        self._number = np.full((n, matte.levels + _SPARE), _NONE, np.int32)
        self._weight = np.zeros(self._number.shape, np.float32)

    def add(self, _: Scene, points: ShadingPoints, place: np.ndarray) -> None:
        """Add points, int32 (k,) place: which pixel each belongs to."""
        number = self._number_of[self._rows[points.triangle]]
        _add(place, number, points.through, self._number, self._weight)

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """(k, channels): the layer of the pixels ``rows``, those that cover most first."""
        number, weight = self._number[rows], self._weight[rows]
        order = np.argsort(-weight, axis=1, kind="stable")[:, : self._levels]
        pairs = np.zeros((len(number), channels_of(self._levels) // 2, 2), np.float32)
        pairs[:, : self._levels, 0] = self._ids[np.take_along_axis(number, order, 1)]
        pairs[:, : self._levels, 1] = np.take_along_axis(weight, order, 1) / passes[:, None]
        return pairs.reshape(len(number), -1)


@kernel
def _add(place, number, through, numbers, weights):
    """To the slot of each point's matte, of a new one the first that is free, if one is."""
    third = np.float32(1.0 / 3.0)
    for k in range(len(place)):
        p = place[k]
        weight = (through[k, 0] + through[k, 1] + through[k, 2]) * third
        for slot in range(numbers.shape[1]):
            if numbers[p, slot] < 0:
                numbers[p, slot] = number[k]
            if numbers[p, slot] == number[k]:
                weights[p, slot] += weight
                break

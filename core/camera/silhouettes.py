"""Which pixels are near a silhouette, by the rays of their first passes."""

from __future__ import annotations

import numpy as np

from ..geometry.shading import ShadingPoints
from ..scene import Scene
from .pass_rays import blurred, world_blurred

# In place of a row of the objects.
_NOTHING, _WORLD, _NO_OBJECT = np.int32(-2), np.int32(-1), np.int32(0x7FFFFFFF)


class Silhouettes:
    """What the first passes of a tile's pixels saw, row by row; 9 bytes a pixel.

    width: of the tile, in pixels; blurred: bool (n,), those whose picture lens or motion spread
    """

    def __init__(self, scene: Scene, width: int, height: int):
        n = width * height
        self._scene, self._shape, self.width = scene, (height, width), width
        # The least and the greatest object.
        self._least, self._greatest = np.full(n, _NO_OBJECT), np.full(n, _NOTHING)
        self.blurred = np.zeros(n, np.bool_)

    def note(self, missed: np.ndarray, looks: np.ndarray, points: ShadingPoints) -> None:
        """Take rays: their points, ``pixel`` counted as here, and the pixels of those that missed.

        looks: bool, one for each of these, whether its ray sees the world, or nothing
        """
        objects = self._scene.mesh.object_index[points.triangle]
        world = np.where(looks, _WORLD, _NOTHING)
        for pixels, seen in ((missed, world), (points.pixel, objects)):
            np.minimum.at(self._least, pixels, seen)
            np.maximum.at(self._greatest, pixels, seen)
        camera = self._scene.camera
        self.blurred[points.pixel[blurred(camera, points.position)]] = True
        self.blurred[missed] |= world_blurred(camera)

    def near(self) -> np.ndarray:
        """bool (n,): pixels that see, themselves or by a neighbour, more than one object; and
        blurred ones, where a few rays say little of what there is."""
        least, greatest = self._least.reshape(self._shape), self._greatest.reshape(self._shape)
        near = np.zeros(self._shape, np.bool_)
        near[1:-1, 1:-1] = _of_nine(least, np.minimum) != _of_nine(greatest, np.maximum)
        return near.ravel() | self.blurred


def _of_nine(values, reduce) -> np.ndarray:
    """``reduce`` over the 3 x 3 values about each but those at the border."""
    rows = reduce(reduce(values[:-2], values[1:-1]), values[2:])
    return reduce(reduce(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])

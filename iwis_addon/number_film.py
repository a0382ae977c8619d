"""The last picture's passes of numbers, 12 bytes a pixel: Blender's result shows no script any."""

from __future__ import annotations

import numpy as np

from ..core.film import Tile
from ..core.settings import RenderSettings

NUMBERS = ("samples", "error", "visibility")


class NumberFilm:
    """layers: name -> float32 (h, w), row 0 at the bottom; settings: of the picture.

    region: (x0, y0, x1, y1) of the frame
    """

    def __init__(self, region: tuple[int, int, int, int], settings: RenderSettings):
        x0, y0, x1, y1 = region
        self.region, self.settings = region, settings
        self.layers = {name: np.zeros((y1 - y0, x1 - x0), np.float32) for name in NUMBERS}

    def write_tile(self, tile: Tile) -> None:
        """Take what is of interest of a tile."""
        x, y = tile.x - self.region[0], tile.y - self.region[1]
        for name, pixels in self.layers.items():
            if name in tile.layers:
                pixels[y : y + tile.height, x : x + tile.width] = tile.layers[name][..., 0]

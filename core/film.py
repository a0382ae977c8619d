"""What a tile of the picture carries, and who takes it.

The sink is declared here and implemented elsewhere (Blender's render result, the command line, a
list in a test): the renderer never learns who receives its tiles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

# Layer -> channels, of every picture; mattes have layers of their own beside these (asked_passes).
# Row 0 of every layer is the bottom row of the tile.
LAYERS = {
    "combined": 4,  # radiance, alpha (premultiplied)
    "depth": 1,  # metres along the camera's axis, NO_DEPTH where nothing is hit
    "position": 3,  # world space
    "normal": 3,  # world space, shading normal
    "object_index": 1,
    "material_index": 1,
    "environment": 3,  # the world as the camera sees it
    "emission": 3,
    "diffuse_direct": 3,  # light through the diffuse lobe, divided by diffuse_color
    "diffuse_color": 3,
    "glossy_direct": 3,
    "glossy_color": 3,
    "ambient_occlusion": 3,  # of an even sky, what is seen within AskedPasses.occlusion_distance
    "mist": 1,  # 0 where it begins, 1 where it is complete and where the world is seen
    "vector": 4,  # pixels from here to where it was a frame before, and from where it will be
    "uv": 3,  # place on the UV map; 1 times the share of the pixel's rays that hit a surface
    "shadow_catcher": 3,  # what arrives on a pixel's catchers, over all that would; 1 of none
    "sample_count": 1,  # samples divided by max_samples: Cycles' Debug Sample Count
    "samples": 1,  # shadow rays of the pixel
    "error": 1,  # e_d when the pixel stopped [Huang07, eq. 7]
    "unoccluded": 3,  # I_s
    "visibility": 1,  # I_d / I_s
}
NO_DEPTH = 1e10  # as Cycles writes it


class Tile(NamedTuple):
    """A finished part of the picture: its place in the frame, y up, and its layers.

    A part may come once more, with some layers only: they take the place of those before.
    """

    x: int
    y: int
    width: int
    height: int
    layers: dict[str, np.ndarray]  # name -> float32 (height, width, channels)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a render is: phase: 'tables', 'bvh', 'sampling' or 'denoising'; fraction of that."""

    phase: str
    fraction: float
    tiles_done: int = 0
    tiles_total: int = 0
    samples: int = 0  # shadow rays so far
    text: str = ""


class TileSink(Protocol):
    """Who takes the picture. All three are called by the thread that called render(), only."""

    def write_tile(self, tile: Tile) -> None: ...

    def progress(self, progress: Progress) -> None: ...

    def cancelled(self) -> bool: ...


def new_layers(width: int, height: int) -> dict[str, np.ndarray]:
    """Every layer of LAYERS, zero, float32 (height, width, channels)."""
    return {name: np.zeros((height, width, n), np.float32) for name, n in LAYERS.items()}


class Film:
    """A whole picture in memory: the sink of the command line, of scripts and of tests.

    region: (x0, y0, x1, y1) of the frame that is rendered
    layers: name -> float32 (y1 - y0, x1 - x0, channels), row 0 at the bottom
    """

    def __init__(self, region: tuple[int, int, int, int]):
        x0, y0, x1, y1 = region
        self.region = region
        self.layers = new_layers(x1 - x0, y1 - y0)

    def write_tile(self, tile: Tile) -> None:
        x, y = tile.x - self.region[0], tile.y - self.region[1]
        for name, pixels in tile.layers.items():
            if name not in self.layers:
                size = *self.layers["combined"].shape[:2], pixels.shape[2]
                self.layers[name] = np.zeros(size, np.float32)
            self.layers[name][y : y + tile.height, x : x + tile.width] = pixels

    def progress(self, progress: Progress) -> None:
        """A film has nobody to tell."""

    def cancelled(self) -> bool:
        return False

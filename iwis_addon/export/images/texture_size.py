"""Simplify's texture limit: images are made smaller before they are looked up, as in Cycles.

Their sides are halved until they fit, and each new texel is the mean of those under it, of bytes as
they are stored, rounded to a byte. Blender 5.2 has a resolution too, which halves them all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.data.program import ImageTiles
from .color_spaces import srgb_decode, srgb_encode
from .image import Texels


class TextureSize(NamedTuple):
    """limit: pixels of an image's longer side, 0 = none; resolution: of all sides, up to 1."""

    limit: int = 0
    resolution: float = 1.0

    def step_of(self, height: int, width: int) -> int:
        """How many texels become one, along each side: a power of two."""
        step, longer = 1, max(height, width)
        while step < longer and (
            1.0 > step * self.resolution or (self.limit and longer > step * self.limit)
        ):
            step *= 2
        return step


WHOLE = TextureSize()


def texture_size(depsgraph) -> TextureSize:
    """Of a render or a window."""
    scene = depsgraph.scene
    own = getattr(scene, "cycles", None)  # Cycles' own, there as long as its add-on is enabled
    if own is None or not scene.render.use_simplify:
        return WHOLE
    kind = "" if depsgraph.mode == "VIEWPORT" else "_render"
    limit, resolution = (
        getattr(own, f"{name}{kind}", none)
        for name, none in (("texture_limit", "OFF"), ("texture_resolution", 1.0))
    )
    return TextureSize(0 if limit == "OFF" else int(limit), resolution)


def _means(pixels: np.ndarray, step: int) -> np.ndarray:
    """float32 (h, w, channels): of blocks of so many rows and columns; what is over is left out.

    Summed up texel by texel, as Cycles does: where a byte is between two, that decides.
    """
    height, width, channels = pixels.shape
    rows, columns = min(step, height), min(step, width)
    high, wide = height // rows * rows, width // columns * columns
    means = np.zeros((high // rows, wide // columns, channels), np.float32)
    for y in range(rows):
        for x in range(columns):
            means += pixels[y:high:rows, x:wide:columns]
    return means / np.float32(rows * columns)


def _means_of_bytes(pixels: np.ndarray, step: int) -> np.ndarray:
    """The same of numbers from 0 to 255, whole ones again."""
    means = _means(pixels * np.float32(1.0 / 255.0), step)
    return np.floor(means * np.float32(255.0) + np.float32(0.5))


def smaller_tiles(tiles: ImageTiles, size: TextureSize) -> ImageTiles:
    """The same image, or the tiles of it, no larger than that."""

    def smaller(pixels):
        step = size.step_of(*pixels.shape[:2])
        if step == 1:
            return pixels
        if pixels.dtype == np.uint8:
            return _means_of_bytes(pixels, step).astype(np.uint8)
        return _means(pixels, step)

    if size == WHOLE:
        return tiles
    return tiles._replace(tiles={place: smaller(own) for place, own in tiles.tiles.items()})


def smaller_texels(texels: Texels, size: TextureSize, are_bytes: bool) -> Texels:
    """The same for a world's. are_bytes: whether Cycles has them as bytes, sRGB or plain"""
    step = size.step_of(*texels.rgb.shape[:2])
    if step == 1:
        return texels
    rgb = srgb_encode(texels.rgb) if texels.srgb_interpolation else texels.rgb
    if are_bytes:
        means = _means_of_bytes(np.rint(rgb * np.float32(255.0)), step) / np.float32(255.0)
    else:
        means = _means(rgb, step)
    return texels._replace(rgb=srgb_decode(means) if texels.srgb_interpolation else means)

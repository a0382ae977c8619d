"""A picture of the core on the screen: one texture, scene-linear, managed by Blender."""

from __future__ import annotations

import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .passes import matte_layer

_LARGEST = 65504.0  # of a half float
_COLOR_BITS = np.array([0, 8, 15], np.uint32)  # where red, green and blue begin in an id


class PictureDrawing:
    """Keeps the texture of the last picture."""

    def __init__(self):
        self._texture = None
        self._version = -1

    def draw(self, engine, scene, picture, version: int, pixel_size: int) -> None:
        """Draw into the region that Blender has made current.

        version: of the picture; pixel_size: pixels of the screen to one of the picture's frame
        """
        if version != self._version:
            self._texture = make_texture(shown_pixels(picture))
            self._version = version
        scale = picture.step * pixel_size
        x0, y0, x1, y1 = (edge * scale for edge in picture.region)
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (x0, y0), x1 - x0, y1 - y0)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def shown_pixels(picture) -> np.ndarray:
    """float32 (h, w, 4), scene-linear: a picture as its pass is looked at.

    As in Cycles, a number is a grey, nothing is below 0, and all but Combined is opaque. Of mattes
    each has a color of its own.
    """
    pixels = picture.layers[picture.shown]
    if picture.shown == "combined":
        return pixels
    if picture.shown.startswith(matte_layer("")):
        pixels = _matte_colors(pixels)
    rgba = np.ones((*pixels.shape[:2], 4), np.float32)
    np.clip(pixels, 0.0, _LARGEST, out=rgba[..., :3])
    return rgba


def _matte_colors(pixels) -> np.ndarray:
    """float32 (h, w, 3) of pairs of id and coverage: bits of the ids, by what they cover."""
    pairs = pixels.reshape(*pixels.shape[:2], -1, 2)
    bits = np.ascontiguousarray(pairs[..., 0]).view(np.uint32)[..., None] >> _COLOR_BITS
    return np.einsum("yxkc,yxk->yxc", (bits & 0xFF) / np.float32(255.0), pairs[..., 1])


def make_texture(pixels):
    """A texture of float32 (h, w, 4), row 0 at the bottom."""
    height, width = pixels.shape[:2]
    values = gpu.types.Buffer("FLOAT", width * height * 4, pixels.reshape(-1))
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=values)
    if hasattr(texture, "filter_mode"):
        texture.filter_mode(False)
    return texture

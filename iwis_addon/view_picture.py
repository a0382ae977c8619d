"""A picture of the core on the screen: one texture, scene-linear, managed by Blender."""

from __future__ import annotations

import gpu
from gpu_extras.presets import draw_texture_2d


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
            self._texture = make_texture(picture.layers["combined"])
            self._version = version
        scale = picture.step * pixel_size
        x0, y0, x1, y1 = (edge * scale for edge in picture.region)
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (x0, y0), x1 - x0, y1 - y0)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def make_texture(pixels):
    """A texture of float32 (h, w, 4), row 0 at the bottom."""
    height, width = pixels.shape[:2]
    values = gpu.types.Buffer("FLOAT", width * height * 4, pixels.reshape(-1))
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=values)
    if hasattr(texture, "filter_mode"):
        texture.filter_mode(False)
    return texture

"""Arrays into Blender's images, and images onto the screen."""

from __future__ import annotations

import contextlib
import os
import tempfile

import bpy
import numpy as np

from .scratch import scratch


def put_image(name: str, pixels: np.ndarray, is_float: bool):
    """The image of this name, made or overwritten: float32 (h, w, 4), row 0 at the bottom.

    is_float: scene-linear; else display values, which Blender shows as they are
    """
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and image.filepath:  # a file of the user's: it keeps its pixels
        image = None
    elif image is not None and image.is_float != is_float:
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    elif tuple(image.size) != (width, height):
        image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    image.update()
    image.pack()
    return image


def read_image(path: str) -> np.ndarray:
    """float32 (h, w, 4) of an image file as Blender reads it, row 0 below, values untouched."""
    with scratch(bpy.data.images, bpy.data.images.load(path)) as image:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)


@contextlib.contextmanager
def waiting(window):
    """The mouse shows that Blender is busy; window: None in background mode."""
    if window is None:
        yield
        return
    window.cursor_modal_set("WAIT")
    try:
        yield
    finally:
        window.cursor_modal_restore()


def show_image(context, image) -> None:
    """In an image editor of the screen, if there is one; nothing in background mode."""
    screen = context.screen
    areas = [] if screen is None else [a for a in screen.areas if a.type == "IMAGE_EDITOR"]
    own = [area for area in areas if area == context.area]
    for area in (own or areas)[:1]:
        area.spaces.active.image = image


def render_pixels(scene) -> np.ndarray:
    """Render a scene as it is set, without compositing: float32 (h, w, 4), row 0 below.

    Blender's output settings are left as they were. Raises RuntimeError as the render does.
    """
    render, settings = scene.render, scene.render.image_settings
    owners = (render, ("filepath", "use_compositing", "use_sequencer", "use_file_extension"))
    kept = [(*owners,), (settings, ("file_format", "color_mode", "color_depth"))]
    if hasattr(settings, "media_type"):
        kept[1:1] = [(settings, ("media_type",))]
    values = [(owner, name, getattr(owner, name)) for owner, names in kept for name in names]
    with tempfile.TemporaryDirectory(prefix="iwis-") as folder:
        try:
            if hasattr(settings, "media_type"):
                settings.media_type = "IMAGE"
            settings.file_format, settings.color_mode = "OPEN_EXR", "RGBA"
            settings.color_depth = "32"
            render.use_compositing = render.use_sequencer = False
            render.filepath = os.path.join(folder, "picture.exr")
            bpy.ops.render.render(write_still=True, scene=scene.name)
            return read_image(render.filepath)
        finally:
            for owner, name, value in values:
                setattr(owner, name, value)

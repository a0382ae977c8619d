"""Render the open scene with IWIS, as a user would, and read the file back."""

import bpy
import numpy as np

from iwis.core.exr import read_exr_layers


def use_format(scene, file_format):
    """Set the format of the output, at full precision where it is OpenEXR."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        multilayer = file_format == "OPEN_EXR_MULTILAYER"
        image.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    image.file_format = file_format
    if file_format.startswith("OPEN_EXR"):
        image.color_depth = "32"


def render_iwis(scene, folder) -> dict[str, np.ndarray]:
    """Name such as 'ViewLayer.Depth' -> float32 (h, w, channels), row 0 at the bottom."""
    scene.render.engine = "IWIS"
    use_format(scene, "OPEN_EXR_MULTILAYER")
    path = folder / "iwis.exr"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read_exr_layers(path)


def by_pass(layers: dict) -> dict:
    """A file's layers without the view layer's name."""
    return {name.partition(".")[2]: pixels for name, pixels in layers.items()}

"""Render the open scene with Cycles and read the layers back: the yardstick of the exporters."""

import bpy
import numpy as np
import OpenEXR


def _channels(path):
    """Channel name without the view layer's -> (h, w) array, row 0 at the top."""
    channels = {}
    with OpenEXR.File(str(path), separate_channels=True) as file:
        for part in file.parts:
            for name, channel in part.channels.items():
                pass_name, _, axis = name.rpartition(".")
                pass_name = pass_name or part.name()
                channels[f"{pass_name.split('.')[-1]}.{axis}"] = np.asarray(channel.pixels)
    return channels


def use_cycles(scene, samples=1, filter_width=0.01):
    """Make Cycles shoot one ray through the centre of each pixel, without light."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.cycles.filter_width = filter_width
    scene.render.threads_mode = "FIXED"
    scene.render.threads = 1


def render_cycles(
    scene,
    tmp_path,
    passes=("position", "normal", "z", "object_index"),
    samples=1,
    filter_width=0.01,
):
    """Layers of the view layer: name -> float32 (h, w, channels), row 0 at the bottom."""
    use_cycles(scene, samples, filter_width)
    layer = scene.view_layers[0]
    for name in passes:
        setattr(layer, f"use_pass_{name}", True)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    path = tmp_path / "cycles.exr"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    channels = _channels(path)
    groups = {}
    for key in channels:
        name, _, axis = key.rpartition(".")
        groups.setdefault(name, []).append(axis)
    order = "RXGYBZAV"
    return {
        name: np.stack(
            [channels[f"{name}.{axis}"][::-1] for axis in sorted(axes, key=order.find)], -1
        )
        for name, axes in groups.items()
    }

"""Render a Sky Texture to an equirectangular picture, in a Blender process of its own.

Blender cannot render while it renders: a sky is wanted at export, in the midst of a render job.
This file is what the process runs (export/images/sky.py starts it); it knows nothing of the add-on.
"""

import json
import math
import os
import sys
import tempfile

import bpy
import numpy as np

_SAMPLES, _SUN_SAMPLES = 4, 1024  # of a pixel, and of one near the sun's disc
_AROUND = 3  # pixels about the disc


def render_sky(settings: dict, height: int, space: str = "") -> np.ndarray:
    """float32 (height, 2 height, 3), row 0 at the bottom.

    settings: of the node, by name; space: the working space of the colors, which Blender 5 has
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if hasattr(bpy.data, "colorspace") and space not in ("", bpy.data.colorspace.working_space):
        bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=False)
    scene = bpy.context.scene
    node = _world(scene, settings)
    _camera(scene, height)
    has_disc = bool(settings.get("sun_disc")) and "sun_elevation" in settings
    if has_disc:
        node.sun_disc = False
    picture = _picture(scene, _SAMPLES)
    if has_disc:
        node.sun_disc = True
        rows, columns = _region_of_disc(settings, height)
        for first, end in columns:
            box = (first, end, *rows)
            _border(scene, box, height)
            part = _picture(scene, _SUN_SAMPLES)
            picture[rows[0] : rows[1], first:end] = part
    return picture


def _world(scene, settings):
    world = scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    sky, output = nodes.new("ShaderNodeTexSky"), nodes.new("ShaderNodeOutputWorld")
    background = nodes.new("ShaderNodeBackground")
    for name, value in settings.items():
        setattr(sky, name, value)
    links.new(sky.outputs[0], background.inputs["Color"])
    links.new(background.outputs[0], output.inputs["Surface"])
    return sky


def _camera(scene, height):
    camera = bpy.data.cameras.new("Panorama")
    eye = scene.camera = bpy.data.objects.new("Panorama", camera)
    scene.collection.objects.link(eye)
    # A panorama's middle looks along the camera's axis; an Environment Texture's along +x.
    eye.rotation_euler = math.pi / 2, 0.0, -math.pi / 2
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    render, cycles = scene.render, scene.cycles
    render.engine, render.film_transparent = "CYCLES", False
    render.resolution_x, render.resolution_y = 2 * height, height
    render.resolution_percentage = 100
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.max_bounces, cycles.pixel_filter_type, cycles.filter_width = 0, "BOX", 1.0


def _region_of_disc(settings, height):
    """(rows, [columns, ...]) that hold the sun's disc and what is around it."""
    step, size = math.pi / height, 0.5 * settings.get("sun_size", 0.01)
    up = settings["sun_elevation"]
    low, high = ((0.5 * math.pi + up + s * size) / step for s in (-1.0, 1.0))
    rows = max(int(low) - _AROUND, 0), min(int(high) + _AROUND + 1, height)
    # Towards the poles the disc is wider; at them it is all around.
    slope = math.cos(up)
    half = math.asin(min(math.sin(size) / slope, 1.0)) if slope > math.sin(size) else math.pi
    middle = (math.pi - _azimuth(settings)) % (2.0 * math.pi) / step
    if half / step + _AROUND >= height:
        return rows, [(0, 2 * height)]
    first = int(middle - half / step) - _AROUND
    end = int(middle + half / step) + _AROUND + 1
    if first < 0:
        return rows, [(0, end), (first + 2 * height, 2 * height)]
    if end > 2 * height:
        return rows, [(first, 2 * height), (0, end - 2 * height)]
    return rows, [(first, end)]


def _azimuth(settings):
    """Of the sun, from +x to +y: the node turns it from +y to +x."""
    return 0.5 * math.pi - settings.get("sun_rotation", 0.0)


def _border(scene, box, height):
    """box: first and end of columns, first and end of rows."""
    render = scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x = (x / (2 * height) for x in box[:2])
    render.border_min_y, render.border_max_y = (y / height for y in box[2:])


def _picture(scene, samples) -> np.ndarray:
    """float32 (h, w, 3) of what the scene's camera sees within its border."""
    scene.cycles.samples = samples
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory(prefix="iwis-") as folder:
        scene.render.filepath = os.path.join(folder, "sky.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return np.ascontiguousarray(pixels.reshape(height, width, 4)[..., :3])


if __name__ == "__main__":
    _settings, _height, _space, _path = sys.argv[-4:]
    np.save(_path, render_sky(json.loads(_settings), int(_height), _space))

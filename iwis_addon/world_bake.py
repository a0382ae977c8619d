"""Any world to an equirectangular image, by a panorama that Cycles renders."""

from __future__ import annotations

import math

import bpy

from .callbacks import end_previews
from .images import put_image, render_pixels


def bake_world(scene, height: int = 512, samples: int = 16):
    """The image of a scene's world as it lights: strength, mapping and sky included.

    height: pixels, the width is twice that; samples: of each pixel, for detail below its size
    Raises ValueError without a world or without Cycles, RuntimeError when the render fails.
    """
    if scene.world is None:
        raise ValueError("The scene has no world to convert: add one in the world's properties")
    if not hasattr(scene, "cycles"):
        raise ValueError(
            "Cycles is disabled: enable it in Preferences, Add-ons, to convert a world"
        )
    world, camera = scene.world.copy(), bpy.data.cameras.new("IWIS Panorama")
    eye = bpy.data.objects.new("IWIS Panorama", camera)
    studio = bpy.data.scenes.new("IWIS Panorama")
    end_previews()
    try:
        _set_up(studio, world, camera, eye, height, samples)
        pixels = render_pixels(studio)
    finally:
        bpy.data.scenes.remove(studio)
        bpy.data.objects.remove(eye)
        bpy.data.cameras.remove(camera)
        bpy.data.worlds.remove(world)
    pixels[..., 3] = 1.0
    return put_image(f"{scene.world.name} HDRI", pixels, is_float=True)


def _set_up(studio, world, camera, eye, height, samples):
    studio.world, studio.camera = world, eye
    studio.collection.objects.link(eye)
    # A panorama's middle looks along the camera's axis; an Environment Texture's along +x.
    eye.rotation_euler = math.pi / 2, 0.0, -math.pi / 2
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    if hasattr(world, "cycles_visibility"):
        world.cycles_visibility.camera = True
    render, cycles = studio.render, studio.cycles
    render.engine, render.film_transparent = "CYCLES", False
    render.resolution_x, render.resolution_y = 2 * height, height
    render.resolution_percentage, render.use_border = 100, False
    cycles.device, cycles.samples, cycles.use_adaptive_sampling = "CPU", samples, False
    cycles.use_denoising, cycles.max_bounces, cycles.film_exposure = False, 0, 1.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0


def use_image(scene, image):
    """A new world that shows the image, with the visibility of the one before; the scene's own."""
    world = scene.world.copy()
    world.name = image.name
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output, background = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeBackground")
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    texture.location, background.location = (-600.0, 0.0), (-250.0, 0.0)
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])
    scene.world = world
    return world

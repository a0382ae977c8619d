"""The scene that all cases share: a smooth sphere, a turned cube and a floor of one material."""

from __future__ import annotations

import math

import bpy
import numpy as np

WIDTH, HEIGHT = 48, 32


class Tree:
    """Builds the material or the world of a case, node by node."""

    def __init__(self, tree, output="ShaderNodeOutputMaterial"):
        self.tree = tree
        tree.nodes.clear()
        self.output = self.node(output)

    def node(self, kind, **properties):
        """A new node; properties by name."""
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def link(self, source, target):
        """Link an output to an input; a number or tuple becomes the input's own value."""
        if isinstance(source, (int, float)):
            is_number = isinstance(target.default_value, (int, float))
            target.default_value = source if is_number else [source] * len(target.default_value)
        elif isinstance(source, tuple):
            target.default_value = (*source, 1.0)[: len(target.default_value)]
        else:
            self.tree.links.new(source, target)

    def made(self, kind, output=0, inputs=None, **properties):
        """The output of a new node. inputs: identifier, name or number -> output or value"""
        node = self.node(kind, **properties)
        for key, value in (inputs or {}).items():
            self.link(value, find_socket(node.inputs, key))
        return find_socket(node.outputs, output)

    def coordinates(self, name="Object"):
        return self.made("ShaderNodeTexCoord", name)

    def axis(self, axis, low=0.0, high=1.0):
        """A number from low to high over the sphere, along "X", "Y" or "Z" of its object."""
        value = self.made("ShaderNodeSeparateXYZ", axis, {0: self.coordinates()})
        inputs = {"Value": value, "From Min": -1.0, "From Max": 1.0, "To Min": low, "To Max": high}
        return self.made("ShaderNodeMapRange", 0, inputs, clamp=False)

    def color(self, low=0.0, high=1.0):
        """A colour whose channels vary along the three axes."""
        axes = {k: self.axis(a, low, high) for k, a in zip((0, 1, 2), "XYZ", strict=True)}
        return self.made("ShaderNodeCombineXYZ", 0, axes)

    def glow(self, value):
        """Show a value as it is."""
        self.surface(self.made("ShaderNodeEmission", 0, {"Color": value, "Strength": 1.0}))

    def surface(self, shader):
        self.link(shader, self.output.inputs["Surface"])


def find_socket(sockets, key):
    """By number, identifier, or name among those that are in use."""
    if isinstance(key, int):
        return sockets[key]
    enabled = [s for s in sockets if s.enabled]
    for found in (
        [s for s in enabled if s.identifier == key],
        [s for s in enabled if s.name == key],
        [s for s in sockets if s.identifier == key],
    ):
        if found:
            return found[0]
    raise KeyError(f"{key}: there are {[s.identifier for s in sockets]}")


def empty_scene(lit: bool):
    """The scene, and its material as a Tree. lit: by a smooth gradient; else the world is black"""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    material = bpy.data.materials.new("M")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=(-1.1, 0.0, 0.0))
    bpy.context.object.data.shade_smooth()
    bpy.context.object.name = "Sphere"
    bpy.ops.mesh.primitive_cube_add(size=1.4, location=(1.2, 0.1, 0.0), rotation=(0.3, 0.2, 0.6))
    bpy.context.object.scale = (1.0, 0.8, 1.2)
    bpy.ops.mesh.primitive_plane_add(size=9.0, location=(0.0, 1.0, -1.05))
    for obj in scene.objects:
        obj.data.materials.append(material)
        obj.color = (0.2, 0.5, 0.9, 0.7)
        colors = obj.data.color_attributes.new("Col", "FLOAT_COLOR", "CORNER")
        loops = np.arange(len(obj.data.loops))
        rgba = np.stack([loops % 3 / 2, loops % 5 / 4, loops % 7 / 6, 1 - loops % 2 / 2], -1)
        colors.data.foreach_set("color", rgba.astype(np.float32).ravel())
    bpy.ops.object.camera_add(location=(0.3, -6.0, 1.6), rotation=(math.radians(77), 0.0, 0.05))
    scene.camera = bpy.context.object
    scene.camera.data.lens = 52.0
    _world(scene, lit)
    return scene, Tree(material.node_tree)


def _world(scene, lit):
    world = scene.world = bpy.data.worlds.new("W")
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    if not lit:
        return
    rows, columns = np.mgrid[0:32, 0:64] / np.array([32.0, 64.0])[:, None, None]
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[..., 0] = 0.3 + rows
    pixels[..., 1] = 0.5 + 0.4 * np.sin(2 * np.pi * columns)
    pixels[..., 2] = 0.2 + 2.0 * rows**2 + 0.4 * np.cos(2 * np.pi * columns) ** 2
    image = bpy.data.images.new("G", 64, 32, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    world.node_tree.links.new(texture.outputs[0], background.inputs["Color"])


def picture(name="P", alpha=False, float_buffer=False, width=16, height=12):
    """A packed image of smooth colours with a few hard edges; alpha: a hole, and half a side."""
    image = bpy.data.images.new(name, width, height, alpha=alpha, float_buffer=float_buffer)
    rows, columns = np.mgrid[0:height, 0:width]
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., 0] = columns / (width - 1)
    pixels[..., 1] = rows / (height - 1)
    pixels[..., 2] = 0.2 + 0.6 * ((rows // 3 + columns // 4) % 2)
    if alpha:
        hole = (rows - height / 2) ** 2 + (columns - width / 2) ** 2 < (height / 3) ** 2
        pixels[..., 3] = np.where(hole, 0.0, np.where(columns < width / 4, 0.5, 1.0))
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image

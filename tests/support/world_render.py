"""What Cycles sees of the world in all directions: the yardstick of the world's export."""

import math

import bpy
import numpy as np
from mathutils import Euler

from support.cycles_render import render_cycles

# The six axes, and two directions that have no axis, pole or seam in their middle.
_LOOKS = [
    (0.0, 0.0, 0.0),
    (math.pi, 0.0, 0.0),
    *((math.pi / 2, 0.0, quarter * math.pi / 2) for quarter in range(4)),
    (0.7, 0.4, 0.3),
    (2.1, 0.2, 2.5),
]
_PIXELS = 96
_HALF_ANGLE = math.radians(46.0)


def new_world(scene):
    """The node tree of a new world, empty; the scene gets a camera."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.angle = 2.0 * _HALF_ANGLE
    scene.render.resolution_x = scene.render.resolution_y = _PIXELS
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0):
        scene.world.use_nodes = True
    scene.world.node_tree.nodes.clear()
    return scene.world.node_tree


def pixel_directions() -> np.ndarray:
    """float32 (n, 3), unit: the world direction of each pixel of ``cycles_background``."""
    across = ((np.arange(_PIXELS) + 0.5) / _PIXELS * 2.0 - 1.0) * math.tan(_HALF_ANGLE)
    x, y = np.meshgrid(across, across)
    local = np.stack([x, y, -np.ones_like(x)], -1).reshape(-1, 3)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    world = [local @ np.array(Euler(look).to_matrix()).T for look in _LOOKS]
    return np.concatenate(world).astype(np.float32)


def cycles_background(scene, folder) -> np.ndarray:
    """float32 (n, 3): the world as eight perspective cameras see it, one ray a pixel's centre."""
    if scene.world is not None:
        scene.world.cycles.sampling_method = "NONE"  # no importance map: 4 ms instead of 1 s
    parts = []
    for look in _LOOKS:
        scene.camera.rotation_euler = look
        bpy.context.view_layer.update()
        layers = render_cycles(scene, folder, passes=())
        parts.append(layers["Combined"][..., :3].reshape(-1, 3))
    return np.concatenate(parts)

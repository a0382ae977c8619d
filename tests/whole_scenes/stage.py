"""The scene that assets and operators are put into, and what a scene of the list is.

Runs in the bpy module and in a Blender program, so it imports neither IWIS by name nor OpenEXR.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np
from parity.scene import empty_scene


class Whole(NamedTuple):
    """build() makes the scene in the open file, and may return a remark for the table."""

    group: str
    name: str
    build: Callable


class Missing(Exception):
    """This Blender has no such thing."""


def stage():
    """A floor under a smooth sky, seen from the front: (scene, material of all)."""
    scene, tree = empty_scene(True)
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.7, 0.4, 0.25)}))
    for obj in list(scene.objects):
        if obj.type == "MESH" and obj.name != "Plane":
            bpy.data.objects.remove(obj)
    floor = bpy.data.objects["Plane"]
    floor.select_set(False)
    scene.render.resolution_x, scene.render.resolution_y = 72, 48
    return scene, floor.data.materials[0]


def add_surface(material):
    """A smooth sphere with a UV map, active and selected."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, location=(0.2, 0.0, 0.0))
    obj = bpy.context.object
    obj.name = "Surface"
    obj.data.shade_smooth()
    obj.data.materials.append(material)
    return obj


def add_hair(material, strands=120, keys=8):
    """A hair object on a sphere, as Add > Curve > Empty Hair makes it, with strands."""
    surface = add_surface(material)
    bpy.ops.object.curves_empty_hair_add()
    hair, data = bpy.context.object, bpy.context.object.data
    data.add_curves([keys] * strands)
    rng = np.random.default_rng(2)
    out = rng.normal(size=(strands, 3))
    out[:, 2] = np.abs(out[:, 2])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    t = np.linspace(1.0, 1.5, keys)[None, :, None]
    places = out[:, None] * t + (0.0, 0.0, -0.3) * (t - 1.0) ** 2
    data.position_data.foreach_set("vector", places.astype(np.float32).ravel())
    attributes = data.attributes
    radius = attributes.get("radius") or attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(np.linspace(0.02, 0.005, keys), strands))
    name = "surface_uv_coordinate"
    uv = attributes.get(name) or attributes.new(name, "FLOAT2", "CURVE")
    where = np.stack([np.arctan2(out[:, 1], out[:, 0]) / (2 * np.pi) + 0.5, out[:, 2] * 0.49 + 0.5])
    uv.data.foreach_set("vector", np.ascontiguousarray(where.T, np.float32).ravel())
    data.materials.append(material)
    return hair, surface

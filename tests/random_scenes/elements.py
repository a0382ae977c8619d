"""Random points and strands."""

from __future__ import annotations

import bpy
import numpy as np

from .dice import Dice


def add_elements(dice: Dice, material) -> None:
    """A cloud of points, hair curves, or particle hair; material: an opaque one."""
    kind = dice.of(_points, _curves, _hair)
    dice.tell(kind.__name__[1:])
    kind(dice, material)


def _placed(dice, name, data, material):
    data.materials.append(material)
    obj = bpy.data.objects.new(name, data)
    obj.location = (dice.between(-1.0, 1.0), dice.between(-0.5, 0.5), 0.0)
    obj.color = (*dice.color(), 1.0)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _points(dice, material):
    n = dice.whole(1, 40)
    data = bpy.data.pointclouds.new("Points")
    data.resize(n)
    places = np.array([dice.vector(-0.8, 0.8) for _ in range(n)], np.float32)
    data.attributes["position"].data.foreach_set("vector", places.ravel())
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    sizes = np.array([dice.between(0.05, 0.3) for _ in range(n)], np.float32)
    radius.data.foreach_set("value", sizes)
    _placed(dice, "Points", data, material)


def _curves(dice, material):
    bpy.context.scene.cycles_curves.shape = "THICK"
    n, steps = dice.whole(1, 12), dice.whole(2, 6)
    data = bpy.data.hair_curves.new("Curves")
    data.add_curves([steps] * n)
    places = []
    for _ in range(n):
        root, way = np.array(dice.vector(-0.8, 0.8)), np.array(dice.vector(-0.3, 0.3))
        places += [root + k * way + 0.1 * k * k / steps for k in range(steps)]
    data.position_data.foreach_set("vector", np.array(places, np.float32).ravel())
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.full(n * steps, dice.between(0.04, 0.12), np.float32))
    _placed(dice, "Curves", data, material)


def _hair(dice, material):
    bpy.context.scene.cycles_curves.shape = "THICK"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
    emitter = bpy.context.object
    emitter.data.materials.append(material)
    settings = emitter.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = "HAIR", dice.whole(5, 40)
    settings.hair_length, settings.root_radius = dice.between(0.2, 0.6), dice.between(3.0, 8.0)
    settings.tip_radius = dice.of(0.0, 2.0)

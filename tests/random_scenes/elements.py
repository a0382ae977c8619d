"""Random points and strands."""

from __future__ import annotations

import bpy
import numpy as np
from parity.element_cases import add_curves, add_points

from .dice import Dice
from .materials import POINT, STRAND, material


def add_elements(dice: Dice) -> None:
    """A cloud of points, hair curves, or particle hair, opaque."""
    # Cut open by the near plane they are hollow here, and not there in Cycles.
    bpy.context.scene.camera.data.clip_start = 0.1
    kind = dice.of(_points, _curves, _hair)
    dice.tell(kind.__name__[1:])
    kind(dice, material(dice, POINT if kind is _points else STRAND))


def _points(dice, material):
    n = dice.whole(1, 40)
    places = np.array([dice.vector(-0.8, 0.8) for _ in range(n)], np.float32)
    sizes = np.array([dice.between(0.05, 0.3) for _ in range(n)], np.float32)
    add_points(material, places, sizes, color=(*dice.color(), 1.0))


def _curves(dice, material):
    bpy.context.scene.cycles_curves.shape = "THICK"
    n, steps = dice.whole(1, 12), dice.whole(2, 6)
    places = np.empty((n, steps, 3), np.float32)
    for strand in places:
        root, way = np.array(dice.vector(-0.8, 0.8)), np.array(dice.vector(-0.3, 0.3))
        strand[:] = [root + k * way + 0.1 * k * k / steps for k in range(steps)]
    radii = np.full((n, steps), dice.between(0.04, 0.12), np.float32)
    add_curves(material, places, radii, color=(*dice.color(), 1.0))


def _hair(dice, material):
    bpy.context.scene.cycles_curves.shape = "THICK"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
    emitter = bpy.context.object
    emitter.data.materials.append(material)
    emitter.show_instancer_for_render = False  # hair on a mesh is another one in Cycles
    settings = emitter.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = "HAIR", dice.whole(5, 40)
    settings.hair_length, settings.root_radius = dice.between(0.2, 0.6), dice.between(3.0, 8.0)
    settings.tip_radius = dice.of(0.0, 2.0)

"""A seed's scene."""

from __future__ import annotations

import bpy

from . import elements, lamps, linking, materials, motion, shapes, views, worlds
from .dice import Dice


def build(seed: int):
    """Replace the open file by a random scene: (scene, what is in it)."""
    dice = Dice(seed)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    views.view(dice, scene)
    worlds.world(dice, scene)
    dark = "world black" in dice.told
    lamps.lamps(dice, scene, dice.whole(1, 3) if dark else dice.of(0, 0, 1, 2))
    chosen = [materials.material(dice) for _ in range(dice.whole(2, 4))]
    shapes.add_floor(dice, materials.material(dice, materials.OPAQUE))
    for _ in range(dice.whole(1, 4)):
        obj = shapes.add_object(dice, [dice.of(*chosen) for _ in range(dice.of(1, 1, 2))])
    if dice.chance(0.3):
        shapes.add_copies(dice, obj)
    if dice.chance(0.25):
        elements.add_elements(dice)
    if dice.chance(0.4):
        views.flags(dice, scene)
    if dice.chance(0.3):
        linking.link_lights(dice, scene)
        linking.object_settings(dice, scene)
    if dice.chance(0.25):
        linking.group_lights(dice, scene)
    if dice.chance(0.25):
        motion.motion(dice, scene)
    scene.cycles.transparent_max_bounces = 64
    bpy.context.view_layer.update()
    return scene, dice.told

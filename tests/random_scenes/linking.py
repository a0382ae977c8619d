"""Random light linking, shadow linking, and settings of objects."""

from __future__ import annotations

import bpy

from .dice import Dice

_SHOWN = "MESH", "CURVE", "FONT", "META"


def link_lights(dice: Dice, scene) -> None:
    """Have some lamps light some objects only, or have only some throw their shadows."""
    lamps = [obj for obj in scene.objects if obj.type == "LIGHT"]
    for lamp in lamps:
        if not dice.chance(0.4):
            continue
        for name in ("receiver_collection", "blocker_collection"):
            if dice.chance(0.6):
                dice.tell(name[:8])
                setattr(lamp.light_linking, name, _some(dice, scene))


def _some(dice, scene):
    made = bpy.data.collections.new("Links")
    for obj in scene.objects:
        if obj.type in _SHOWN and dice.chance(0.5):
            made.objects.link(obj)
    state = dice.of("INCLUDE", "EXCLUDE")
    for item in made.collection_objects:
        item.light_linking.link_state = state
    return made


def group_lights(dice: Dice, scene) -> None:
    """Light groups of lamps, of what may shine, and of the world; one of them may be empty."""
    layer = scene.view_layers[0]
    names = [f"G{k}" for k in range(dice.whole(1, 3))]
    for name in names:
        layer.lightgroups.add(name=name)
    for thing in (*scene.objects, scene.world):
        if dice.chance(0.7):
            thing.lightgroup = dice.of(*names)
    dice.tell("light groups")


def object_settings(dice: Dice, scene) -> None:
    """Shadow terminators of meshes, and which rays see lamps."""
    for obj in scene.objects:
        own = obj if hasattr(obj, "shadow_terminator_geometry_offset") else obj.cycles
        if obj.type == "MESH" and dice.chance(0.3):
            own.shadow_terminator_geometry_offset = dice.of(0.0, 0.3)
        if obj.type == "LIGHT":
            obj.visible_diffuse, obj.visible_glossy = not dice.chance(0.1), not dice.chance(0.1)

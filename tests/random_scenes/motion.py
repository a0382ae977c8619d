"""Random motion blur: of objects, cameras and shapes."""

from __future__ import annotations

import bpy

from .dice import Dice


def motion(dice: Dice, scene) -> None:
    """Open the shutter while some things move evenly from the frame before to the one after."""
    render = scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, dice.between(0.3, 1.2)
    render.motion_blur_position = dice.of("START", "CENTER", "END")
    scene.frame_set(5)
    movable = [obj for obj in scene.objects if obj.type in ("MESH", "CURVE", "FONT", "EMPTY")]
    movable = [obj for obj in movable if obj.parent is None and not obj.particle_systems]
    chosen = [obj for obj in movable if dice.chance(0.4)] or movable[-1:]
    if scene.camera.data.type == "PERSP" and dice.chance(0.3):
        chosen.append(scene.camera)
    for obj in chosen:
        dice.tell(f"moving {obj.name}")
        _KINDS[dice.of(*_KINDS) if obj.type != "CAMERA" else "location"](dice, obj)
    if dice.chance(0.4):
        _changing(dice, scene)
    for action in bpy.data.actions:
        for curve in _curves(action):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
    scene.frame_set(5)


def _curves(action):
    if hasattr(action, "fcurves"):
        return action.fcurves
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def _keyed(obj, path, values):
    for frame, value in zip((3, 7), values, strict=True):
        setattr(obj, path, value)
        obj.keyframe_insert(path, frame=frame)


def _located(dice, obj):
    middle, way = obj.location.copy(), [2.0 * part for part in dice.vector(-0.3, 0.3)]
    way = type(middle)(way)
    _keyed(obj, "location", (middle - way, middle + way))


def _turned(dice, obj):
    middle = [*obj.rotation_euler]
    way = dice.vector(-0.5, 0.5)
    ends = [[m + s * w for m, w in zip(middle, way, strict=True)] for s in (-1.0, 1.0)]
    _keyed(obj, "rotation_euler", ends)


def _sized(dice, obj):
    factor = dice.between(0.6, 0.9)
    _keyed(obj, "scale", (obj.scale.copy() * factor, obj.scale.copy() * (2.0 - factor)))


_KINDS = {"location": _located, "rotation": _turned, "scale": _sized}


def _changing(dice, scene):
    """A mesh that goes from one shape to another."""
    meshes = [obj for obj in scene.objects if obj.type == "MESH" and not obj.modifiers]
    meshes = [obj for obj in meshes if obj.data.shape_keys is None]
    meshes = [obj for obj in meshes if obj.data.users == 1 and obj.name != "Plane"]
    if not meshes:
        return
    obj = dice.of(*meshes)
    dice.tell(f"changing {obj.name}")
    obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name="Other", from_mix=False)
    for place in key.data:
        place.co = [a + b for a, b in zip(place.co, dice.vector(-0.1, 0.1), strict=True)]
    _keyed(key, "value", (0.0, 1.0))

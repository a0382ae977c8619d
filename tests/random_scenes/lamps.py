"""Random lamps, with textures too."""

from __future__ import annotations

import math

import bpy
from mathutils import Vector
from parity.scene import Tree

from . import values
from .dice import Dice


def lamps(dice: Dice, scene, n: int) -> None:
    """Add n lamps above a scene."""
    for _ in range(n):
        kind = dice.of("POINT", "SPOT", "SUN", "AREA")
        dice.tell(kind.lower())
        light = bpy.data.lights.new("Lamp", kind)
        light.color = dice.color(0.3, 1.0)
        light.normalize = not dice.chance(0.15)
        _SETTINGS[kind](dice, light)
        obj = bpy.data.objects.new("Lamp", light)
        obj.location = (dice.between(-3, 3), dice.between(-4, 3), dice.between(1.5, 4.0))
        target = Vector(dice.vector(-1.0, 1.0))
        obj.rotation_mode = "QUATERNION"
        obj.rotation_quaternion = (target - obj.location).to_track_quat("-Z", "Y")
        if dice.chance(0.2):
            obj.scale = dice.vector(0.6, 1.5)
        obj.visible_camera = dice.chance(0.2)
        light.use_shadow = not dice.chance(0.1)
        scene.collection.objects.link(obj)
        if kind != "SUN" and getattr(light, "spread", 1.0) > 0.0 and dice.chance(0.3):
            _textured(dice, light)


def _power(dice, light, area):
    light.energy = dice.between(30.0, 200.0) * (1.0 if light.normalize else 0.2 / max(area, 1e-3))


def _point(dice, light):
    radius = dice.edge(0.0, 0.5)
    light.shadow_soft_size, light.use_soft_falloff = radius, dice.chance(0.5)
    _power(dice, light, 4.0 * math.pi * radius**2 if radius else 4.0)


def _spot(dice, light):
    _point(dice, light)
    light.spot_size, light.spot_blend = math.radians(dice.between(20, 175)), dice.edge(0.0, 1.0)


def _sun(dice, light):
    light.angle = dice.edge(0.0, 0.6)
    light.energy = dice.between(0.3, 2.0)
    if not light.normalize:
        light.energy /= max(math.pi * math.sin(0.5 * light.angle) ** 2, 1e-2)


def _area(dice, light):
    light.shape = dice.of("SQUARE", "RECTANGLE", "DISK", "ELLIPSE")
    light.size, light.size_y = dice.spread(0.2, 2.0), dice.spread(0.2, 2.0)
    light.spread = dice.of(math.pi, dice.between(0.3, 3.0))
    _power(dice, light, light.size * light.size_y)


_SETTINGS = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}


def _textured(dice, light):
    if bpy.app.version < (5, 0):
        light.use_nodes = True
    tree = Tree(light.node_tree, "ShaderNodeOutputLight")
    names = ["UV"] if light.type == "SPOT" else ["UV", "Normal"]
    names += ["Object"] if light.type == "AREA" else []
    vector = tree.coordinates(dice.of(*names))
    kind = dice.of("Checker", "Noise", "Magic")
    inputs = {"Vector": vector, "Scale": dice.spread(1.0, 5.0)}
    pattern = tree.made(f"ShaderNodeTex{kind}", "Color", inputs)
    if dice.chance(0.3):
        pattern = tree.made("ShaderNodeGamma", 0, {"Color": pattern, "Gamma": 1.5})
    strength = values.number(dice, tree, 0.5, 1.5, depth=0)
    tree.surface(tree.made("ShaderNodeEmission", 0, {"Color": pattern, "Strength": strength}))
    dice.tell("textured")

"""Lamps and meshes that shine whose light falls off otherwise than with the squared distance."""

from __future__ import annotations

import math

import bpy

from .cases import lit_by, world
from .emitter_cases import glowing
from .lamp_cases import ABOVE, SIDE, add_lamp, dressed, matte, shiny
from .lit_cases import image_of

_CAMERA, _NEAR, _BESIDE = (0.3, -6.0, 1.6), (0.2, -0.6, 1.4), (0.2, 0.5, 1.1)


def _falls(output, strength=1.0, smooth=0.0):
    """The output of a Light Falloff node as a function of the tree."""
    inputs = {"Strength": strength, "Smooth": smooth}
    return lambda tree: tree.made("ShaderNodeLightFalloff", output, inputs)


def _shader(strength, color=None):
    """An Emission of a strength(tree), and of a color(tree) or white."""

    def shader(tree):
        own = (1.0, 0.8, 0.5) if color is None else color(tree)
        return tree.made("ShaderNodeEmission", 0, {"Color": own, "Strength": strength(tree)})

    return shader


def _case(name, shader, kind, location, make=matte, seen=False, world=False, **options):
    def build(scene, tree):
        target = {"target": _CAMERA} if seen else {}
        lamp = add_lamp(scene, kind, location, visible_camera=seen, **target, **options)
        dressed(lamp, shader)
        tree.surface(make(tree))

    lit_by(f"Falloff: {name}", build, world=world or seen, blurred=seen)


def _sum(tree):
    """Two falloffs of one strength, added."""
    parts = {0: _falls("Linear", 0.5)(tree), 1: _falls("Constant", 0.05, 1.0)(tree)}
    return tree.made("ShaderNodeMath", 0, parts, operation="ADD")


def _by_distance(tree):
    """Warm near the lamp, cold far from it."""
    far = tree.made("ShaderNodeLightPath", "Ray Length")
    inputs = {"Value": far, "From Min": 1.0, "From Max": 5.0}
    node = tree.node("ShaderNodeMix", data_type="RGBA")
    tree.link(tree.made("ShaderNodeMapRange", 0, inputs), node.inputs[0])
    node.inputs[6].default_value = (1.0, 0.5, 0.1, 1.0)
    node.inputs[7].default_value = (0.2, 0.4, 1.0, 1.0)
    return node.outputs[2]


_POINT = {"energy": 100.0, "shadow_soft_size": 0.0}
_BALL = {"energy": 100.0, "shadow_soft_size": 0.4, "use_soft_falloff": False}
_SOFT = {"energy": 100.0, "shadow_soft_size": 0.4, "use_soft_falloff": True}
_SPOT = {"energy": 200.0, "spot_size": math.radians(40.0), "shadow_soft_size": 0.2}
_AREA = {"energy": 60.0, "shape": "RECTANGLE", "size": 2.0, "size_y": 1.2}
_LINEAR, _CONSTANT = _falls("Linear"), _falls("Constant", 0.3)
_METAL = shiny(0.15, Metallic=1.0)

_case("point, linear", _shader(_LINEAR), "POINT", ABOVE, **_POINT)
_case("point, constant", _shader(_CONSTANT), "POINT", ABOVE, **_POINT)
_case("point, quadratic, smooth", _shader(_falls("Quadratic", 2.0, 9.0)), "POINT", ABOVE, **_POINT)
_case("point, near, smooth", _shader(_falls("Quadratic", 1.0, 1.0)), "POINT", _NEAR, **_POINT)
_case("point, two added", _shader(_sum), "POINT", _NEAR, **_POINT)
_case("point, color by distance", _shader(_LINEAR, _by_distance), "POINT", _NEAR, **_POINT)
_case("ball, linear", _shader(_LINEAR), "POINT", _NEAR, **_BALL)
_case("ball, linear, in gloss", _shader(_LINEAR), "POINT", SIDE, _METAL, **_BALL)
_case("soft ball, constant", _shader(_CONSTANT), "POINT", _NEAR, **_SOFT)
_case("spot, linear", _shader(_LINEAR), "SPOT", ABOVE, **_SPOT)
_case("spot, constant, smooth", _shader(_falls("Constant", 0.4, 4.0)), "SPOT", ABOVE, **_SPOT)
_case("spot, image", _shader(_LINEAR, image_of), "SPOT", ABOVE, **_SPOT | {"shadow_soft_size": 0.0})
_case("area, linear", _shader(_LINEAR), "AREA", ABOVE, **_AREA)
_case("area, constant, under a world", _shader(_CONSTANT), "AREA", _NEAR, world=True, **_AREA)
_case("area, image", _shader(_LINEAR, image_of), "AREA", ABOVE, **_AREA)
_case(
    "area, image, in a mirror",
    _shader(_LINEAR, image_of),
    "AREA",
    SIDE,
    shiny(0.0, Metallic=1.0),
    **_AREA,
)
_case("area, spread 0", _shader(_CONSTANT), "AREA", ABOVE, spread=0.0, **_AREA)
_case("sun, linear", _shader(_falls("Linear", 1.5)), "SUN", SIDE, energy=2.0, angle=0.1)
_case("sun, constant, smooth", _shader(_falls("Constant", 1.5, 4.0)), "SUN", SIDE, energy=2.0)
_case("seen area, linear", _shader(_LINEAR), "AREA", _BESIDE, seen=True, **_AREA | {"energy": 5.0})
_case(
    "seen ball, constant",
    _shader(_CONSTANT),
    "POINT",
    _BESIDE,
    seen=True,
    **_BALL | {"energy": 5.0},
)


def _mesh(name, shader, place, make=matte, size=1.2, **options):
    """A square that shines."""

    def build(scene, tree):
        bpy.ops.mesh.primitive_plane_add(size=size, location=place, rotation=(0.6, -0.9, 0.3))
        bpy.context.object.data.materials.append(glowing(shader))
        tree.surface(make(tree))

    lit_by(f"Falloff: {name}", build, **options)


_mesh("mesh, linear", _shader(_falls("Linear", 3.0)), SIDE)
_mesh("mesh, constant", _shader(_falls("Constant", 1.0)), SIDE)
_mesh("mesh, smooth, near", _shader(_falls("Quadratic", 8.0, 1.0)), (0.1, -0.6, 0.2), size=0.5)
_mesh("mesh, linear, in gloss", _shader(_falls("Linear", 3.0)), SIDE, _METAL)
_mesh("mesh, image", _shader(_falls("Linear", 3.0), image_of), SIDE, blurred=True)
_mesh("mesh, seen", _shader(_falls("Linear", 0.3)), (0.2, 0.5, 1.1))


def _sky(tree):
    """A world of one colour, with a node that does nothing there."""
    strength = _falls("Linear", 0.7, 2.0)(tree)
    return tree.made("ShaderNodeBackground", 0, {"Color": (0.5, 0.6, 0.7), "Strength": strength})


world("Falloff: world, linear, smooth", _sky)

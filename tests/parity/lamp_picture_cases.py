"""Lamps whose nodes vary over them: softboxes, gobos, what is seen of them."""

from __future__ import annotations

import math

import bpy

from .cases import lit_by
from .lamp_cases import ABOVE, SIDE, add_lamp, dressed, matte, shiny
from .lit_cases import image_of

_CAMERA, _BESIDE = (0.3, -6.0, 1.6), (0.2, 0.5, 1.1)


def _colored(color):
    """An Emission of a color that color(tree) makes."""
    inputs = {"Strength": 1.5}
    return lambda t: t.made("ShaderNodeEmission", 0, inputs | {"Color": color(t)})


def _case(name, color, kind, location, make=matte, seen=False, **options):
    def build(scene, tree):
        target = {"target": _CAMERA} if seen else {}
        lamp = add_lamp(scene, kind, location, visible_camera=seen, **target, **options)
        dressed(lamp, _colored(color))
        tree.surface(make(tree))

    lit_by(f"Lamp's nodes: {name}", build, world=seen, blurred=seen)


def _of(kind, output, inputs=None, scale=1.0, **properties):
    """A texture of the default coordinates, or of those that inputs names."""

    def color(tree):
        vector = {} if inputs is None else {"Vector": tree.coordinates(inputs)}
        return tree.made(kind, output, vector | {"Scale": scale}, **properties)

    return color


def _place(kind, output):
    """A coordinate as a colour: of 2 m and more none is negative."""

    def color(tree):
        place = tree.made(kind, output)
        half = {0: place, 1: (0.15, 0.15, 0.15), 2: (0.5, 0.5, 0.5)}
        node = tree.node("ShaderNodeVectorMath", operation="MULTIPLY_ADD")
        for key, value in half.items():
            tree.link(value, node.inputs[key])
        return node.outputs[0]

    return color


def _rim(tree):
    """A softbox: bright in the middle of the lamp's own map."""
    place = tree.made("ShaderNodeMapping", 0, {"Vector": tree.coordinates("UV")})
    mapping = place.node
    mapping.inputs["Location"].default_value = (-1.0, -1.0, 0.0)
    mapping.inputs["Scale"].default_value = (2.0, 2.0, 0.0)
    gradient = tree.node("ShaderNodeTexGradient", gradient_type="SPHERICAL")
    tree.link(place, gradient.inputs[0])
    return gradient.outputs["Color"]


def luminaire(horizontal, vertical, value):
    """An IES texture of a table; value(h, v): candela."""

    def color(tree):
        rows = [" ".join(f"{value(h, v):.1f}" for v in vertical) for h in horizontal]
        text = bpy.data.texts.new("Table.ies")
        head = f"1 -1 1 {len(vertical)} {len(horizontal)} 1 2 0 0 0\n1 1 100"
        angles = (" ".join(map(str, angles)) for angles in (vertical, horizontal))
        text.from_string("\n".join(["IESNA:LM-63-2002", "TILT=NONE", head, *angles, *rows]))
        node = tree.node("ShaderNodeTexIES", mode="INTERNAL", ies=text)
        return node.outputs[0]

    return color


def wedges(h, v):
    """Candela of a luminaire that shines more to some sides, and in rings."""
    rings = 1.0 + math.cos(math.radians(9.0 * v))
    return 20.0 * rings * (1.5 + math.sin(math.radians(3.0 * h)))


_STEPS = tuple(range(0, 91, 10))
_FULL = luminaire(range(0, 361, 20), _STEPS, wedges)
_QUARTER = luminaire((0, 30, 60, 90), _STEPS, wedges)
_NOISE = _of("ShaderNodeTexNoise", "Color", scale=4.0)
_CHECKER = _of("ShaderNodeTexChecker", "Color", "UV", scale=4.0)
_SCALED_NOISE = _of("ShaderNodeTexNoise", "Color", "UV", scale=4.0)
_ON_IT = _of("ShaderNodeTexNoise", "Color", "Object", scale=3.0)
_NORMAL = _place("ShaderNodeTexCoord", "Normal")
_UNEVEN = (0.6, 1.5, 1.0)
_AREA = {"energy": 200.0, "shape": "RECTANGLE", "size": 2.0, "size_y": 1.2}
_DISK = {"energy": 200.0, "shape": "DISK", "size": 1.6}
_SPOT = {"energy": 600.0, "spot_size": math.radians(40.0), "shadow_soft_size": 0.0}
_BALL = {"energy": 300.0, "shadow_soft_size": 0.4, "use_soft_falloff": False}
_LARGE = _SPOT | {"shadow_soft_size": 0.3, "use_soft_falloff": False}
_SOFT = {"energy": 300.0, "shadow_soft_size": 0.4, "use_soft_falloff": True}

_case("softbox", _rim, "AREA", ABOVE, **_AREA)
_case("softbox in gloss", _rim, "AREA", SIDE, shiny(0.15, Metallic=1.0), **_AREA)
_case("softbox in a mirror", _rim, "AREA", SIDE, shiny(0.0, Metallic=1.0), **_AREA)
_case("area, image", image_of, "AREA", ABOVE, **_AREA)
_case("area near, soft", _rim, "AREA", (0.2, -0.6, 0.4), **_AREA | {"size": 0.6})
_case("area, noise, scaled", _NOISE, "AREA", ABOVE, scale=(1.5, 0.6, 1.0), **_AREA)
_case("disk, checker, spread", _CHECKER, "AREA", ABOVE, spread=math.radians(80.0), **_DISK)
_case("area, position", _place("ShaderNodeNewGeometry", "Position"), "AREA", SIDE, **_AREA)
_case("spot, checker", _CHECKER, "SPOT", ABOVE, **_SPOT)
_case("spot, image, scaled", image_of, "SPOT", ABOVE, scale=(1.5, 0.8, 1.0), **_SPOT)
_case("spot, wide", _CHECKER, "SPOT", ABOVE, **_SPOT | {"spot_size": math.radians(170.0)})
_case("large spot, checker", _CHECKER, "SPOT", ABOVE, **_LARGE)
_case("large spot, image, scaled", image_of, "SPOT", ABOVE, scale=(1.5, 0.8, 1.0), **_LARGE)
_case("large spot, wide", _CHECKER, "SPOT", ABOVE, **_LARGE | {"spot_size": math.radians(170.0)})
_case("large spot, normal", _NORMAL, "SPOT", ABOVE, **_LARGE)
_case("ball, normal", _NORMAL, "POINT", SIDE, **_BALL)
_case("point, image", image_of, "POINT", ABOVE, **_BALL | {"shadow_soft_size": 0.0})
_case("ball, image", image_of, "POINT", SIDE, shiny(0.1, Metallic=1.0), **_BALL)
_case("soft ball, normal", _NORMAL, "POINT", SIDE, **_SOFT)
_case("soft ball, noise, scaled", _SCALED_NOISE, "POINT", SIDE, scale=_UNEVEN, **_SOFT)
_case("soft ball, place on it", _ON_IT, "POINT", ABOVE, **_SOFT)
_case("soft ball, place on it, scaled", _ON_IT, "POINT", ABOVE, scale=_UNEVEN, **_SOFT)
_case("soft spot, place on it", _ON_IT, "SPOT", ABOVE, **_SPOT | {"shadow_soft_size": 0.3})
_case("ball, normal, scaled", _NORMAL, "POINT", SIDE, scale=_UNEVEN, **_BALL)
_case("seen area, image", image_of, "AREA", _BESIDE, seen=True, **_AREA | {"energy": 20.0})
_case("seen ball, image", image_of, "POINT", _BESIDE, seen=True, **_BALL | {"energy": 30.0})
_case("seen spot, image", image_of, "SPOT", _BESIDE, seen=True, **_SPOT | {"shadow_soft_size": 0.4})
_case("IES, point", _FULL, "POINT", ABOVE, **_BALL | {"shadow_soft_size": 0.0})
_case("IES, quarter", _QUARTER, "POINT", (0.2, -0.6, 1.4), **_SOFT)
_case("IES, ball", _FULL, "POINT", (0.2, -0.6, 1.4), **_BALL)
_case("IES, spot", _FULL, "SPOT", ABOVE, **_SPOT | {"spot_size": math.radians(120.0)})
_case("IES, area", _FULL, "AREA", (0.2, -0.6, 1.4), **_AREA | {"size": 0.5, "size_y": 0.3})

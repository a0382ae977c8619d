"""Lamps that the camera sees behind panes, and before them."""

from __future__ import annotations

import math

import bpy

from .cases import lit_by
from .emitter_cases import material_of
from .lamp_cases import add_lamp, matte
from .lit_cases import image_of, noise_of

_CAMERA, _BESIDE, _BEFORE = (0.3, -6.0, 1.6), (0.2, 0.5, 1.1), (0.3, -2.5, 0.8)
_AREA = {"energy": 20.0, "size": 1.2}
_BALL = {"energy": 30.0, "shadow_soft_size": 0.4, "use_soft_falloff": False}


def _pane(make, across):
    """A large upright square of a shader make(tree), across the view at a distance from it."""
    bpy.ops.mesh.primitive_plane_add(size=3.0, location=(0.9, across, 0.6), rotation=(1.5, 0, 0.1))
    bpy.context.object.data.materials.append(material_of("Pane", make))


def _case(name, kind, location, *panes, film=False, world=True, **options):
    """panes: (make, across) each; film: transparent"""

    def build(scene, tree):
        scene.render.film_transparent = film
        add_lamp(scene, kind, location, _CAMERA, visible_camera=True, **options)
        for pane in panes:
            _pane(*pane)
        tree.surface(matte(tree))

    lit_by(f"Lamp behind panes: {name}", build, world=world, blurred=True, with_alpha=film)


def _clear(color):
    return lambda tree: tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})


def _stained(tree):
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": image_of(tree)})


def _half(tree):
    """Paint that lets a part through, by a noise."""
    inputs = {"Base Color": (0.2, 0.5, 0.3), "Alpha": noise_of(tree)}
    return tree.made("ShaderNodeBsdfPrincipled", 0, inputs)


def _glowing(tree):
    """Tinted, and it shines."""
    glow = tree.made("ShaderNodeEmission", 0, {"Color": (0.2, 0.1, 0.4), "Strength": 0.4})
    return tree.made("ShaderNodeAddShader", 0, {0: _clear((0.9, 0.6, 0.2))(tree), 1: glow})


_RED, _BLUE = _clear((0.9, 0.3, 0.2)), _clear((0.3, 0.5, 1.0))

_case("area, red", "AREA", _BESIDE, (_RED, -1.5), **_AREA)
_case("area, red before and blue behind", "AREA", _BESIDE, (_RED, -1.5), (_BLUE, 1.5), **_AREA)
_case("area, two panes", "AREA", _BESIDE, (_RED, -1.5), (_BLUE, -2.0), **_AREA)
# Nearer than the offset by which rays start off a surface.
_case("area, two panes a hair apart", "AREA", _BESIDE, (_RED, -1.5), (_BLUE, -1.499995), **_AREA)
_case("area before a pane", "AREA", _BEFORE, (_RED, -1.0), **_AREA | {"size": 0.6})
_case("ball, stained", "POINT", _BESIDE, (_stained, -1.5), **_BALL)
_case("ball, partial alpha", "POINT", _BESIDE, (_half, -1.5), **_BALL)
_case("ball, a pane that glows", "POINT", _BESIDE, (_glowing, -1.5), **_BALL)
_case("ball, transparent film", "POINT", _BESIDE, (_RED, -1.5), film=True, **_BALL)
_case("sun", "SUN", (0.8, 6.0, 1.5), (_BLUE, -1.5), energy=1.0, angle=math.radians(12.0))

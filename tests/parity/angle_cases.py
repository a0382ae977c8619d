"""Shadows of surfaces that let light through by the angle at which it meets them."""

from __future__ import annotations

import bpy

from .cases import lit_by
from .clear_cases import new_material
from .lamp_cases import add_lamp, matte
from .lit_cases import noise_of

_WHITE, _TINT, _BLACK = (1.0, 1.0, 1.0), (0.9, 0.5, 0.2), (0.0, 0.0, 0.0)


def _mixed(share, color):
    """Black, and clear by what share(tree) leaves."""

    def make(tree):
        mix = tree.node("ShaderNodeMixShader")
        clear = tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})
        black = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": _BLACK})
        for value, socket in zip((share(tree), clear, black), mix.inputs, strict=True):
            tree.link(value, socket)
        return mix.outputs[0]

    return make


def _plane():
    bpy.ops.mesh.primitive_plane_add(size=4.0, location=(0.2, 0.3, 2.2), rotation=(0.9, 0.3, 0.2))


def _ball():
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=12, ring_count=8, radius=1.3, location=(0.3, 0, 2.0)
    )
    bpy.ops.object.shade_smooth()


def _case(name, add, share, color=_WHITE, kind="SUN"):
    """What add() adds, which the camera does not see, before a lamp and an even world."""

    def build(scene, tree):
        sun = {"energy": 2.0, "angle": 0.3}
        options = sun if kind == "SUN" else {"energy": 300.0, "size": 1.0}
        add_lamp(scene, kind, (-1.0, 0.5, 5.0), (0.0, 0.0, 0.0), **options)
        tree.surface(matte(tree))
        add()
        card = bpy.context.object
        card.visible_camera = False
        card.data.materials.append(new_material(_mixed(share, color)))

    lit_by(f"Shadow by angle: {name}", build, world=True)


def _fresnel(tree):
    return tree.made("ShaderNodeFresnel", 0, {"IOR": 1.5})


def _facing(tree):
    return tree.made("ShaderNodeLayerWeight", "Facing", {"Blend": 0.6})


def _backfacing(tree):
    return tree.made("ShaderNodeNewGeometry", "Backfacing")


def _by_place(tree):
    inputs = {0: _fresnel(tree), 1: noise_of(tree)}
    return tree.made("ShaderNodeMath", 0, inputs, operation="MULTIPLY")


_case("Fresnel, a plane", _plane, _fresnel)
_case("Fresnel, a smooth ball", _ball, _fresnel)
_case("facing, a plane, tinted", _plane, _facing, _TINT)
_case("facing, a smooth ball, tinted, area lamp", _ball, _facing, _TINT, "AREA")
_case("the back, a ball", _ball, _backfacing)
_case("Fresnel by noise, a plane", _plane, _by_place)

"""Stacks of surfaces that let light through: how many of them a ray may pass."""

from __future__ import annotations

import bpy

from .cases import CASES, Case
from .emitter_cases import material_of
from .lamp_cases import ABOVE, add_lamp, matte
from .lit_cases import noise_of


def _pane(make, across, shadow):
    """A large upright square across the view, at a distance from it."""
    bpy.ops.mesh.primitive_plane_add(size=3.0, location=(0.9, across, 0.6), rotation=(1.5, 0, 0.1))
    bpy.context.object.visible_shadow = shadow
    bpy.context.object.data.materials.append(material_of("Pane", make))


def _case(name, most, panes, shadow=False, film=False, base=matte):
    """most: surfaces that a ray may pass; panes: shaders make(tree), one behind the other
    base: of all else

    Under a lamp without size: Cycles' rays by the BSDF meet what throws no shadow, too.
    """

    def build(scene, tree):
        scene.render.film_transparent = film
        scene.cycles.transparent_max_bounces = scene.iwis.transparent_max_bounces = most
        for k, make in enumerate(panes):
            _pane(make, -2.5 + 0.3 * k, shadow)
        add_lamp(scene, "POINT", ABOVE, energy=300.0, shadow_soft_size=0.0)
        tree.surface(base(tree))

    CASES.append(Case(name, build, by_lamps=True, blurred=True, with_alpha=film))


def _clear(tree):
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": (0.9, 0.7, 0.5)})


def _half(tree):
    """Paint that lets a part through, by a noise."""
    inputs = {"Base Color": (0.2, 0.5, 0.3), "Alpha": noise_of(tree)}
    return tree.made("ShaderNodeBsdfPrincipled", 0, inputs)


def _glowing(tree):
    glow = tree.made("ShaderNodeEmission", 0, {"Color": (0.2, 0.1, 0.4), "Strength": 0.4})
    return tree.made("ShaderNodeMixShader", 0, {0: 0.6, 1: glow, 2: _clear(tree)})


def _added(tree):
    glow = tree.made("ShaderNodeEmission", 0, {"Color": (0.2, 0.1, 0.4), "Strength": 0.4})
    return tree.made("ShaderNodeAddShader", 0, {0: _clear(tree), 1: glow})


for _most in (0, 1, 2, 3):
    _case(f"Transparent bounces: {_most}, two panes", _most, [_clear] * 2)


def _black(tree):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.0, 0.0, 0.0)})


for _most in (2, 8):
    _case(f"Transparent bounces: {_most}, four cut-outs", _most, [_half] * 4)
    for _name, _make in {"mixed, glowing": _glowing, "added, glowing": _added}.items():
        # What glows lights all else, which is not looked at here.
        _case(f"Transparent bounces: {_most}, four {_name}", _most, [_make] * 4, base=_black)
_case("Transparent bounces: 2, two panes, transparent film", 2, [_clear] * 2, film=True)
_case("Transparent bounces: 1, cut-outs, transparent film", 1, [_half] * 3, film=True)

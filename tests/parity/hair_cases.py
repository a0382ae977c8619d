"""Strands of Principled Hair and the Hair BSDF beside Cycles', and translucent ones; a matte floor.

Cycles' round 3D curves, but for one case: ribbons have other edges (docs/decisions/0027). Strands
are thin: rays start on their far side, and so beyond what touches them.
"""

from __future__ import annotations

import bpy
import numpy as np

from .cases import CASES, Case
from .element_cases import (
    add_curves,
    add_particle_hair,
    add_points,
    bent_strands,
    on_a_matte_floor,
    without_solids,
)
from .lamp_cases import add_lamp

_FILTER = 1.5  # pixels; Cycles' default


def _case(name, build):
    CASES.append(Case(name, build, lit=True, blurred=True, filter_width=_FILTER))


def _principled(parametrization="COLOR", mixed=False, **inputs):
    def material(tree):
        kind = "ShaderNodeBsdfHairPrincipled"
        node = tree.node(kind, model="CHIANG", parametrization=parametrization)
        for name, value in inputs.items():
            tree.link(value, node.inputs[name.replace("_", " ")])
        if not mixed:
            return tree.surface(node.outputs[0])
        mix = tree.node("ShaderNodeMixShader")
        diffuse = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.2, 0.6, 0.3)})
        for value, socket in zip((0.4, node.outputs[0], diffuse), mix.inputs, strict=True):
            tree.link(value, socket)
        return tree.surface(mix.outputs[0])

    return material


def _bells(component, **inputs):
    def material(tree):
        inputs_ = {"Color": (0.8, 0.6, 0.3), **inputs}
        tree.surface(tree.made("ShaderNodeBsdfHair", 0, inputs_, component=component))

    return material


def _translucent(tree):
    tree.surface(tree.made("ShaderNodeBsdfTranslucent", 0, {"Color": (0.8, 0.5, 0.2)}))


def _under(weight):
    """Light from under a surface, which nothing but meshes gives in Cycles."""

    def material(tree):
        inputs = {"Subsurface Weight": weight, "Subsurface Scale": 0.05}
        inputs["Base Color"] = (0.8, 0.5, 0.2)
        tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs))

    return material


def _strands(name, material, count=80, keys=6, size=(0.05, 0.015), shape="THICK", lamp=False):
    def build(scene, tree):
        material(tree)
        on_a_matte_floor()
        scene.cycles_curves.shape = shape
        places = bent_strands(count, keys)
        radii = np.broadcast_to(np.linspace(*size, keys), (count, keys))
        add_curves(without_solids(scene), places, radii)
        if lamp:
            add_lamp(scene, "POINT", (1.5, 2.5, 1.5), energy=300.0, shadow_soft_size=0.3)

    _case(f"Hair, {name}", build)


def _points(scene, tree, material):
    material(tree)
    on_a_matte_floor()
    places = np.random.default_rng(3).uniform((-2, -1, -0.8), (2, 1.5, 0.9), (80, 3))
    add_points(without_solids(scene), np.float32(places), np.full(80, 0.1, np.float32))


def _particles(scene, tree):
    _principled(Random_Roughness=0.5, Color=(0.5, 0.3, 0.15))(tree)
    on_a_matte_floor()
    scene.cycles_curves.shape = "THICK"
    bpy.data.objects.remove(bpy.data.objects["Cube"])  # no strand: another direction than Cycles'
    add_particle_hair(bpy.data.objects["Sphere"], 200, radius_scale=0.03)
    bpy.data.objects["Sphere"].show_instancer_for_render = False


_BLOND = (0.7, 0.45, 0.2)
_strands("Principled", _principled())
_strands("Principled, blond", _principled(Color=_BLOND))
_strands("Principled, blond ribbons", _principled(Color=_BLOND), shape="RIBBONS")
_strands("Principled, blond, many thin", _principled(Color=_BLOND), 2000, 8, (0.012, 0.003))
_strands("Principled, sharp", _principled(Color=_BLOND, Roughness=0.1, Radial_Roughness=0.15))
_strands("Principled, rough", _principled(Color=_BLOND, Roughness=0.8, Radial_Roughness=0.9))
_strands("Principled, coat, IOR and offset", _principled(Coat=0.7, IOR=1.3, Offset=0.2))
_strands("Principled, melanin", _principled("MELANIN", Melanin=0.4, Melanin_Redness=0.6))
_strands(
    "Principled, melanin, random, tinted",
    _principled("MELANIN", Melanin=0.5, Random_Color=0.8, Random_Roughness=0.6, Tint=_BLOND),
)
_strands(
    "Principled, absorption", _principled("ABSORPTION", Absorption_Coefficient=(0.3, 0.6, 1.2))
)
_strands("Principled, Random given", _principled("MELANIN", Random=0.9, Random_Color=0.8))
_strands("Principled, mixed with diffuse", _principled(mixed=True, Color=_BLOND))
_strands("Principled, before a lamp", _principled(Color=_BLOND), lamp=True)
_strands("Hair BSDF, reflection", _bells("Reflection"))
_strands("Hair BSDF, reflection, offset", _bells("Reflection", Offset=0.3, RoughnessV=0.4))
_strands("Hair BSDF, transmission", _bells("Transmission", RoughnessU=0.3))
_strands("Hair BSDF, transmission, offset", _bells("Transmission", Offset=-0.2, RoughnessV=0.3))
_strands("translucent strands", _translucent)
_strands("light from under strands", _under(1.0))
_strands("light from under strands, half", _under(0.5))
_case("Hair, translucent points", lambda scene, tree: _points(scene, tree, _translucent))
_case("Hair, light from under points", lambda scene, tree: _points(scene, tree, _under(1.0)))
_case("Hair, Principled on particles", _particles)

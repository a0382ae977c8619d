"""Ashikhmin and Shirley's lobe of the Glossy BSDF, under a world and under a lamp."""

import functools

from . import cases
from .cases import CASES, Case
from .closure_cases import BLUE, RED
from .lamp_cases import ABOVE, BALL, add_lamp
from .lit_cases import noise_of

lit = functools.partial(cases.lit, samples=(512, 512))


def _phong(roughness=0.4, color=BLUE, **inputs):
    """A shader; its inputs may be made by functions of the tree."""

    def make(tree):
        values = {"Color": color, "Roughness": roughness} | inputs
        made = {name: v(tree) if callable(v) else v for name, v in values.items()}
        how = {"distribution": "ASHIKHMIN_SHIRLEY"}
        return tree.made("ShaderNodeBsdfAnisotropic", 0, made, **how)

    return make


def _bump(tree):
    bump = {"Height": noise_of(tree), "Strength": 0.6, "Distance": 0.3}
    return tree.made("ShaderNodeBump", 0, bump)


def _radial(tree):
    return tree.made("ShaderNodeTangent", 0, {}, direction_type="RADIAL", axis="Z")


def _mixed(tree):
    matte = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": RED})
    return tree.made("ShaderNodeMixShader", 0, {0: 0.4, 1: matte, 2: _phong(0.3)(tree)})


for _roughness in (0.0, 0.1, 0.3, 0.6, 1.0):
    lit(f"Ashikhmin-Shirley, roughness {_roughness}", _phong(_roughness))
lit("Ashikhmin-Shirley, by noise", _phong(noise_of, noise_of))
lit("Ashikhmin-Shirley, bumped", _phong(Normal=_bump))
lit("Ashikhmin-Shirley, mixed with Diffuse", _mixed)
for _part in (0.7, -0.5):
    lit(f"Ashikhmin-Shirley, anisotropy {_part}", _phong(Anisotropy=_part, Tangent=_radial))
lit("Ashikhmin-Shirley, anisotropy .9, rough", _phong(0.8, Anisotropy=0.9, Rotation=0.2))


def _under_a_ball(name, make, **options):
    """A case under a lamp with a size, in the dark."""

    def build(scene, tree):
        add_lamp(scene, "POINT", ABOVE, **BALL | options)
        tree.surface(make(tree))

    CASES.append(Case(f"Point, Ashikhmin-Shirley {name}", build, by_lamps=True))


for _roughness in (0.15, 0.5):
    _under_a_ball(f"{_roughness}", _phong(_roughness))
_under_a_ball("brushed", _phong(0.4, Anisotropy=0.8))
_under_a_ball("not for glossy", _phong(0.4), visible_glossy=False)
_under_a_ball("no size", _phong(0.4), shadow_soft_size=0.0)

"""Normals that lead far from the face: smooth coarse meshes, and maps of one normal."""

import functools

from . import cases
from .cases import CASES, Case
from .lit_cases import principled

lit = functools.partial(cases.lit, samples=(512, 512))
RED = (0.8, 0.1, 0.1)


def _coarse(name, make):
    """The cube and the floor are smooth too: normals are turned far from their faces."""

    def build(scene, tree):
        for obj in scene.objects:
            if obj.type == "MESH":
                obj.data.shade_smooth()
        tree.surface(make(tree))

    CASES.append(Case(f"{name}, coarse and smooth", build, lit=True, samples=(512, 512)))


def _turned(tree, normal):
    """A metal all of whose normals are one, wherever its surface faces."""
    color = tuple(0.5 + 0.5 * x for x in normal)
    turned = tree.made("ShaderNodeNormalMap", 0, {"Color": color}, space="WORLD")
    return tree.made("ShaderNodeBsdfAnisotropic", 0, {"Roughness": 0.4, "Normal": turned})


for _axis, _normal in {"X": (1, 0, 0), "Y": (0, 1, 0), "-Y": (0, -1, 0), "-Z": (0, 0, -1)}.items():
    lit(f"Glossy, all normals are {_axis}", lambda t, n=_normal: _turned(t, n))
_coarse("Diffuse", lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Color": RED}))
_coarse("Glossy", lambda t: t.made("ShaderNodeBsdfAnisotropic", 0, {"Roughness": 0.4}))
_coarse("Translucent", lambda t: t.made("ShaderNodeBsdfTranslucent", 0, {"Color": RED}))
_coarse("Principled, coat", principled(Base_Color=RED, Coat_Weight=1.0, Coat_Roughness=0.3))
_coarse("Principled, sheen", principled(Base_Color=RED, Sheen_Weight=1.0))
for _model in ("MICROFIBER", "ASHIKHMIN"):
    _coarse(
        f"Sheen BSDF {_model}",
        lambda t, m=_model: t.made("ShaderNodeBsdfSheen", 0, distribution=m),
    )

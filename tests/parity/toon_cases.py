"""The Toon BSDF, under a world and under lamps."""

import functools

from . import cases
from .cases import CASES, Case
from .closure_cases import BLUE, RED
from .lamp_cases import ABOVE, BALL, add_lamp
from .lit_cases import noise_of

# Two renders of IWIS with other seeds share some of their error: less of it is wanted here.
lit = functools.partial(cases.lit, samples=(512, 512))
_KINDS = ("DIFFUSE", "GLOSSY")


def _toon(kind, size=0.5, smooth=0.0, color=BLUE, normal=None):
    """A shader; size, smooth and color may be made by functions of the tree."""

    def make(tree):
        values = {"Color": color, "Size": size, "Smooth": smooth}
        inputs = {name: v(tree) if callable(v) else v for name, v in values.items()}
        if normal is not None:
            inputs["Normal"] = normal(tree)
        return tree.made("ShaderNodeBsdfToon", 0, inputs, component=kind)

    return make


def _bump(tree):
    bump = {"Height": noise_of(tree), "Strength": 0.6, "Distance": 0.3}
    return tree.made("ShaderNodeBump", 0, bump)


def _mixed(tree):
    matte = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": RED})
    inputs = {0: 0.4, 1: matte, 2: _toon("GLOSSY", 0.2, 0.1)(tree)}
    return tree.made("ShaderNodeMixShader", 0, inputs)


for _kind in _KINDS:
    for _size, _smooth in ((0.5, 0.0), (0.2, 0.3), (0.05, 0.0), (0.0, 0.0), (1.0, 1.0)):
        lit(f"Toon, {_kind}, size {_size}, smooth {_smooth}", _toon(_kind, _size, _smooth))
    lit(f"Toon, {_kind}, by noise", _toon(_kind, noise_of, lambda t: t.axis("Z"), RED))
    lit(f"Toon, {_kind}, bumped", _toon(_kind, 0.5, 0.2, normal=_bump))
lit("Toon, mixed with Diffuse", _mixed)


def _under_a_ball(name, make, **options):
    """A case under a lamp with a size, in the dark."""

    def build(scene, tree):
        add_lamp(scene, "POINT", ABOVE, **BALL | options)
        tree.surface(make(tree))

    CASES.append(Case(f"Point, toon {name}", build, by_lamps=True))


for _kind in _KINDS:
    _under_a_ball(_kind, _toon(_kind, 0.3, 0.2))
    _under_a_ball(f"{_kind}, narrow", _toon(_kind, 0.05))
# Of the other kind each would be black.
_under_a_ball("GLOSSY, not for diffuse", _toon("GLOSSY", 0.3, 0.2), visible_diffuse=False)
_under_a_ball("DIFFUSE, not for glossy", _toon("DIFFUSE", 0.3, 0.2), visible_glossy=False)
_under_a_ball("DIFFUSE, no size", _toon("DIFFUSE", 0.4), shadow_soft_size=0.0)
_under_a_ball("GLOSSY, no size", _toon("GLOSSY", 0.4), shadow_soft_size=0.0)

"""Thin films: Principled, Metallic and Glass BSDF."""

import bpy

from .cases import lit_by
from .closure_cases import lit
from .lamp_cases import ABOVE, add_lamp
from .lit_cases import noise_of
from .space_cases import in_space

_DARK, _STEEL = (0.05, 0.05, 0.06), (0.7, 0.68, 0.65)
_GLASS = {"warns": "straight through", "differs": "light is not refracted"}
_GOLD = {"IOR": (0.14, 0.37, 1.44), "Extinction": (3.97, 2.5, 1.9)}


def _filmed(thickness=400.0, kind="Principled", options=None, **inputs):
    """make(tree) of a BSDF with a film. inputs: with _ for blanks; values, or functions of the tree
    that give their output"""
    given = {"Roughness": 0.25, "Thin Film Thickness": thickness}
    if kind == "Principled":
        given["Base Color"] = _DARK
    given |= {name.replace("_", " "): value for name, value in inputs.items()}

    def make(tree):
        values = {name: v(tree) if callable(v) else v for name, v in given.items()}
        return tree.made(f"ShaderNodeBsdf{kind}", 0, values, **(options or {}))

    return make


def _along(axis, low, high):
    return lambda tree: tree.axis(axis, low, high)


def _case(name, *film, blurred=False, **inputs):
    lit(f"Thin film: {name}", _filmed(*film, **inputs), blurred=blurred)


for _thickness in (10.0, 100.0, 300.0, 600.0, 1000.0, 1500.0):
    _case(f"{_thickness:.0f} nm", _thickness)
for _ior in (0.9, 1.1, 2.0, 3.5):
    _case(f"IOR {_ior}", Thin_Film_IOR=_ior)
_case("as thin as it fades", _along("Z", -1.0, 3.0), Thin_Film_IOR=2.5, IOR=1.1)
_case("thickness varies", _along("Z", 0.0, 900.0))
_case("thickness by noise", lambda tree: _scaled(noise_of(tree), 1200.0), Roughness=0.1)
_case("IOR varies", 500.0, Thin_Film_IOR=_along("X", 1.0, 2.2))
_case("on index 1", 300.0, IOR=1.0)
_case("on index .8", 300.0, IOR=0.8)
_case("specular level and tint", Specular_IOR_Level=0.9, Specular_Tint=(1.0, 0.5, 0.2))
_case("on bright paint", 250.0, Base_Color=(0.8, 0.5, 0.3), Thin_Film_IOR=2.0)
_case("on rough paint", 250.0, Base_Color=(0.8, 0.5, 0.3), Diffuse_Roughness=0.8)
_case("roughness 0", 350.0, Roughness=0.0)
_case("roughness 1", 350.0, Roughness=1.0, Thin_Film_IOR=2.0)
_case("roughness 1, GGX", 350.0, options={"distribution": "GGX"}, Roughness=1.0, Thin_Film_IOR=2.0)
_case("metal", Base_Color=_STEEL, Metallic=1.0)
_case("metal, edge tint", 200.0, Base_Color=_STEEL, Metallic=1.0, Specular_Tint=(0.9, 0.5, 0.3))
_case("metal, roughness 1", 200.0, Base_Color=_STEEL, Metallic=1.0, Roughness=1.0)
_case("metal, mirror", 300.0, Base_Color=_STEEL, Metallic=1.0, Roughness=0.0, Thin_Film_IOR=2.0)
_case("metallic .5", 300.0, Base_Color=(0.7, 0.4, 0.2), Metallic=0.5)
_case("metallic varies", 300.0, Base_Color=(0.7, 0.4, 0.2), Metallic=_along("X", -0.2, 1.2))
_case("metal, anisotropic", 300.0, Base_Color=_STEEL, Metallic=1.0, Anisotropic=0.8, Roughness=0.4)
_case("under a coat", 300.0, Coat_Weight=0.8, Coat_Tint=(0.9, 0.6, 0.4), Base_Color=_STEEL)
_case("under sheen", 300.0, Sheen_Weight=0.6)
_case("on subsurface", 300.0, blurred=True, Subsurface_Weight=0.5, Base_Color=(0.8, 0.5, 0.4))
_case("with alpha", 300.0, blurred=True, Alpha=0.6)


def _scaled(value, factor):
    tree = value.id_data
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = "MULTIPLY"
    tree.links.new(value, node.inputs[0])
    node.inputs[1].default_value = factor
    return node.outputs[0]


def _mixed(tree):
    first = _filmed(300.0)(tree)
    second = _filmed(700.0, Metallic=0.7, Base_Color=_STEEL, Roughness=0.5)(tree)
    return tree.made("ShaderNodeMixShader", 0, {0: tree.axis("X"), 1: first, 2: second})


def _bumpy(tree):
    normal = tree.made("ShaderNodeBump", 0, {"Height": noise_of(tree), "Strength": 0.4})
    return _filmed(350.0, Normal=lambda _: normal)(tree)


lit("Thin film: two, mixed", _mixed)
lit("Thin film: bumps", _bumpy)
_CLEAR = {"Transmission_Weight": 1.0, "Specular_Tint": (1.0, 0.5, 0.3)}
lit("Thin film: transmission", _filmed(400.0, **_CLEAR), **_GLASS)


def _by_lamps(name, make, *lamp, **options):
    def build(scene, tree):
        add_lamp(scene, *lamp, **options)
        tree.surface(make(tree))

    lit_by(f"Thin film: {name}", build)


_METAL = {"Base_Color": _STEEL, "Metallic": 1.0}
_by_lamps("sun", _filmed(400.0, Base_Color=_STEEL), "SUN", ABOVE, energy=3.0, angle=0.3)
_by_lamps("area light", _filmed(250.0, **_METAL), "AREA", ABOVE, energy=200.0, size=2.0)

if bpy.app.version >= (5, 0):
    for _roughness in (0.1, 0.5):
        _own = {"IOR": 1.45, "Roughness": _roughness, "Color": (0.9, 0.8, 0.7)}
        lit(f"Thin film: Glass, roughness {_roughness}", _filmed(400.0, "Glass", **_own), **_GLASS)
    _F82 = {"Base_Color": (0.9, 0.6, 0.3), "Edge_Tint": (0.8, 0.9, 1.0)}
    _PHYSICAL = {"fresnel_type": "PHYSICAL_CONDUCTOR"}
    for _thickness in (50.0, 300.0, 900.0):
        lit(f"Thin film: Metallic, {_thickness:.0f} nm", _filmed(_thickness, "Metallic", **_F82))
        _made = _filmed(_thickness, "Metallic", _PHYSICAL, **_GOLD)
        lit(f"Thin film: Metallic, gold by its indices, {_thickness:.0f} nm", _made)
    _rough = _GOLD | {"Roughness": 0.9, "Anisotropy": 0.6}
    _made = _filmed(300.0, "Metallic", _PHYSICAL, **_rough)
    lit("Thin film: Metallic, gold by its indices, rough, anisotropic", _made)
    for _space in ("ACEScg", "Linear Rec.2020"):
        for _name, _inputs in (("dielectric", {}), ("metal", _METAL)):
            lit(f"Thin film: {_name} in {_space}", in_space(_space, _filmed(350.0, **_inputs)))

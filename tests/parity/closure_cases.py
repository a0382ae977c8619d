"""Materials of several closures, and such that let light through."""

import functools

import bpy

from . import cases
from .cases import CASES, Case
from .lit_cases import image_of, noise_of, principled
from .scene import Tree

# Two renders of IWIS with other seeds share some of their error: less of it is wanted here.
lit = functools.partial(cases.lit, samples=(512, 512))
RED, BLUE = (0.8, 0.1, 0.1), (0.1, 0.2, 0.8)


def _diffuse(tree, color=RED):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": color})


def _glossy(tree, roughness=0.4, color=(0.9, 0.8, 0.7)):
    return tree.made("ShaderNodeBsdfGlossy", 0, {"Color": color, "Roughness": roughness})


def _clear(tree):
    return tree.made("ShaderNodeBsdfTransparent", 0)


def _mix(tree, factor, first, second):
    return tree.made("ShaderNodeMixShader", 0, {0: factor, 1: first, 2: second})


def _step(tree, value):
    """1 where a value is over a half, else 0."""
    return tree.made("ShaderNodeMath", 0, {0: value, 1: 0.5}, operation="GREATER_THAN")


def _stripes(tree):
    return tree.made("ShaderNodeTexChecker", "Fac", {"Vector": tree.coordinates(), "Scale": 2.3})


def _three(tree):
    """Paint, a mirror and a second paint with another normal."""
    bent = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": BLUE, "Normal": (0.6, 0.0, 0.8)})
    return _mix(tree, 0.3, _mix(tree, 0.5, _diffuse(tree), _glossy(tree)), bent)


def _shadowless(tree):
    path = tree.made("ShaderNodeLightPath", "Is Shadow Ray")
    return _mix(tree, path, _diffuse(tree), _clear(tree))


def _one_sided(tree):
    back = tree.made("ShaderNodeNewGeometry", "Backfacing")
    return _mix(tree, back, _diffuse(tree), _clear(tree))


def _by_angle(tree):
    facing = tree.made("ShaderNodeLayerWeight", "Facing", {"Blend": 0.5})
    return _mix(tree, _step(tree, facing), _diffuse(tree), _clear(tree))


def _glowing_net(tree):
    light = tree.made("ShaderNodeEmission", 0, {"Color": (0.5, 0.9, 0.4)})
    return _mix(tree, _stripes(tree), light, _clear(tree))


lit("Mix, diffuse and glossy", lambda t: _mix(t, 0.4, _diffuse(t), _glossy(t)))
lit(
    "Mix, diffuse and glossy by noise", lambda t: _mix(t, noise_of(t), _diffuse(t), _glossy(t, 0.3))
)
lit("Mix, two glossy ones", lambda t: _mix(t, 0.5, _glossy(t, 0.2, RED), _glossy(t, 0.6, BLUE)))
lit("Mix, three closures", _three)
lit(
    "Add, diffuse and glossy",
    lambda t: t.made(
        "ShaderNodeAddShader", 0, {0: _diffuse(t), 1: _glossy(t, 0.3, (0.2, 0.2, 0.2))}
    ),
)
lit(
    "Mix, two Principled",
    lambda t: _mix(t, t.axis("Z"), principled(Base_Color=RED)(t), principled(Metallic=1.0)(t)),
)
lit("Principled, coat", principled(Base_Color=RED, Coat_Weight=1.0, Coat_Roughness=0.2))
lit(
    "Principled, coat over metal",
    principled(Metallic=1.0, Roughness=0.5, Coat_Weight=0.7, Coat_Roughness=0.3, Coat_IOR=1.8),
)
lit(
    "Principled, tinted coat",
    principled(Coat_Weight=1.0, Coat_Roughness=0.25, Coat_Tint=(0.9, 0.5, 0.3)),
)
lit(
    "Principled, coat varies",
    principled(Coat_Weight=lambda t: t.axis("X"), Coat_Roughness=0.3, Base_Color=image_of),
)
lit("Transparent by a checker", lambda t: _mix(t, _stripes(t), _diffuse(t), _clear(t)))
lit("Principled, alpha by a checker", principled(Alpha=_stripes, Base_Color=image_of))
lit("Principled, alpha by noise", principled(Alpha=lambda t: _step(t, noise_of(t))))
lit(
    "Transparent to shadow rays",
    _shadowless,
    differs="Cycles takes half of its light by rays of the BSDF, which are no shadow rays",
)
lit("Transparent from behind", _one_sided)
lit("Transparent by the angle", _by_angle)
lit("Transparent, a net that glows", _glowing_net)


def _tinted(tree):
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": (0.9, 0.5, 0.2)})


def _translucent(tree, color=RED, **inputs):
    return tree.made("ShaderNodeBsdfTranslucent", 0, {"Color": color, **inputs})


def _bent(tree):
    bump = {"Height": noise_of(tree), "Strength": 0.6, "Distance": 0.3}
    return tree.made("ShaderNodeBump", 0, bump)


def _tinted_glow(tree):
    light = tree.made("ShaderNodeEmission", 0, {"Color": (0.2, 0.3, 0.6)})
    return _mix(tree, 0.7, light, _tinted(tree))


lit("Translucent", _translucent)
lit("Translucent, mixed with diffuse", lambda t: _mix(t, 0.5, _diffuse(t, BLUE), _translucent(t)))
lit(
    "Translucent leaf, glossy and cut out",
    lambda t: _mix(
        t, _stripes(t), _mix(t, 0.3, _translucent(t, image_of(t)), _glossy(t, 0.3)), _clear(t)
    ),
)
lit("Translucent, bump", lambda t: _translucent(t, Normal=_bent(t)))
for _name, _kind in {"Glass": 0.1, "Glass, rough": 0.5}.items():
    lit(
        _name,
        lambda t, roughness=_kind: t.made(
            "ShaderNodeBsdfGlass", 0, {"Color": (0.9, 0.8, 0.7), "Roughness": roughness}
        ),
        warns="straight through",
        differs="light is not refracted",
    )
lit(
    "Principled, transmission",
    principled(Transmission_Weight=0.7, Metallic=0.2, Roughness=0.3, Base_Color=BLUE),
    warns="straight through",
    differs="light is not refracted",
)
lit("Transparent, tinted, that glows", _tinted_glow, blurred=True)


def _over_a_floor(material, *lamps):
    """Of the material are the sphere and the cube; the floor is white."""

    def build(scene, tree):
        tree.surface(material(tree))
        white = bpy.data.materials.new("White")
        if bpy.app.version < (5, 0):
            white.use_nodes = True
        Tree(white.node_tree).surface(_diffuse(Tree(white.node_tree), (0.8, 0.8, 0.8)))
        bpy.data.objects["Plane"].data.materials[0] = white
        for kind, energy in lamps:
            light = bpy.data.lights.new(kind, kind)
            light.energy = energy
            lamp = bpy.data.objects.new(kind, light)
            lamp.location, lamp.rotation_euler = (1.5, -1.0, 4.0), (0.3, 0.2, 0.0)
            scene.collection.objects.link(lamp)

    return build


def _stained(tree):
    """Panes of the colors of an image."""
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": image_of(tree)})


for _name, _material in {"tinted": _tinted, "stained": _stained}.items():
    build = _over_a_floor(_material)
    CASES.append(Case(f"Transparent, {_name}, shadow", build, lit=True, blurred=True))
    build = _over_a_floor(_material, ("SUN", 3.0), ("POINT", 200.0))
    CASES.append(Case(f"Transparent, {_name}, shadow of lamps", build, by_lamps=True, blurred=True))


def _whole_shadow(scene, tree):
    _over_a_floor(_tinted, ("SUN", 3.0), ("POINT", 200.0))(scene, tree)
    for material in bpy.data.materials:
        material.use_transparent_shadow = False


CASES.append(Case("Transparent Shadows off, lamps", _whole_shadow, by_lamps=True, blurred=True))


_SHEEN = {
    "Principled, sheen": {"Sheen_Weight": 1.0},
    "Principled, sheen, rough and tinted": {"Sheen_Roughness": 0.9, "Sheen_Tint": (0.9, 0.4, 0.2)},
    "Principled, sheen, smooth": {"Sheen_Roughness": 0.3, "Sheen_Weight": 0.7},
    "Principled, sheen under a coat": {"Coat_Weight": 1.0, "Coat_Roughness": 0.2},
    "Principled, sheen varies": {
        "Sheen_Weight": noise_of,
        "Sheen_Roughness": lambda t: t.axis("Z"),
    },
}
for _name, _values in _SHEEN.items():
    lit(_name, principled(**{"Sheen_Weight": 1.0, "Base_Color": RED} | _values))


def _sheen(roughness, distribution="MICROFIBER"):
    return lambda t: t.made(
        "ShaderNodeBsdfSheen",
        0,
        {"Color": BLUE, "Roughness": roughness(t) if callable(roughness) else roughness},
        distribution=distribution,
    )


for _kind in ("MICROFIBER", "ASHIKHMIN"):
    for _roughness in (0.3, 0.8):
        lit(f"Sheen, {_kind}, roughness {_roughness}", _sheen(_roughness, _kind))
lit("Sheen, by noise", _sheen(noise_of))

_BRUSHED = {
    "Principled, brushed metal": {"Anisotropic": 0.8, "Roughness": 0.3},
    "Principled, brushed and turned": {"Anisotropic": 0.5, "Anisotropic_Rotation": 0.15},
    "Principled, brushed as far as can be": {"Anisotropic": 1.0},
    "Principled, brushed and rough": {"Anisotropic": 0.9, "Roughness": 1.0},
}
for _name, _values in _BRUSHED.items():
    lit(_name, principled(**{"Metallic": 1.0, "Roughness": 0.4} | _values))
lit(
    "Principled, brushed paint",
    principled(Anisotropic=0.9, Roughness=0.3, Base_Color=RED, Diffuse_Roughness=0.5),
)
lit(
    "Principled, brushing varies",
    principled(Metallic=1.0, Anisotropic=noise_of, Anisotropic_Rotation=lambda t: t.axis("X")),
)


def _brushed(kind, distribution="GGX", **inputs):
    return lambda t: t.made(
        f"ShaderNodeBsdf{kind}",
        0,
        {"Roughness": 0.4, "Anisotropy": 0.7}
        | {name: made(t) if callable(made) else made for name, made in inputs.items()},
        distribution=distribution,
    )


def _tangent_of(**settings):
    return lambda t: t.made("ShaderNodeTangent", 0, **settings)


for _kind in ("GGX", "BECKMANN", "MULTI_GGX"):
    lit(f"Glossy, brushed, {_kind}", _brushed("Anisotropic", _kind))
    lit(f"Glossy, brushed across, {_kind}", _brushed("Anisotropic", _kind, Anisotropy=-0.5))
lit(
    "Glossy, brushed and rough",
    _brushed("Anisotropic", "MULTI_GGX", Anisotropy=0.8, Roughness=0.8),
)
lit("Metallic, brushed", _brushed("Metallic"))
for _axis in "XYZ":
    _tangent = _tangent_of(direction_type="RADIAL", axis=_axis)
    lit(f"Tangent, radial {_axis}", _brushed("Anisotropic", Tangent=_tangent))
lit("Tangent, UV map", _brushed("Anisotropic", Tangent=_tangent_of(direction_type="UV_MAP")))
lit("Glossy, brushed, bump", _brushed("Anisotropic", Normal=_bent))


def _held_out(make):
    """In a transparent film, alpha compared as well."""

    def build(scene, tree):
        scene.render.film_transparent = True
        tree.surface(make(tree))

    return build


def _hole(tree):
    return tree.made("ShaderNodeHoldout", 0)


HOLES = {
    "Holdout": _hole,
    "Holdout, mixed": lambda t: _mix(t, 0.3, _diffuse(t), _hole(t)),
    "Holdout by a checker": lambda t: _mix(t, _stripes(t), _diffuse(t), _hole(t)),
}
for _name, _make in HOLES.items():
    cases.CASES.append(cases.Case(_name, _held_out(_make), lit=True, blurred=True, with_alpha=True))

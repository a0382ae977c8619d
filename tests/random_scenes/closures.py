"""Random closures, each the output of one node."""

from __future__ import annotations

import bpy

from . import values
from .dice import Dice


def closure(dice: Dice, tree, may: set[str]):
    """One closure. may: what it may be of "clear", "thin", "strand", "hole" and "walked"."""
    kinds = [_diffuse, _diffuse, _principled, _principled, _glossy, _metallic, _sheen, _emission]
    kinds += [_toon, _layered_clear if "clear" in may else _layered]
    kinds += [_transparent] if "clear" in may else []
    kinds += [_translucent] if "thin" in may else []
    kinds += [_holdout] if "hole" in may else []
    kinds += [_subsurface, _layered_walked] if "walked" in may else []
    kinds += [_principled_hair, _hair] * 3 if "strand" in may else []
    kind = dice.of(*kinds)
    dice.tell(kind.__name__[1:])
    return kind(dice, tree)


def _normal(dice, tree):
    """Inputs of a turned normal, seldom."""
    if not dice.chance(0.2) or not dice.bumps:
        return {}
    if dice.chance(0.3):
        return {"Normal": _mapped(dice, tree)}
    if dice.chance(0.15):
        dice.tell("bevel")
        return {"Normal": tree.made("ShaderNodeBevel", 0, {"Radius": dice.between(0.02, 0.1)})}
    height = values.number(dice, tree, depth=2)
    bump = {"Height": height, "Strength": dice.between(0.1, 0.7), "Distance": 0.1}
    return {"Normal": tree.made("ShaderNodeBump", 0, bump, invert=dice.chance(0.3))}


def _mapped(dice, tree):
    """A normal map of one slant: a strong one is bent back by each engine in its way."""
    dice.tell("normal map")
    slant = (dice.between(0.4, 0.6), dice.between(0.4, 0.6), 1.0)
    space = dice.of("TANGENT", "TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT")
    # In the other spaces it leads away from most of the surface.
    strength = dice.edge(0.0, 1.0 if space == "TANGENT" else 0.2)
    inputs = {"Color": slant, "Strength": strength}
    return tree.made("ShaderNodeNormalMap", 0, inputs, space=space)


def _tangent(dice, tree):
    """Inputs of a tangent, seldom."""
    if not dice.chance(0.3):
        return {}
    # Round another axis a flat floor has none, and Cycles no number.
    how = dice.of({"direction_type": "UV_MAP"}, {"direction_type": "RADIAL", "axis": "Z"})
    return {"Tangent": tree.made("ShaderNodeTangent", 0, **how)}


def _diffuse(dice, tree):
    rough = dice.edge(0.0, 1.0) if dice.chance(0.4) else 0.0
    inputs = {"Color": values.color(dice, tree), "Roughness": rough}
    return tree.made("ShaderNodeBsdfDiffuse", 0, inputs | _normal(dice, tree))


def _principled(dice, tree):
    inputs = {
        "Base Color": values.color(dice, tree),
        "Metallic": values.number(dice, tree) if dice.chance(0.5) else 0.0,
        "Roughness": values.number(dice, tree, 0.2, 1.0),
        "IOR": dice.between(1.05, 2.5),
    }
    if dice.chance(0.3):
        inputs |= {"Coat Weight": dice.edge(0.0, 1.0), "Coat Roughness": dice.between(0.1, 0.6)}
        inputs["Coat Tint"] = dice.color(0.5, 1.0)
    if dice.chance(0.2):
        inputs |= {"Sheen Weight": dice.edge(0.0, 1.0), "Sheen Roughness": dice.between(0.1, 1.0)}
        inputs["Sheen Tint"] = dice.color(0.3, 1.0)
    if dice.chance(0.2):
        inputs |= {"Anisotropic": dice.edge(0.0, 0.9), "Anisotropic Rotation": dice.between(0, 1)}
        inputs |= _tangent(dice, tree)
    if dice.chance(0.3):
        inputs |= {"Specular IOR Level": dice.edge(0.0, 1.0), "Specular Tint": dice.color()}
    if dice.chance(0.2):
        inputs["Diffuse Roughness"] = dice.edge(0.0, 1.0)
    if dice.chance(0.2):
        inputs["Thin Film Thickness"] = values.number(dice, tree, 0.0, dice.between(50.0, 1500.0))
        inputs["Thin Film IOR"] = dice.between(0.9, 2.5)
    # Under a coat or sheen it depends on the direction, which lights others otherwise (warned).
    if dice.chance(0.15) and not {"Coat Weight", "Sheen Weight"} & inputs.keys():
        dice.tell("shines")
        inputs |= {"Emission Color": dice.color(), "Emission Strength": dice.between(0.0, 0.5)}
    distribution = dice.of("GGX", "MULTI_GGX")
    inputs |= _normal(dice, tree)
    return tree.made("ShaderNodeBsdfPrincipled", 0, inputs, distribution=distribution)


def _layered(dice, tree, more=None):
    """A Principled BSDF of all its layers at once."""
    inputs = {"Base Color": values.color(dice, tree)}
    inputs |= {"Roughness": dice.between(0.3, 1.0), "Diffuse Roughness": dice.edge(0.0, 1.0)}
    inputs |= {"Metallic": dice.of(0.0, dice.between(0.0, 1.0)), "Specular Tint": dice.color()}
    inputs |= {"Coat Weight": values.number(dice, tree), "Coat Roughness": dice.between(0.1, 0.8)}
    inputs |= {"Coat Tint": dice.color(0.4, 1.0), "Coat IOR": dice.between(1.1, 2.0)}
    inputs |= {"Sheen Weight": values.number(dice, tree), "Sheen Tint": dice.color(0.3, 1.0)}
    inputs |= {"Sheen Roughness": dice.between(0.1, 1.0), "Anisotropic": dice.edge(0.0, 0.8)}
    inputs |= _normal(dice, tree) | _tangent(dice, tree) | (more or {})
    if dice.bumps and dice.chance(0.3):
        inputs["Coat Normal"] = _mapped(dice, tree)
    return tree.made("ShaderNodeBsdfPrincipled", 0, inputs)


def _layered_clear(dice, tree):
    more = {"Base Color": _shut_in(dice, tree)} if dice.chance(0.3) else {}
    return _layered(dice, tree, more | {"Alpha": values.number(dice, tree, 0.1, 1.0)})


def _layered_walked(dice, tree):
    """Grey under the surface, as _subsurface."""
    more = {"Subsurface Weight": dice.edge(0.0, 1.0), "Base Color": (dice.between(0.3, 0.8),) * 3}
    more |= {"Subsurface Radius": (1.0, 1.0, 1.0), "Subsurface Scale": dice.between(0.02, 0.1)}
    return _layered(dice, tree, more)


def _shut_in(dice, tree):
    """A colour by Ambient Occlusion; not of points and strands, whose insides Cycles' rays leave
    without meeting them."""
    dice.tell("occlusion")
    inputs = {"Color": dice.color(), "Distance": dice.between(0.2, 1.0)}
    how = {"inside": dice.chance(0.2), "only_local": dice.chance(0.3), "samples": dice.whole(1, 16)}
    return tree.made("ShaderNodeAmbientOcclusion", dice.of("Color", "AO"), inputs, **how)


def _glossy(dice, tree):
    inputs = {
        "Color": values.color(dice, tree),
        "Roughness": values.number(dice, tree, 0.2, 1.0),
        "Anisotropy": dice.edge(-0.6, 0.6) if dice.chance(0.3) else 0.0,
    }
    distribution = dice.of("GGX", "MULTI_GGX", "BECKMANN", "ASHIKHMIN_SHIRLEY")
    inputs |= _normal(dice, tree) | _tangent(dice, tree)
    return tree.made("ShaderNodeBsdfAnisotropic", 0, inputs, distribution=distribution)


def _metallic(dice, tree):
    inputs = {"Roughness": values.number(dice, tree, 0.2, 1.0)}
    if dice.chance(0.6):
        kind = "F82"
        inputs |= {"Base Color": values.color(dice, tree), "Edge Tint": dice.color()}
    else:
        kind = "PHYSICAL_CONDUCTOR"
        inputs |= {"IOR": dice.vector(0.2, 3.0), "Extinction": dice.vector(2.0, 5.0)}
    kinds = {"distribution": dice.of("GGX", "MULTI_GGX", "BECKMANN"), "fresnel_type": kind}
    return tree.made("ShaderNodeBsdfMetallic", 0, inputs, **kinds)


def _sheen(dice, tree):
    inputs = {"Color": values.color(dice, tree), "Roughness": dice.between(0.1, 1.0)}
    kind = dice.of("MICROFIBER", "ASHIKHMIN")
    return tree.made("ShaderNodeBsdfSheen", 0, inputs, distribution=kind)


def _toon(dice, tree):
    inputs = {"Color": values.color(dice, tree), "Size": dice.edge(0.0, 1.0)}
    inputs["Smooth"] = dice.edge(0.0, 0.5)
    kind = dice.of("DIFFUSE", "GLOSSY")
    return tree.made("ShaderNodeBsdfToon", 0, inputs | _normal(dice, tree), component=kind)


def _emission(dice, tree):
    dice.tell("shines")
    inputs = {"Color": values.color(dice, tree, depth=1), "Strength": dice.spread(0.05, 2.0)}
    return tree.made("ShaderNodeEmission", 0, inputs)


def _transparent(dice, tree):
    color = (1.0, 1.0, 1.0) if dice.chance(0.5) else values.color(dice, tree, 1)
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})


def _translucent(dice, tree):
    inputs = {"Color": values.color(dice, tree)}
    return tree.made("ShaderNodeBsdfTranslucent", 0, inputs | _normal(dice, tree))


def _holdout(dice, tree):
    return tree.made("ShaderNodeHoldout", 0)


def _subsurface(dice, tree):
    """Grey, and short against the objects: the noise of walks is no difference."""
    methods = ["RANDOM_WALK", "RANDOM_WALK_SKIN"]
    methods += ["RANDOM_WALK_LEGACY"] if bpy.app.version >= (5, 2) else []
    inputs = {"Color": (dice.between(0.3, 0.8),) * 3, "Scale": dice.between(0.02, 0.2)}
    inputs |= {"Radius": (1.0, 1.0, 1.0), "Anisotropy": dice.edge(0.0, 0.7)}
    return tree.made("ShaderNodeSubsurfaceScattering", 0, inputs, falloff=dice.of(*methods))


def _principled_hair(dice, tree):
    kind = dice.of("COLOR", "MELANIN", "ABSORPTION")
    pigment = {
        "COLOR": {"Color": dice.color()},
        "MELANIN": {"Melanin": dice.edge(0.0, 1.0), "Melanin Redness": dice.edge(0.0, 1.0)},
        "ABSORPTION": {"Absorption Coefficient": dice.vector(0.1, 2.0)},
    }
    inputs = {
        "Roughness": dice.between(0.1, 0.9),
        "Radial Roughness": dice.between(0.1, 0.9),
        "Coat": dice.edge(0.0, 1.0),
        "IOR": dice.between(1.2, 1.8),
        "Random Roughness": dice.edge(0.0, 0.5),
    }
    named = {"model": "CHIANG", "parametrization": kind}
    return tree.made("ShaderNodeBsdfHairPrincipled", 0, inputs | pigment[kind], **named)


def _hair(dice, tree):
    inputs = {"Color": dice.color(), "Offset": dice.between(-0.4, 0.4)}
    inputs |= {"RoughnessU": dice.between(0.1, 1.0), "RoughnessV": dice.between(0.1, 1.0)}
    component = dice.of("Reflection", "Transmission")
    return tree.made("ShaderNodeBsdfHair", 0, inputs, component=component)

"""Random materials: closures, mixtures and sums of them."""

from __future__ import annotations

import bpy
from parity.scene import Tree

from . import values
from .dice import Dice


def material(dice: Dice, opaque=False):
    """A new material. opaque: nothing passes through it"""
    made = bpy.data.materials.new("M")
    if made.node_tree is None:
        made.use_nodes = True
    tree = Tree(made.node_tree)
    tree.surface(shader(dice, tree, dice.whole(0, 2), opaque))
    return made


def shader(dice: Dice, tree, depth: int, opaque=False):
    """The output of a tree of shaders."""
    if depth <= 0:
        return _closure(dice, tree, opaque)
    parts = [shader(dice, tree, depth - 1, opaque) for _ in range(2)]
    node = tree.node("ShaderNodeAddShader" if dice.chance(0.25) else "ShaderNodeMixShader")
    dice.tell(node.bl_idname[10:])
    if len(node.inputs) == 3:
        tree.link(values.number(dice, tree), node.inputs[0])
    for part, socket in zip(parts, node.inputs[-2:], strict=True):
        tree.tree.links.new(part, socket)
    return node.outputs[0]


def _closure(dice, tree, opaque):
    kinds = [_diffuse, _diffuse, _principled, _principled, _glossy, _metallic, _sheen, _emission]
    kinds += [_toon] if opaque else [_toon, _transparent, _translucent]
    kind = dice.of(*kinds)
    dice.tell(kind.__name__[1:])
    return kind(dice, tree)


def _normal(dice, tree):
    """Inputs of a turned normal, seldom."""
    if not dice.chance(0.2) or not dice.bumps:
        return {}
    height = values.number(dice, tree, depth=2)
    bump = {"Height": height, "Strength": dice.between(0.1, 0.7), "Distance": 0.1}
    return {"Normal": tree.made("ShaderNodeBump", 0, bump, invert=dice.chance(0.3))}


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
    if dice.chance(0.3):
        inputs |= {"Specular IOR Level": dice.edge(0.0, 1.0), "Specular Tint": dice.color()}
    # Under a coat or sheen it depends on the direction, which lights others otherwise (warned).
    if dice.chance(0.15) and not {"Coat Weight", "Sheen Weight"} & inputs.keys():
        inputs |= {"Emission Color": dice.color(), "Emission Strength": dice.between(0.0, 0.5)}
    distribution = dice.of("GGX", "MULTI_GGX")
    inputs |= _normal(dice, tree)
    return tree.made("ShaderNodeBsdfPrincipled", 0, inputs, distribution=distribution)


def _glossy(dice, tree):
    inputs = {
        "Color": values.color(dice, tree),
        "Roughness": values.number(dice, tree, 0.2, 1.0),
        "Anisotropy": dice.edge(-0.6, 0.6) if dice.chance(0.3) else 0.0,
    }
    distribution = dice.of("GGX", "MULTI_GGX", "BECKMANN")
    inputs |= _normal(dice, tree)
    return tree.made("ShaderNodeBsdfAnisotropic", 0, inputs, distribution=distribution)


def _metallic(dice, tree):
    inputs = {"Base Color": values.color(dice, tree), "Edge Tint": dice.color()}
    inputs["Roughness"] = values.number(dice, tree, 0.2, 1.0)
    kinds = {"distribution": dice.of("GGX", "MULTI_GGX", "BECKMANN"), "fresnel_type": "F82"}
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
    inputs = {"Color": values.color(dice, tree, depth=1), "Strength": dice.spread(0.05, 2.0)}
    return tree.made("ShaderNodeEmission", 0, inputs)


def _transparent(dice, tree):
    color = (1.0, 1.0, 1.0) if dice.chance(0.5) else values.color(dice, tree, 1)
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})


def _translucent(dice, tree):
    inputs = {"Color": values.color(dice, tree)}
    return tree.made("ShaderNodeBsdfTranslucent", 0, inputs | _normal(dice, tree))

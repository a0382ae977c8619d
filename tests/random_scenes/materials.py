"""Random materials: mixtures and sums of closures, and displacement."""

from __future__ import annotations

import bpy
from parity.scene import Tree

from . import values
from .closures import closure
from .dice import Dice

CLEAR, OPAQUE, STRAND, POINT = {"clear", "thin", "hole"}, {"walked"}, {"strand"}, set()


def material(dice: Dice, may=frozenset(CLEAR)):
    """A new material. may: which closures that not all surfaces have it may have"""
    made = bpy.data.materials.new("M")
    if made.node_tree is None:
        made.use_nodes = True
    tree, before = Tree(made.node_tree), len(dice.told)
    if dice.glows:
        tree.glow(values.color(dice, tree, 3))
        return made
    tree.surface(shader(dice, tree, dice.whole(0, 2), may))
    if dice.bumps and may & (CLEAR | OPAQUE) and dice.chance(0.2):
        _displace(dice, tree, made, "shines" in dice.told[before:])
    return made


def shader(dice: Dice, tree, depth: int, may):
    """The output of a tree of shaders.

    Holes, and what is clear, are never added to others: that is nothing real. What passes would be
    all the light and more, of which Cycles' rays bring one in many, brighter by as much.
    """
    if depth <= 0:
        return closure(dice, tree, may)
    node = tree.node("ShaderNodeAddShader" if dice.chance(0.25) else "ShaderNodeMixShader")
    inner = may - {"hole", "clear"} if node.bl_idname == "ShaderNodeAddShader" else may
    parts = [shader(dice, tree, depth - 1, inner) for _ in range(2)]
    dice.tell(node.bl_idname[10:])
    if len(node.inputs) == 3:
        tree.link(values.number(dice, tree), node.inputs[0])
    for part, socket in zip(parts, node.inputs[-2:], strict=True):
        tree.tree.links.new(part, socket)
    return node.outputs[0]


def _displace(dice, tree, made, shines):
    """Hills as wide as the objects, by each method; the vertices are those that there are.

    shines: where also a bump is left, much of the light on others is missing in Cycles 5.2
    """
    methods = ("DISPLACEMENT",) if shines else ("BUMP", "DISPLACEMENT", "DISPLACEMENT", "BOTH")
    made.displacement_method = dice.of(*methods)
    dice.tell(f"moved {made.displacement_method.lower()}")
    place = tree.coordinates(dice.of("Object", "Generated"))
    noise = {"Vector": place, "Scale": dice.between(0.5, 1.5), "Detail": 0.0}
    inputs = {"Midlevel": dice.between(0.0, 0.6), "Scale": dice.between(0.1, 0.4)}
    if dice.chance(0.6):
        inputs["Height"] = tree.made("ShaderNodeTexNoise", 0, noise)
        value = tree.made(
            "ShaderNodeDisplacement", 0, inputs, space=dice.of("OBJECT", "OBJECT", "WORLD")
        )
    else:
        inputs["Vector"] = tree.made("ShaderNodeTexNoise", "Color", noise)
        # Of both, in tangent space, stretched faces differ (docs/parity.md).
        tangent = ("TANGENT",) if made.displacement_method != "BOTH" else ()
        space = dice.of("OBJECT", "WORLD", *tangent)
        dice.tell(f"along {space.lower()}")
        value = tree.made("ShaderNodeVectorDisplacement", 0, inputs, space=space)
    tree.link(value, tree.output.inputs["Displacement"])

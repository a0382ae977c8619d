"""Random worlds."""

from __future__ import annotations

import bpy
from parity.scene import Tree

from . import values
from .dice import Dice


def world(dice: Dice, scene) -> None:
    """Give a scene a world, or a black one."""
    made = scene.world = bpy.data.worlds.new("W")
    if made.node_tree is None:
        made.use_nodes = True
    tree = Tree(made.node_tree, "ShaderNodeOutputWorld")
    kind = dice.of(_black, _even, _picture, _picture, _sun, _sun, _tree, _two, _seen, _varied)
    if dice.chance(0.05):
        kind = _sky
    dice.tell(f"world {kind.__name__[1:]}")
    tree.surface(kind(dice, tree))
    made.cycles_visibility.camera = not dice.chance(0.1)


def _background(tree, color, strength=1.0):
    return tree.made("ShaderNodeBackground", 0, {"Color": color, "Strength": strength})


def _black(dice, tree):
    return _background(tree, (0.0, 0.0, 0.0))


def _even(dice, tree):
    return _background(tree, dice.color(), dice.spread(0.2, 2.0))


def _environment(dice, tree, pixels, vector=None):
    height, width, _ = pixels.shape
    image = bpy.data.images.new("HDRI", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    projection = "MIRROR_BALL" if dice.chance(0.15) else "EQUIRECTANGULAR"
    how = {"projection": projection, "interpolation": dice.of("Linear", "Linear", "Closest")}
    inputs = {"Vector": _turned(dice, tree)} if dice.chance(0.5) else {}
    return _changed(
        dice, tree, tree.made("ShaderNodeTexEnvironment", 0, inputs, image=image, **how)
    )


def _turned(dice, tree):
    """A direction that Mapping turns or noise bends."""
    vector = tree.coordinates("Generated")
    node = tree.made("ShaderNodeMapping", 0, {"Vector": vector})
    node.node.inputs["Rotation"].default_value = dice.vector(-3.0, 3.0)
    if dice.chance(0.3):
        node.node.inputs["Scale"].default_value = dice.vector(0.5, 1.5)
    if dice.chance(0.7):
        return node
    noise = tree.made("ShaderNodeTexNoise", "Color", {"Vector": vector, "Scale": 2.0})
    bent = {0: node, 1: noise}
    return tree.made("ShaderNodeVectorMath", 0, bent, operation="ADD")


def _changed(dice, tree, color):
    """A colour through nodes, seldom."""
    if dice.chance(0.7):
        return color
    if dice.chance(0.5):
        return tree.made("ShaderNodeGamma", 0, {"Color": color, "Gamma": dice.between(0.7, 1.4)})
    inputs = {"Color": color, "Saturation": dice.between(0.0, 1.6), "Hue": dice.between(0.3, 0.7)}
    return tree.made("ShaderNodeHueSaturation", 0, inputs)


def _picture(dice, tree):
    height = dice.of(8, 32, 64)
    return _background(tree, _environment(dice, tree, dice.pixels(height, 2 * height)))


def _sun(dice, tree):
    height = dice.of(16, 64, 128)
    pixels = 0.3 * dice.pixels(height, 2 * height)
    row, column = dice.whole(height // 2, height - 2), dice.whole(0, 2 * height - 1)
    pixels[row, column, :3] = dice.spread(3.0, 30.0) * (height / 16.0) ** 2
    return _background(tree, _environment(dice, tree, pixels))


def _tree(dice, tree):
    kind = dice.of("Noise", "Magic", "Checker", "Gradient")
    inputs = {"Vector": _turned(dice, tree)}
    if kind != "Gradient":
        inputs["Scale"] = dice.spread(1.0, 4.0)
    return _background(tree, tree.made(f"ShaderNodeTex{kind}", "Color", inputs))


def _two(dice, tree):
    node = tree.node(dice.of("ShaderNodeMixShader", "ShaderNodeAddShader"))
    parts = [_even(dice, tree), _picture(dice, tree)]
    if len(node.inputs) == 3:
        tree.link(values.number(dice, tree), node.inputs[0])
    for part, socket in zip(parts, node.inputs[-2:], strict=True):
        tree.tree.links.new(part, socket)
    return node.outputs[0]


def _seen(dice, tree):
    """One light, another picture for the camera."""
    node = tree.node("ShaderNodeMixShader")
    seen = dice.of("Is Camera Ray", "Is Camera Ray", "Is Shadow Ray")
    tree.link(tree.made("ShaderNodeLightPath", seen), node.inputs[0])
    for part, socket in zip((_picture, _even), node.inputs[1:], strict=True):
        tree.tree.links.new(part(dice, tree), socket)
    return node.outputs[0]


def _varied(dice, tree):
    """A picture whose strength is a gradient's or a noise's."""
    height = dice.of(16, 32)
    color = _environment(dice, tree, dice.pixels(height, 2 * height))
    kind = dice.of("ShaderNodeTexGradient", "ShaderNodeTexNoise")
    factor = tree.made(kind, dice.of(0, 1), {"Vector": _turned(dice, tree)})
    inputs = {"Value": factor, "To Min": dice.between(0.0, 0.5), "To Max": dice.between(0.5, 2.0)}
    return _background(tree, color, tree.made("ShaderNodeMapRange", 0, inputs))


def _sky(dice, tree):
    node = tree.node("ShaderNodeTexSky")
    node.sky_type = dice.of(*[k.identifier for k in node.bl_rna.properties["sky_type"].enum_items])
    dice.tell(node.sky_type.lower())
    node.sun_elevation, node.sun_rotation = dice.between(0.1, 1.3), dice.between(0.0, 6.0)
    node.sun_size, node.sun_disc = dice.between(0.01, 0.2), dice.chance(0.6)
    node.sun_intensity = 0.1
    strong = node.sky_type in ("PREETHAM", "HOSEK_WILKIE")
    return _background(tree, node.outputs[0], 0.5 if strong else 0.05)

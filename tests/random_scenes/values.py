"""Random trees of value nodes: numbers, colours, places."""

from __future__ import annotations

import bpy
from parity.value_cases import BLENDS

from . import attributes, facts, nodes, textures, vectors
from .dice import Dice

_SPACES = "Linear Rec.709", "Display P3", "Rec.1886", "Linear Rec.2020"


def number(dice: Dice, tree, low=0.0, high=1.0, depth=1):
    """A number, from low to high but of what glows: a constant, or the output of a node."""
    if dice.glows and dice.chance(0.4):
        return facts.number(dice, tree)
    if depth <= 0 or dice.chance(0.6):
        return dice.edge(low, high)
    inputs = {"Value": _factor(dice, tree, depth), "To Min": low, "To Max": high}
    return tree.made("ShaderNodeMapRange", 0, inputs, clamp=True)


def color(dice: Dice, tree, depth=2):
    """A colour."""
    if depth <= 0 or dice.chance(0.3):
        return dice.color()
    kinds = [_texture, _texture, _image, _image, _mixed, _changed, _ramp, _of_object, _grouped]
    return dice.of(*kinds, _vector, _vector)(dice, tree, depth)


def place(dice: Dice, tree):
    """A vector that textures are looked up by."""
    vector = tree.coordinates(dice.of("Object", "Generated", "UV", "Normal"))
    if dice.chance(0.15):
        vector = attributes.read_place(dice, tree)
    if dice.chance(0.5):
        return vector
    inputs = {"Vector": vector}
    node = tree.made("ShaderNodeMapping", 0, inputs, vector_type=dice.of("POINT", "TEXTURE"))
    for name, (low, high) in {"Location": (-1, 1), "Rotation": (-3, 3), "Scale": (0.5, 2)}.items():
        node.node.inputs[name].default_value = dice.vector(low, high)
    return node


def _factor(dice, tree, depth):
    if depth > 1 and dice.chance(0.2):
        return tree.made("ShaderNodeLayerWeight", dice.of("Fresnel", "Facing"), {"Blend": 0.3})
    if dice.chance(0.2):
        return nodes.calculated(dice, tree, number(dice, tree, depth=depth - 1))
    if dice.chance(0.2):
        return nodes.of_shape(dice, tree)
    if dice.chance(0.15):
        return attributes.read_number(dice, tree)
    return textures.factor(dice, tree, place(dice, tree))


def _texture(dice, tree, depth):
    return textures.colored(dice, tree, place(dice, tree))


def _vector(dice, tree, depth):
    """A vector as a colour; of lit surfaces from 0 to 1."""
    value, given = number(dice, tree, depth=depth - 1), color(dice, tree, depth - 1)
    made = vectors.vector(dice, tree, value, given)
    if dice.glows:
        return made
    settings = {"data_type": "RGBA", "clamp_result": True}
    inputs = {"Factor_Float": 0.0, "A_Color": made}
    return tree.made("ShaderNodeMix", "Result_Color", inputs, **settings)


def _image(dice, tree, depth):
    height, width = dice.whole(4, 24), dice.whole(4, 24)
    image = bpy.data.images.new("I", width, height, alpha=True, float_buffer=dice.chance(0.5))
    image.colorspace_settings.name = dice.of("sRGB", "sRGB", "Non-Color", *_SPACES)
    pixels = dice.pixels(height, width)
    if dice.chance(0.4):
        # Not 0: Blender 4.5 divides packed channels by it.
        pixels[..., 3] = 0.3 + 0.5 * pixels[::-1, :, 0].clip(0.0, 1.0)
        image.alpha_mode = dice.of("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE")
        dice.tell(f"image {image.alpha_mode.lower()} {image.colorspace_settings.name}")
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    settings = {
        "interpolation": dice.of("Linear", "Closest", "Cubic"),
        "extension": dice.of("REPEAT", "EXTEND", "CLIP", "MIRROR"),
        "projection": dice.of("FLAT", "FLAT", "BOX", "SPHERE", "TUBE"),
        "projection_blend": dice.edge(0.0, 1.0) if dice.chance(0.4) else 0.0,
    }
    return tree.made("ShaderNodeTexImage", 0, {0: place(dice, tree)}, image=image, **settings)


def _mixed(dice, tree, depth):
    settings = {"data_type": "RGBA", "blend_type": dice.of(*BLENDS), "clamp_result": True}
    settings["clamp_factor"] = dice.chance(0.8)
    if dice.glows:
        settings["clamp_result"] = dice.chance(0.5)
    inputs = {
        "Factor_Float": number(dice, tree, depth=depth - 1),
        "A_Color": color(dice, tree, depth - 1),
        "B_Color": color(dice, tree, depth - 1),
    }
    return tree.made("ShaderNodeMix", "Result_Color", inputs, **settings)


def _changed(dice, tree, depth):
    given = color(dice, tree, depth - 1)
    kind = dice.of("HueSaturation", "Gamma", "Invert", "BrightContrast", "RGBCurve")
    inputs = {"Color": given}
    if kind == "HueSaturation":
        inputs |= {"Hue": dice.between(0.0, 1.0), "Saturation": dice.between(0.0, 1.5)}
    elif kind == "Gamma":
        inputs["Gamma"] = dice.between(0.5, 2.5)
    elif kind == "BrightContrast":
        inputs |= {"Bright": dice.between(0.0, 0.3), "Contrast": dice.between(-0.2, 0.2)}
    made = tree.made(f"ShaderNode{kind}", "Color", inputs)
    if kind == "RGBCurve":
        vectors.bend(dice, made.node.mapping)
    return made


def _grouped(dice, tree, depth):
    """A colour by a group in a group."""
    dice.tell("groups")
    inner = _group("Inner")
    given, out = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    changed = inner.nodes.new("ShaderNodeHueSaturation")
    changed.inputs["Hue"].default_value = dice.between(0.2, 0.8)
    inner.links.new(given.outputs[0], changed.inputs["Color"])
    inner.links.new(changed.outputs[0], out.inputs[0])
    outer = _group("Outer")
    given, out = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput")
    made = outer.nodes.new("ShaderNodeGroup")
    made.node_tree = inner
    outer.links.new(given.outputs[0], made.inputs[0])
    outer.links.new(made.outputs[0], out.inputs[0])
    node = tree.node("ShaderNodeGroup")
    node.node_tree = outer
    tree.link(color(dice, tree, depth - 1), node.inputs[0])
    return node.outputs[0]


def _group(name):
    """A group of one colour in, one out."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Color", in_out=way, socket_type="NodeSocketColor")
    return group


def _ramp(dice, tree, depth):
    node = tree.node("ShaderNodeValToRGB")
    ramp = node.color_ramp
    ramp.interpolation = dice.of("LINEAR", "EASE", "CONSTANT", "B_SPLINE", "CARDINAL")
    if dice.chance(0.3):
        ramp.color_mode = dice.of("HSV", "HSL")
        ramp.hue_interpolation = dice.of("NEAR", "FAR", "CW", "CCW")
    for element in (*ramp.elements, ramp.elements.new(dice.between(0.2, 0.8))):
        element.color = (*dice.color(), 1.0)
    tree.link(_factor(dice, tree, depth), node.inputs[0])
    return node.outputs[0]


def _of_object(dice, tree, depth):
    kind = dice.of("color", "random", "attribute", "normal")
    if kind == "color":
        return tree.made("ShaderNodeObjectInfo", "Color")
    if kind == "random":
        return tree.made("ShaderNodeObjectInfo", "Random")
    if kind == "attribute":
        return tree.made("ShaderNodeVertexColor", 0, layer_name="Col")
    normal = tree.made("ShaderNodeNewGeometry", dice.of("Normal", "True Normal"))
    return tree.made("ShaderNodeVectorMath", 0, {0: normal}, operation="ABSOLUTE")

"""Random numbers that are calculated, or that a surface knows of itself."""

from __future__ import annotations

from parity.value_cases import choices

from .dice import Dice
from .vectors import bend

_MATH = choices("ShaderNodeMath", "operation")
_VECTOR = "LENGTH DOT_PRODUCT DISTANCE".split()
# Nothing of how a surface lies to the ray where it may be alpha (shadows are grey then, warned).
_SHAPE = "Pointiness", "Random Per Island"


def calculated(dice: Dice, tree, value):
    """Something from 0 to 1 that is made of a value, and of a constant."""
    kind = dice.of("math", "math", "vector", "curve", "range", "separate")
    dice.tell(kind)
    if kind == "math":
        inputs = {0: value, 1: dice.edge(0.0, 2.0), 2: dice.between(0.1, 1.0)}
        clamped = not dice.glows or dice.chance(0.5)
        return tree.made("ShaderNodeMath", 0, inputs, operation=dice.of(*_MATH), use_clamp=clamped)
    if kind == "vector":
        place = tree.coordinates(dice.of("Object", "Generated", "UV"))
        inputs = {0: place, 1: dice.vector(-1.0, 1.0)}
        far = tree.made("ShaderNodeVectorMath", "Value", inputs, operation=dice.of(*_VECTOR))
        return tree.made("ShaderNodeMath", 0, {0: far, 1: value}, operation="MULTIPLY")
    if kind == "curve":
        node = tree.node("ShaderNodeFloatCurve")
        bend(dice, node.mapping)
        tree.link(dice.of(1.0, dice.between(0.0, 1.0)), node.inputs[0])
        tree.link(value, node.inputs["Value"])
        return node.outputs[0]
    if kind == "range":
        how = dice.of("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")
        inputs = {
            "Value": value,
            "From Min": dice.between(0, 0.4),
            "From Max": dice.between(0.6, 1),
        }
        return tree.made("ShaderNodeMapRange", 0, inputs, interpolation_type=how)
    model = dice.of("RGB", "HSV", "HSL")
    inputs = {0: tree.made("ShaderNodeTexNoise", "Color", {"Scale": 2.0})}
    return tree.made("ShaderNodeSeparateColor", dice.whole(0, 2), inputs, mode=model)


def of_shape(dice: Dice, tree):
    """A number of the place on a mesh or in a picture."""
    kind = dice.of("geometry", "wireframe", "camera", "info", "path")
    dice.tell(kind)
    if kind == "geometry":
        return tree.made("ShaderNodeNewGeometry", dice.of(*_SHAPE))
    if kind == "wireframe":
        return tree.made("ShaderNodeWireframe", 0, {"Size": dice.between(0.02, 0.1)})
    if kind == "camera":
        far = tree.made("ShaderNodeCameraData", "View Z Depth")
        inputs = {"Value": far, "From Min": 3.0, "From Max": 9.0}
        return tree.made("ShaderNodeMapRange", 0, inputs)
    if kind == "info":
        index = tree.made("ShaderNodeObjectInfo", "Object Index")
        return tree.made("ShaderNodeMath", 0, {0: index, 1: 0.2}, operation="MULTIPLY")
    return tree.made("ShaderNodeLightPath", "Is Camera Ray")

"""Random vectors: made of places, normals and colours by all that vectors can be made with."""

from __future__ import annotations

from parity.value_cases import choices

from . import facts
from .dice import Dice

_OPERATIONS = [o for o in choices("ShaderNodeVectorMath", "operation") if o != "TANGENT"]
_NUMBERS = "LENGTH", "DISTANCE", "DOT_PRODUCT"


def vector(dice: Dice, tree, value, colored):
    """A vector of a value and a colour, which are linked or constant."""
    kind = dice.of(_math, _math, _math, _mixed, _curved, _turned, _transformed, _ranged, _joined)
    dice.tell(f"vector {kind.__name__[1:]}")
    return kind(dice, tree, value, colored)


def _base(dice, tree):
    if dice.glows and dice.chance(0.5):
        return facts.vector(dice, tree)
    # Not Geometry's Tangent: of points Cycles' is no number.
    kind = dice.of("Object", "Generated", "UV", "Normal", "Position", "True Normal")
    if kind in ("Position", "True Normal"):
        return tree.made("ShaderNodeNewGeometry", kind)
    return tree.coordinates(kind)


def _math(dice, tree, value, colored):
    operation = dice.of(*_OPERATIONS)
    dice.tell(operation.lower())
    inputs = {0: _base(dice, tree), 1: dice.of(colored, dice.vector(-1.5, 1.5))}
    inputs |= {2: dice.vector(0.1, 1.5), "Scale": value}
    output = 1 if operation in _NUMBERS else 0
    return tree.made("ShaderNodeVectorMath", output, inputs, operation=operation)


def _mixed(dice, tree, value, colored):
    mode = dice.of("UNIFORM", "NON_UNIFORM")
    inputs = {"A_Vector": _base(dice, tree), "B_Vector": colored}
    if mode == "UNIFORM":
        inputs["Factor_Float"] = value
    else:
        inputs["Factor_Vector"] = dice.of(_base(dice, tree), dice.vector(-0.5, 1.5))
    named = {"data_type": "VECTOR", "factor_mode": mode, "clamp_factor": dice.chance(0.5)}
    return tree.made("ShaderNodeMix", "Result_Vector", inputs, **named)


def _curved(dice, tree, value, colored):
    inputs = {"Factor": dice.of(value, 1.0), "Vector": _base(dice, tree)}
    factor = tree.node("ShaderNodeVectorCurve")
    tree.link(inputs["Factor"], factor.inputs[0])
    tree.link(inputs["Vector"], factor.inputs[1])
    bend(dice, factor.mapping, -1.0, 1.0)
    return factor.outputs[0]


def bend(dice: Dice, mapping, low=0.0, high=1.0) -> None:
    """Turn the curves of a node, some of them sharply, within two numbers."""
    for curve in mapping.curves:
        for _ in range(dice.whole(1, 3)):
            curve.points.new(dice.between(low, high), dice.between(low, high))
        for point in curve.points:
            point.handle_type = dice.of("AUTO", "AUTO_CLAMPED", "VECTOR")
        if dice.chance(0.3):
            curve.points[0].location.y = dice.between(low, high)
            curve.points[-1].location.y = dice.between(low, high)
    mapping.extend = dice.of("HORIZONTAL", "EXTRAPOLATED")
    mapping.update()


def _turned(dice, tree, value, colored):
    kind = dice.of("AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ")
    inputs = {"Vector": _base(dice, tree), "Center": dice.vector(-1.0, 1.0)}
    if kind == "EULER_XYZ":
        inputs["Rotation"] = dice.vector(-3.0, 3.0)
    else:
        inputs["Angle"] = value
    if kind == "AXIS_ANGLE":
        inputs["Axis"] = dice.of(_base(dice, tree), dice.vector(-1.0, 1.0))
    named = {"rotation_type": kind, "invert": dice.chance(0.5)}
    return tree.made("ShaderNodeVectorRotate", 0, inputs, **named)


def _transformed(dice, tree, value, colored):
    spaces = "WORLD", "OBJECT", "CAMERA"
    named = {"vector_type": dice.of("POINT", "VECTOR", "NORMAL")}
    named |= {"convert_from": dice.of(*spaces), "convert_to": dice.of(*spaces)}
    return tree.made("ShaderNodeVectorTransform", 0, {0: _base(dice, tree)}, **named)


def _ranged(dice, tree, value, colored):
    how = dice.of("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")
    inputs = {"Vector": _base(dice, tree), "From_Min_FLOAT3": dice.vector(-1.0, 0.3)}
    inputs |= {"From_Max_FLOAT3": dice.of(colored, dice.vector(0.5, 1.5))}
    inputs |= {"To_Min_FLOAT3": dice.vector(-1.0, 1.0), "To_Max_FLOAT3": dice.vector(-1.0, 1.0)}
    inputs["Steps_FLOAT3"] = dice.vector(0.0, 5.0)
    named = {"data_type": "FLOAT_VECTOR", "interpolation_type": how, "clamp": dice.chance(0.5)}
    return tree.made("ShaderNodeMapRange", "Vector", inputs, **named)


def _joined(dice, tree, value, colored):
    if dice.chance(0.5):
        return tree.made("ShaderNodeCombineXYZ", 0, {0: value, 1: dice.between(-1, 1), 2: value})
    inputs = {0: value, 1: dice.between(0.0, 1.0), 2: dice.between(0.0, 1.0)}
    return tree.made("ShaderNodeCombineColor", 0, inputs, mode=dice.of("RGB", "HSV", "HSL"))

"""Nodes that calculate with numbers and vectors: Math, Vector Math, Map Range, Clamp, Combine, ...

A function takes the context, the node's settings and its inputs (program.Op), and returns its
outputs by name. Each reproduces the Cycles node of its name.
"""

from __future__ import annotations

import numpy as np

from .values import clipped, column, divided, dot, length, mixed, normalized, parts, vector

_EPSILON = np.float32(1.1920929e-7)


def _power(a, b, before):
    """before: as Blender 4.5, where 0 to a negative power is infinite; since then it is 0"""
    good = (a >= 0.0) | (b == np.floor(b))
    if not before:
        good &= (a != 0.0) | (b >= 0.0)
    return np.where(good, np.power(np.where(good, a, 1.0), b), 0.0)


def _logarithm(a, b):
    good = (a > 0.0) & (b > 0.0)
    return np.where(
        good, divided(np.log(np.where(good, a, 1.0)), np.log(np.where(good, b, 1.0))), 0.0
    )


def _modulo(a, b):
    return np.where(b != 0.0, np.fmod(a, np.where(b != 0.0, b, 1.0)), 0.0)


def _floored_modulo(a, b):
    return np.where(b != 0.0, a - np.floor(divided(a, b)) * b, 0.0)


def _wrap(a, high, low):
    span = high - low
    return np.where(span != 0.0, a - span * np.floor(divided(a - low, span)), low)


def _ping_pong(a, b):
    x = divided(a - b, b * 2.0)
    return np.where(b != 0.0, np.abs((x - np.floor(x)) * b * 2.0 - b), 0.0)


def _smooth_min(a, b, c):
    h = np.where(c != 0.0, np.maximum(c - np.abs(a - b), 0.0) / np.where(c != 0.0, c, 1.0), 0.0)
    return np.minimum(a, b) - h * h * h * c * np.float32(1.0 / 6.0)


def _compare(a, b, c):
    return ((a == b) | (np.abs(a - b) <= np.maximum(c, _EPSILON))).astype(np.float32)


_MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: divided(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "LOGARITHM": lambda a, b, c: _logarithm(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0.0)),
    "INVERSE_SQRT": lambda a, b, c: np.where(
        a > 0.0, 1.0 / np.sqrt(np.where(a > 0.0, a, 1.0)), 0.0
    ),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b).astype(np.float32),
    "GREATER_THAN": lambda a, b, c: (a > b).astype(np.float32),
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": _compare,
    "SMOOTH_MIN": _smooth_min,
    "SMOOTH_MAX": lambda a, b, c: -_smooth_min(-a, -b, c),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: _modulo(a, b),
    "FLOORED_MODULO": lambda a, b, c: _floored_modulo(a, b),
    "WRAP": _wrap,
    "SNAP": lambda a, b, c: np.floor(divided(a, b)) * b,
    "PINGPONG": lambda a, b, c: _ping_pong(a, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1.0, 1.0)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1.0, 1.0)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: np.radians(a),
    "DEGREES": lambda a, b, c: np.degrees(a),
}
_NO_NUMBER = np.float32(0.0)


def math(context, settings, inputs):
    """settings: before, as Blender 4.5"""
    a, b, c = (inputs.get(k, _NO_NUMBER) for k in ("Value", "Value_001", "Value_002"))
    operation = settings["operation"]
    if operation == "POWER":
        value = _power(a, b, settings["before"])
    else:
        value = _MATH[operation](a, b, c)
    return {"Value": clipped(value) if settings["use_clamp"] else value}


def _project(a, b, c, s):
    size = dot(b, b)
    return np.where(size[..., None] != 0.0, divided(dot(a, b), size)[..., None] * b, 0.0)


def _reflect(a, b, c, s):
    n = normalized(b)
    return a - 2.0 * dot(a, n)[..., None] * n


def _refract(a, b, c, s):
    n = normalized(b)
    cosine = dot(n, a)
    k = 1.0 - s * s * (1.0 - cosine * cosine)
    bent = column(s) * a - (s * cosine + np.sqrt(np.maximum(k, 0.0)))[..., None] * n
    return np.where((k < 0.0)[..., None], 0.0, bent)


_VECTOR_MATH = {
    "ADD": lambda a, b, c, s: a + b,
    "SUBTRACT": lambda a, b, c, s: a - b,
    "MULTIPLY": lambda a, b, c, s: a * b,
    "DIVIDE": lambda a, b, c, s: divided(a, b),
    "MULTIPLY_ADD": lambda a, b, c, s: a * b + c,
    "CROSS_PRODUCT": lambda a, b, c, s: np.cross(a, b),
    "PROJECT": _project,
    "REFLECT": _reflect,
    "REFRACT": _refract,
    "FACEFORWARD": lambda a, b, c, s: np.where((dot(c, b) < 0.0)[..., None], a, -a),
    "SCALE": lambda a, b, c, s: a * column(s),
    "NORMALIZE": lambda a, b, c, s: normalized(a),
    "ABSOLUTE": lambda a, b, c, s: np.abs(a),
    "SIGN": lambda a, b, c, s: np.sign(a),
    "MINIMUM": lambda a, b, c, s: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c, s: np.maximum(a, b),
    "ROUND": lambda a, b, c, s: np.floor(a + np.float32(0.5)),
    "FLOOR": lambda a, b, c, s: np.floor(a),
    "CEIL": lambda a, b, c, s: np.ceil(a),
    "FRACTION": lambda a, b, c, s: a - np.floor(a),
    "WRAP": lambda a, b, c, s: _wrap(a, b, c),
    "SNAP": lambda a, b, c, s: np.floor(divided(a, b)) * b,
    "SINE": lambda a, b, c, s: np.sin(a),
    "COSINE": lambda a, b, c, s: np.cos(a),
    "TANGENT": lambda a, b, c, s: np.tan(a),
}
_NUMBER_OF_VECTORS = {
    "DOT_PRODUCT": dot,
    "DISTANCE": lambda a, b: length(a - b),
    "LENGTH": lambda a, b: length(a),
}
_NO_VECTOR = np.zeros(3, np.float32)


def _modulo_of_vectors(a, b, before):
    """before: as Blender 4.5; since then by a rounded quotient, so 1 modulo .1 is 0, not .1"""
    return _modulo(a, b) if before else np.where(b != 0.0, a - np.trunc(divided(a, b)) * b, 0.0)


_OF_VERSIONS = {"POWER": _power, "MODULO": _modulo_of_vectors}


def vector_math(context, settings, inputs):
    """settings: before, as Blender 4.5"""
    a, b, c = (inputs.get(k, _NO_VECTOR) for k in ("Vector", "Vector_001", "Vector_002"))
    operation = settings["operation"]
    if operation in _NUMBER_OF_VECTORS:
        return {"Value": _NUMBER_OF_VECTORS[operation](a, b), "Vector": _NO_VECTOR}
    if operation in _OF_VERSIONS:
        value = _OF_VERSIONS[operation](a, b, settings["before"])
    else:
        value = _VECTOR_MATH[operation](a, b, c, inputs.get("Scale", np.float32(1.0)))
    return {"Vector": value, "Value": _NO_NUMBER}


def clamp(context, settings, inputs):
    low, high = inputs["Min"], inputs["Max"]
    if settings["clamp_type"] == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    return {"Result": np.minimum(np.maximum(inputs["Value"], low), high)}


def _smoothstep(t):
    return t * t * (3.0 - 2.0 * t)


def _smootherstep(t):
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def _mapped(kind, value, low, high, to_low, to_high, steps):
    t = divided(value - low, high - low)
    if kind == "STEPPED":
        t = np.where(steps > 0.0, divided(np.floor(t * (steps + 1.0)), steps), 0.0)
    elif kind == "SMOOTHSTEP":
        t = _smoothstep(clipped(t))
    elif kind == "SMOOTHERSTEP":
        t = _smootherstep(clipped(t))
    return to_low + t * (to_high - to_low)


def map_range(context, settings, inputs):
    """As Cycles: of numbers, a range without width gives 0, and smooth steps are clamped too."""
    vectors = settings["data_type"] == "FLOAT_VECTOR"
    names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3")
    steps = "Steps_FLOAT3"
    if not vectors:
        names, steps = ("Value", "From Min", "From Max", "To Min", "To Max"), "Steps"
    value, low, high, to_low, to_high = (inputs[name] for name in names)
    kind = settings["interpolation_type"]
    result = _mapped(kind, value, low, high, to_low, to_high, inputs.get(steps))
    if not vectors:
        result = np.where(low == high, 0.0, result)
    if settings["clamp"] and (kind in ("LINEAR", "STEPPED") or not vectors):
        least, most = np.minimum(to_low, to_high), np.maximum(to_low, to_high)
        result = np.minimum(np.maximum(result, least), most)
    return {"Vector" if vectors else "Result": result}


def combine_xyz(context, settings, inputs):
    return {"Vector": vector(inputs["X"], inputs["Y"], inputs["Z"])}


def separate_xyz(context, settings, inputs):
    return dict(zip("XYZ", parts(inputs["Vector"]), strict=True))


def mix_numbers(factor, a, b, clamp):
    return mixed(a, b, clipped(factor) if clamp else factor)


FUNCTIONS = {
    "ShaderNodeMath": math,
    "ShaderNodeVectorMath": vector_math,
    "ShaderNodeClamp": clamp,
    "ShaderNodeMapRange": map_range,
    "ShaderNodeCombineXYZ": combine_xyz,
    "ShaderNodeSeparateXYZ": separate_xyz,
}

"""Colour nodes as functions of arrays: float (..., 3) colours, numbers as equal triples.

Each reproduces the Cycles node of its name. ``evaluate_color_node`` answers None for a node, or a
mode of one, that is not here.
"""

from __future__ import annotations

import numpy as np

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)

_MIX = {
    "MIX": lambda a, b: b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIFFERENCE": lambda a, b: abs(a - b),
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
}
_ARITHMETIC = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: np.where(b == 0.0, 0.0, a / np.where(b == 0.0, 1.0, b)),
    "MINIMUM": np.minimum,
    "MAXIMUM": np.maximum,
}


def luminance(color: np.ndarray) -> np.ndarray:
    """Cycles' conversion of a colour to a number, as three equal channels."""
    return np.repeat((color @ _LUMINANCE)[..., None], 3, -1)


def evaluate_color_node(node, value) -> np.ndarray | None:
    """The node's colour, or None if it is not supported.

    value(identifier): the colour at the node's input of that identifier, float (..., 3)
    """
    kind = node.bl_idname
    if kind == "ShaderNodeMix":
        return _mix_node(node, value)
    if kind == "ShaderNodeMixRGB":
        factor = np.clip(value("Fac"), 0.0, 1.0)
        return _mix(node.blend_type, factor, value("Color1"), value("Color2"), node.use_clamp)
    if kind == "ShaderNodeMath" and node.operation in _ARITHMETIC:
        result = _ARITHMETIC[node.operation](value("Value"), value("Value_001"))
        return np.clip(result, 0.0, 1.0) if node.use_clamp else result
    if kind == "ShaderNodeVectorMath" and node.operation == "SCALE":
        return value("Vector") * value("Scale")
    if kind == "ShaderNodeVectorMath" and node.operation in _ARITHMETIC:
        return _ARITHMETIC[node.operation](value("Vector"), value("Vector_001"))
    if kind == "ShaderNodeCombineXYZ":
        return np.stack([value(axis)[..., 0] for axis in "XYZ"], -1)
    if kind == "ShaderNodeCombineColor" and node.mode == "RGB":
        return np.stack([value(name)[..., 0] for name in ("Red", "Green", "Blue")], -1)
    if kind == "ShaderNodeRGBToBW":
        return luminance(value("Color"))
    if kind == "ShaderNodeGamma":
        color = value("Color")
        return np.where(color > 0.0, np.maximum(color, 1e-30) ** value("Gamma"), color)
    if kind == "ShaderNodeBrightContrast":
        bright, contrast = value("Bright"), value("Contrast")
        return np.maximum((1.0 + contrast) * value("Color") + bright - 0.5 * contrast, 0.0)
    if kind == "ShaderNodeInvert":
        return _mix("MIX", np.clip(value("Fac"), 0, 1), value("Color"), 1.0 - value("Color"), False)
    if kind == "ShaderNodeHueSaturation":
        return _hue_saturation(value)
    return None


def _mix_node(node, value):
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if kind is None:
        return None
    uneven = node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM"
    factor = value("Factor_Vector" if uneven else "Factor_Float")
    if node.clamp_factor or kind == "Color":
        factor = np.clip(factor, 0.0, 1.0)
    blend = node.blend_type if kind == "Color" else "MIX"
    clamp = node.clamp_result and kind == "Color"
    return _mix(blend, factor, value(f"A_{kind}"), value(f"B_{kind}"), clamp)


def _mix(blend_type, factor, a, b, clamp):
    if blend_type not in _MIX:
        return None
    result = (1.0 - factor) * a + factor * _MIX[blend_type](a, b)
    return np.clip(result, 0.0, 1.0) if clamp else result


def _hue_saturation(value):
    color = value("Color")
    hue, saturation, brightness = _rgb_to_hsv(color)
    hue = (hue + value("Hue")[..., 0] + 0.5) % 1.0
    saturation = np.clip(saturation * value("Saturation")[..., 0], 0.0, 1.0)
    changed = _hsv_to_rgb(hue, saturation, brightness * value("Value")[..., 0])
    factor = value("Fac")
    return np.maximum(factor * changed + (1.0 - factor) * color, 0.0)


def _rgb_to_hsv(color):
    high, low = color.max(-1), color.min(-1)
    span = high - low
    gray = span == 0.0
    r, g, b = (np.moveaxis(color, -1, 0) - low) / np.where(gray, 1.0, span)
    hue = np.where(r == 1.0, g - b, np.where(g == 1.0, 2.0 + b - r, 4.0 + r - g)) / 6.0 % 1.0
    saturation = np.where(high > 0.0, span / np.where(high > 0.0, high, 1.0), 0.0)
    return np.where(gray, 0.0, hue), saturation, high


def _hsv_to_rgb(hue, saturation, brightness):
    wave = np.clip(np.abs((hue[..., None] * 6.0 + (0.0, 4.0, 2.0)) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return brightness[..., None] * (1.0 - saturation[..., None] * (1.0 - wave))

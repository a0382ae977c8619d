"""Nodes that calculate with colours: Mix and its blend modes, Hue/Saturation, curves, ramps, ...

A function takes the context, the node's settings and its inputs (program.Op), and returns its
outputs by name. Each reproduces the Cycles node of its name.
"""

from __future__ import annotations

import numpy as np

from .arithmetic import mix_numbers
from .values import LUMINANCE, clipped, column, divided, mixed, parts, vector


def _hue(color, high, span):
    """The hue of a color whose largest channel is high, and the least one less by span."""
    r, g, b = parts(color)
    safe = np.where(span == 0.0, 1.0, span)
    hue = np.where(
        r == high, (g - b) / safe, np.where(g == high, 2.0 + (b - r) / safe, 4.0 + (r - g) / safe)
    )
    hue = np.where(span == 0.0, 0.0, hue / 6.0)
    return np.where(hue < 0.0, hue + 1.0, hue)


def rgb_to_hsv(color):
    """As Cycles: where the largest channel is 0 there is no hue, whatever the others are."""
    high = color.max(-1)
    span = high - color.min(-1)
    hue = np.where(high == 0.0, 0.0, _hue(color, high, span))
    return vector(hue, divided(span, high), high)


def hsv_to_rgb(hsv):
    """As Cycles: a hue outside of 0 ... 1 is not wrapped, it falls into the last sector."""
    hue, saturation, value = parts(hsv)
    hue = 6.0 * np.where(hue == 1.0, 0.0, hue)
    sector = np.floor(hue)
    f, v = hue - sector, value
    p, q, t = (v * (1.0 - saturation * k) for k in (1.0, f, 1.0 - f))
    is_in = [sector == k for k in range(5)]
    red = np.select(is_in, [v, q, p, p, t], v)
    green = np.select(is_in, [t, v, v, q, p], p)
    return vector(red, green, np.select(is_in, [p, p, t, v, v], q))


def rgb_to_hsl(color):
    high, low = color.max(-1), color.min(-1)
    lightness = np.minimum((high + low) / 2.0, 1.0)
    span = high - low
    below = np.where(lightness > 0.5, 2.0 - high - low, high + low)
    below = np.where(span == 0.0, np.float32(1.0), below)  # else infinite where it is 0, as there
    return vector(_hue(color, high, span), span / below, lightness)


def hsl_to_rgb(hsl):
    """As Cycles, which does not wrap the hue either."""
    hue, saturation, lightness = parts(hsl)
    bent = np.abs(column(hue) * 6.0 - np.float32([3.0, 2.0, 4.0]))
    wave = clipped(bent * np.float32([1.0, -1.0, -1.0]) + np.float32([-1.0, 2.0, 2.0]))
    chroma = (1.0 - np.abs(2.0 * lightness - 1.0)) * saturation
    return (wave - 0.5) * column(chroma) + column(lightness)


def _overlay(t, a, b):
    return np.where(
        a < 0.5, a * ((1.0 - t) + 2.0 * t * b), 1.0 - ((1.0 - t) + 2.0 * t * (1.0 - b)) * (1.0 - a)
    )


def _soft_light(t, a, b):
    screen = 1.0 - (1.0 - b) * (1.0 - a)
    return (1.0 - t) * a + t * ((1.0 - a) * b * a + a * screen)


def _dodge(t, a, b):
    rest = 1.0 - t * b
    bright = np.where(rest <= 0.0, 1.0, np.minimum(divided(a, rest), 1.0))
    return np.where(a != 0.0, bright, a)


def _burn(t, a, b):
    rest = 1.0 - t + t * b
    return np.where(rest <= 0.0, 0.0, clipped(1.0 - divided(1.0 - a, rest)))


def _linear_light(t, a, b):
    return a + t * (2.0 * (b - 0.5))


def _with_parts(t, a, b, chosen):
    """a with the hue, saturation or value (0, 1, 2) of b."""
    hsv, other = rgb_to_hsv(a), rgb_to_hsv(b)
    if chosen == 1:  # of grey nothing is changed
        hsv = np.broadcast_to(hsv, np.broadcast_shapes(hsv.shape, other.shape, t.shape)).copy()
        s = (1.0 - t[..., 0]) * hsv[..., 1] + t[..., 0] * other[..., 1]
        changed = vector(hsv[..., 0], s, hsv[..., 2])
        return np.where(hsv[..., 1:2] != 0.0, hsv_to_rgb(changed), a)
    v = (1.0 - t[..., 0]) * hsv[..., 2] + t[..., 0] * other[..., 2]
    return hsv_to_rgb(vector(hsv[..., 0], hsv[..., 1], v))


def _blend_hue(t, a, b):
    hsv, other = rgb_to_hsv(a), rgb_to_hsv(b)
    changed = hsv_to_rgb(vector(other[..., 0], hsv[..., 1], hsv[..., 2]))
    return np.where(other[..., 1:2] != 0.0, mixed(a, changed, t), a)


def _color(t, a, b):
    hsv, other = rgb_to_hsv(a), rgb_to_hsv(b)
    changed = hsv_to_rgb(vector(other[..., 0], other[..., 1], hsv[..., 2]))
    return np.where(other[..., 1:2] != 0.0, mixed(a, changed, t), a)


BLEND = {
    "MIX": lambda t, a, b: mixed(a, b, t),
    "ADD": lambda t, a, b: a + b * t,
    "MULTIPLY": lambda t, a, b: mixed(a, a * b, t),
    "SUBTRACT": lambda t, a, b: a - b * t,
    "SCREEN": lambda t, a, b: 1.0 - ((1.0 - t) + t * (1.0 - b)) * (1.0 - a),
    "DIVIDE": lambda t, a, b: np.where(b != 0.0, (1.0 - t) * a + t * divided(a, b), a),
    "DIFFERENCE": lambda t, a, b: mixed(a, np.abs(a - b), t),
    "EXCLUSION": lambda t, a, b: np.maximum(mixed(a, a + b - 2.0 * a * b, t), 0.0),
    "DARKEN": lambda t, a, b: mixed(a, np.minimum(a, b), t),
    "LIGHTEN": lambda t, a, b: mixed(a, np.maximum(a, b), t),
    "OVERLAY": _overlay,
    "DODGE": _dodge,
    "BURN": _burn,
    "HUE": _blend_hue,
    "SATURATION": lambda t, a, b: _with_parts(t, a, b, 1),
    "VALUE": lambda t, a, b: _with_parts(t, a, b, 2),
    "COLOR": _color,
    "SOFT_LIGHT": _soft_light,
    "LINEAR_LIGHT": _linear_light,
}


def _blended(settings, factor, a, b, clamp):
    value = BLEND[settings["blend_type"]](column(clipped(factor)), a, b)
    return clipped(value) if clamp else value


def mix_rgb(context, settings, inputs):
    a, b = inputs["Color1"], inputs["Color2"]
    return {"Color": _blended(settings, inputs["Fac"], a, b, settings["use_clamp"])}


def mix(context, settings, inputs):
    kind = settings["data_type"]
    if kind == "RGBA":
        a, b, factor = inputs["A_Color"], inputs["B_Color"], inputs["Factor_Float"]
        factor = clipped(factor) if settings["clamp_factor"] else factor
        value = BLEND[settings["blend_type"]](column(factor), a, b)
        return {"Result_Color": clipped(value) if settings["clamp_result"] else value}
    if kind == "FLOAT":
        a, b, factor = inputs["A_Float"], inputs["B_Float"], inputs["Factor_Float"]
        return {"Result_Float": mix_numbers(factor, a, b, settings["clamp_factor"])}
    uneven = settings["factor_mode"] == "NON_UNIFORM"
    factor = inputs["Factor_Vector"] if uneven else column(inputs["Factor_Float"])
    a, b = inputs["A_Vector"], inputs["B_Vector"]
    return {"Result_Vector": mix_numbers(factor, a, b, settings["clamp_factor"])}


def hue_saturation(context, settings, inputs):
    color = inputs["Color"]
    hue, saturation, value = parts(rgb_to_hsv(color))
    hue = np.mod(hue + inputs["Hue"] + 0.5, 1.0)
    saturation = clipped(saturation * inputs["Saturation"])
    changed = hsv_to_rgb(vector(hue, saturation, value * inputs["Value"]))
    factor = column(inputs["Fac"])
    return {"Color": np.maximum(factor * changed + (1.0 - factor) * color, 0.0)}


def bright_contrast(context, settings, inputs):
    bright, contrast = column(inputs["Bright"]), column(inputs["Contrast"])
    return {"Color": np.maximum((1.0 + contrast) * inputs["Color"] + bright - 0.5 * contrast, 0.0)}


def gamma(context, settings, inputs):
    color, power = inputs["Color"], column(inputs["Gamma"])
    raised = np.where(color > 0.0, np.power(np.maximum(color, 1e-30), power), color)
    return {"Color": np.where(power == 0.0, 1.0, raised)}


def invert(context, settings, inputs):
    color, factor = inputs["Color"], column(inputs["Fac"])
    return {"Color": factor * (1.0 - color) + (1.0 - factor) * color}


def rgb_to_bw(context, settings, inputs):
    return {"Val": inputs["Color"] @ settings.get("luminance", LUMINANCE)}


_TO_PARTS = {"RGB": lambda c: c, "HSV": rgb_to_hsv, "HSL": rgb_to_hsl}
_FROM_PARTS = {"RGB": lambda c: c, "HSV": hsv_to_rgb, "HSL": hsl_to_rgb}


def separate_color(context, settings, inputs):
    values = parts(_TO_PARTS[settings["mode"]](inputs["Color"]))
    return dict(zip(("Red", "Green", "Blue"), values, strict=True))


def combine_color(context, settings, inputs):
    values = vector(inputs["Red"], inputs["Green"], inputs["Blue"])
    return {"Color": _FROM_PARTS[settings["mode"]](values)}


def color_ramp(context, settings, inputs):
    """settings: table float32 (n, 4), the ramp at n even steps; stepped: do not interpolate."""
    table = settings["table"]
    last = len(table) - 1
    place = clipped(inputs["Fac"]) * last
    row = np.minimum(place.astype(np.int32), last)
    value = table[row]
    if not settings["stepped"]:
        t = column(place - row)
        value = (1.0 - t) * value + t * table[np.minimum(row + 1, last)]
    return {"Color": value[..., :3], "Alpha": value[..., 3]}


def _curve(table, value, low, high, extend):
    """A curve sampled at even steps from low to high, straight on outside where extend says so."""
    last = len(table) - 1
    place = (value - low) / (high - low) * last
    inside = np.clip(place, 0.0, last)
    row = np.minimum(inside.astype(np.int32), last - 1)
    t = inside - row
    result = (1.0 - t) * table[row] + t * table[row + 1]
    if extend:
        result = result + np.where(place < 0.0, place * (table[1] - table[0]), 0.0)
        result = result + np.where(place > last, (place - last) * (table[-1] - table[-2]), 0.0)
    return result


def rgb_curves(context, settings, inputs):
    """settings: table float32 (n, 3), combined curve included; low, high, extend"""
    color = inputs["Color"]
    table, rest = settings["table"], (settings["low"], settings["high"], settings["extend"])
    curved = vector(*(_curve(table[:, c], color[..., c], *rest) for c in range(3)))
    return {"Color": mixed(color, curved, column(inputs["Fac"]))}


def vector_curves(context, settings, inputs):
    value = inputs["Vector"]
    table, rest = settings["table"], (settings["low"], settings["high"], settings["extend"])
    curved = vector(*(_curve(table[:, c], value[..., c], *rest) for c in range(3)))
    return {"Vector": mixed(value, curved, column(inputs["Fac"]))}


def float_curve(context, settings, inputs):
    value = inputs["Value"]
    rest = settings["low"], settings["high"], settings["extend"]
    curved = _curve(settings["table"], value, *rest)
    return {"Value": mixed(value, curved, inputs["Factor"])}


# Kelvin; what is beyond has the color of the limit.
COOLEST, HOTTEST = 800.0, 12000.0


def blackbody(context, settings, inputs):
    """settings: table float32 (n, 3), Cycles' colors, COOLEST to HOTTEST, logarithmic steps"""
    table = settings["table"]
    last = len(table) - 1
    low, high = np.log(np.float32(COOLEST)), np.log(np.float32(HOTTEST))
    kelvin = np.clip(np.nan_to_num(inputs["Temperature"]), COOLEST, HOTTEST)
    place = (np.log(kelvin) - low) / (high - low) * last
    row = np.minimum(place.astype(np.int32), last - 1)
    t = column(place - row)
    return {"Color": (1.0 - t) * table[row] + t * table[row + 1]}


FUNCTIONS = {
    "ShaderNodeBlackbody": blackbody,
    "ShaderNodeMix": mix,
    "ShaderNodeMixRGB": mix_rgb,
    "ShaderNodeHueSaturation": hue_saturation,
    "ShaderNodeBrightContrast": bright_contrast,
    "ShaderNodeGamma": gamma,
    "ShaderNodeInvert": invert,
    "ShaderNodeRGBToBW": rgb_to_bw,
    "ShaderNodeSeparateColor": separate_color,
    "ShaderNodeCombineColor": combine_color,
    "ShaderNodeValToRGB": color_ramp,
    "ShaderNodeRGBCurve": rgb_curves,
    "ShaderNodeVectorCurve": vector_curves,
    "ShaderNodeFloatCurve": float_curve,
}

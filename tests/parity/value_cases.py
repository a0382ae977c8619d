"""Math, colour and vector nodes."""

import bpy

from .cases import shown


def choices(node, name):
    """All that this Blender has for a property of a node."""
    return [item.identifier for item in getattr(bpy.types, node).bl_rna.properties[name].enum_items]


BLENDS = (
    "MIX DARKEN MULTIPLY BURN LIGHTEN SCREEN DODGE ADD OVERLAY SOFT_LIGHT LINEAR_LIGHT DIFFERENCE "
    "EXCLUSION SUBTRACT DIVIDE HUE SATURATION COLOR VALUE"
).split()


def _math(operation):
    def make(tree):
        inputs = {0: tree.axis("X", -1.5, 2.0), 1: tree.axis("Z", 0.3, 1.8), 2: 0.4}
        return tree.made("ShaderNodeMath", 0, inputs, operation=operation)

    return make


def _vector_math(operation):
    def make(tree):
        output = operation in ("DOT_PRODUCT", "DISTANCE", "LENGTH")
        inputs = {0: tree.color(-1.0, 2.0), 1: (0.7, 1.1, 0.4), 2: (0.2, 0.1, 0.3), "Scale": 0.6}
        return tree.made("ShaderNodeVectorMath", int(output), inputs, operation=operation)

    return make


def _blend(blend):
    def make(tree):
        other = tree.made("ShaderNodeVectorMath", 0, {0: tree.color(), 1: (0.3, 0.2, 0.1)})
        inputs = {"Factor_Float": 0.7, "A_Color": tree.color(), "B_Color": other}
        node = tree.node("ShaderNodeMix", data_type="RGBA", blend_type=blend)
        for key, value in inputs.items():
            tree.link(value, next(s for s in node.inputs if s.identifier == key))
        return next(s for s in node.outputs if s.identifier == "Result_Color")

    return make


for _operation in choices("ShaderNodeMath", "operation"):
    shown(f"Math {_operation}", _math(_operation))
for _operation in choices("ShaderNodeVectorMath", "operation"):
    shown(f"Vector Math {_operation}", _vector_math(_operation))
for _operation in BLENDS:
    shown(f"Mix colour {_operation}", _blend(_operation))
for _kind in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):
    for _clamp in (False, True):

        def _map_range(tree, kind=_kind, clamp=_clamp):
            inputs = {"Value": tree.axis("X"), "From Min": 0.2, "From Max": 0.8, "To Max": 2.0}
            return tree.made("ShaderNodeMapRange", 0, inputs, interpolation_type=kind, clamp=clamp)

        shown(f"Map Range {_kind}{' clamped' if _clamp else ''}", _map_range)
for _kind in ("MINMAX", "RANGE"):
    shown(
        f"Clamp {_kind}",
        lambda tree, kind=_kind: tree.made(
            "ShaderNodeClamp",
            0,
            {"Value": tree.axis("X"), "Min": 0.7, "Max": 0.3},
            clamp_type=kind,
        ),
    )
for _mode in ("RGB", "HSV", "HSL"):
    shown(
        f"Separate Color {_mode}",
        lambda tree, mode=_mode: tree.made(
            "ShaderNodeCombineXYZ",
            0,
            dict(
                enumerate(
                    tree.made("ShaderNodeSeparateColor", k, {0: tree.color()}, mode=mode)
                    for k in range(3)
                )
            ),
        ),
    )
    shown(
        f"Combine Color {_mode}",
        lambda tree, mode=_mode: tree.made(
            "ShaderNodeCombineColor",
            0,
            {k: tree.axis(a, 0.05, 0.95) for k, a in enumerate("XYZ")},
            mode=mode,
        ),
    )
shown(
    "Hue/Saturation",
    lambda t: t.made("ShaderNodeHueSaturation", 0, {0: 0.3, 1: 1.4, 2: 0.8, 3: 0.8, 4: t.color()}),
)
shown(
    "Brightness/Contrast",
    lambda t: t.made("ShaderNodeBrightContrast", 0, {0: t.color(), 1: 0.1, 2: 0.4}),
)
shown("Gamma", lambda t: t.made("ShaderNodeGamma", 0, {0: t.color(), 1: 2.2}))
shown("Invert", lambda t: t.made("ShaderNodeInvert", 0, {0: 0.7, 1: t.color()}))
shown(
    "Blackbody",
    lambda t: t.made("ShaderNodeBlackbody", 0, {0: t.axis("X", 500.0, 14000.0)}),
)
shown("Blackbody, one temperature", lambda t: t.made("ShaderNodeBlackbody", 0, {0: 2300.0}))
shown("RGB to BW", lambda t: t.made("ShaderNodeRGBToBW", 0, {0: t.color()}))


def _ramp(interpolation, color_mode="RGB"):
    def make(tree):
        node = tree.node("ShaderNodeValToRGB")
        ramp = node.color_ramp
        ramp.color_mode = color_mode
        if color_mode == "RGB":
            ramp.interpolation = interpolation
        ramp.elements[0].color = (0.9, 0.1, 0.2, 1.0)
        ramp.elements.new(0.4).color = (0.1, 0.8, 0.3, 0.5)
        ramp.elements[-1].color = (0.2, 0.3, 0.9, 1.0)
        tree.link(tree.axis("Z"), node.inputs[0])
        return node.outputs[0]

    return make


for _kind in ("LINEAR", "EASE", "CARDINAL", "B_SPLINE", "CONSTANT"):
    shown(f"Color Ramp {_kind}", _ramp(_kind))
shown("Color Ramp HSV", _ramp("", "HSV"))


def _thin_ramp(interpolation):
    """A ramp whose colors are closer together than the values that Cycles keeps of it."""

    def make(tree):
        node = tree.node("ShaderNodeValToRGB")
        ramp = node.color_ramp
        ramp.interpolation = interpolation
        for place in (0.1, 0.1443, 0.4995, 0.5, 0.5005, 0.873):
            shade = 1.0 - place if len(ramp.elements) % 2 else 0.3 * place
            ramp.elements.new(place).color = (shade, 0.5 * shade, 1.0 - shade, 1.0)
        tree.link(tree.axis("Z", 0.46, 0.54), node.inputs[0])
        return node.outputs[0]

    return make


for _kind in ("LINEAR", "CONSTANT"):
    shown(f"Color Ramp {_kind}, thin lines", _thin_ramp(_kind))


def _curve(kind):
    def make(tree):
        node = tree.node(kind)
        for number, curve in enumerate(node.mapping.curves):
            curve.points.new(0.4, 0.7 - 0.1 * number)
        node.mapping.update()
        value = (
            tree.axis("X", -0.2, 1.2) if kind == "ShaderNodeFloatCurve" else tree.color(-0.2, 1.2)
        )
        tree.link(value, node.inputs[1])
        tree.link(0.8, node.inputs[0])
        return node.outputs[0]

    return make


def _bent_curve(kind, extend):
    """A curve that turns sharply, and goes on beyond its ends."""

    def make(tree):
        node = tree.node(kind)
        node.mapping.extend, node.mapping.use_clip = extend, False
        for number, curve in enumerate(node.mapping.curves):
            curve.points[0].location = (0.0, 0.3)
            curve.points[-1].location = (1.0, 0.2 * number)
            for place, height in ((0.02, 0.9), (0.331, 0.2), (0.347, 0.8), (0.97, 0.6)):
                curve.points.new(place, height - 0.1 * number).handle_type = "VECTOR"
        node.mapping.update()
        number = kind == "ShaderNodeFloatCurve"
        value = tree.axis("X", -0.3, 1.3) if number else tree.color(-0.3, 1.3)
        tree.link(value, node.inputs[1])
        return node.outputs[0]

    return make


for _kind in ("RGB", "Float", "Vector"):
    for _extend in ("HORIZONTAL", "EXTRAPOLATED"):
        shown(
            f"{_kind} Curve, sharp, {_extend.lower()}",
            _bent_curve(f"ShaderNode{_kind}Curve", _extend),
        )
shown("RGB Curves", _curve("ShaderNodeRGBCurve"))
shown("Float Curve", _curve("ShaderNodeFloatCurve"))
shown("Vector Curves", _curve("ShaderNodeVectorCurve"))

"""Displacement of materials as Cycles shows it by default: as bump."""

from __future__ import annotations

import numpy as np

from ...core.program import Ref, Value
from .node_values import follow

_ONE = np.float32(1.0)


def displaced_normal(material, output, builder) -> Value | None:
    """The normal that the Displacement of a Material Output leaves; None: there is nothing that
    turns it."""
    end, warn = follow(output.inputs["Displacement"]), builder.reader.warn
    if end.node is None:
        return None
    if end.node.bl_idname != "ShaderNodeDisplacement":
        warn(end.node, f"{end.node.bl_label} is not supported: no displacement")
        return None
    if material.displacement_method != "BUMP":
        warn(end.node, "no vertex is displaced: it is shown as bump")
    height = _height(end.node, end.groups, builder)
    if not isinstance(height, Ref):
        return None
    inputs = {"Height": height, "Strength": _ONE, "Distance": _ONE}
    return Ref(builder.add_node(None, (), "ShaderNodeBump", inputs, {"invert": False}), "Normal")


def _height(node, groups, builder) -> Value:
    """Metres along the normal."""
    height, middle, scale = (
        builder.number(node, name, groups) for name in ("Height", "Midlevel", "Scale")
    )
    for operation, other in (("SUBTRACT", middle), ("MULTIPLY", scale)):
        settings = {"operation": operation, "use_clamp": False}
        inputs = {"Value": height, "Value_001": other}
        height = builder.run("ShaderNodeMath", "Value", settings=settings, **inputs)
    if node.space == "OBJECT" and isinstance(height, Ref):
        height = builder.run_at_points("object_height", Size=height)
    return height

"""The Displacement of a Material Output: what moves vertices, and what turns normals as a bump."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from ....core.data.program import Ref, Value
from .node_values import follow

_ONE = np.float32(1.0)


class DisplacementRead(NamedTuple):
    """normal: what it leaves, as a bump; None: there is nothing that turns it
    moves: a vector, metres in world space; None: vertices stay
    """

    normal: Ref | None
    moves: Value | None


def read_displacement(material, output, builder) -> DisplacementRead:
    """What Cycles makes of a material's displacement, by its setting Displacement."""
    socket, method = output.inputs["Displacement"], material.displacement_method
    if follow(socket).node is None:
        return DisplacementRead(None, None)
    moves = normal = None
    if method != "BUMP":
        value = builder.behind(socket, (), "VECTOR")
        moves = value if isinstance(value, Ref) or np.any(value) else None
    if method != "DISPLACEMENT":
        normal = _bump(socket, builder, at_rest=method == "BOTH")
    return DisplacementRead(normal, moves)


def _bump(socket, builder, at_rest) -> Ref | None:
    end = follow(socket)
    if end.node.bl_idname == "ShaderNodeDisplacement":  # whatever its Normal, as in Cycles
        height = _height(end.node, end.groups, builder)
    else:  # along the normal
        along = builder.add_node(None, (), "ShaderNodeNewGeometry", {}, {"outputs": {"Normal"}})
        inputs = {
            "Vector": builder.behind(socket, (), "VECTOR"),
            "Vector_001": Ref(along, "Normal"),
        }
        settings = {"operation": "DOT_PRODUCT"}
        height = builder.run("ShaderNodeVectorMath", "Value", settings=settings, **inputs)
    if not isinstance(height, Ref):
        return None
    inputs = {"Height": height, "Strength": _ONE, "Distance": _ONE}
    settings = {"invert": False, "at_rest": at_rest, "rescaled": bpy.app.version < (5, 2)}
    return Ref(builder.add_node(None, (), "ShaderNodeBump", inputs, settings), "Normal")


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

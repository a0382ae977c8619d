"""Random values that nodes know without inputs: of rays, objects, instances, strands, normals."""

from __future__ import annotations

import bpy
from parity.particle_cases import SCALES

from . import attributes
from .dice import Dice

_INFO = {
    "ShaderNodeHairInfo": ("Is Strand", "Intercept", "Length", "Thickness", "Random"),
    "ShaderNodePointInfo": ("Radius", "Random"),
    "ShaderNodeObjectInfo": ("Random", "Alpha", "Object Index", "Material Index"),
    "ShaderNodeCameraData": ("View Z Depth", "View Distance"),
    "ShaderNodeLightPath": ("Is Camera Ray", "Is Shadow Ray", "Ray Depth", "Transparent Depth"),
    "ShaderNodeNewGeometry": ("Backfacing", "Pointiness", "Random Per Island"),
}
_VECTORS = {
    "ShaderNodeHairInfo": ("Tangent Normal",),
    "ShaderNodePointInfo": ("Position",),
    "ShaderNodeObjectInfo": ("Location", "Color"),
    "ShaderNodeCameraData": ("View Vector",),
    "ShaderNodeNewGeometry": ("Position", "Normal", "True Normal", "Incoming"),
    "ShaderNodeTexCoord": ("Camera", "Window", "Reflection", "Object", "Generated", "UV"),
}


def number(dice: Dice, tree):
    """A number of some size."""
    kind = dice.of("info", "info", "particle", "weight", "attribute", "wireframe")
    if kind == "particle":
        return _particle(dice, tree, ("Index", "Random", "Age", "Lifetime", "Size"))
    if kind == "info":
        node = dice.of(*_INFO)
        dice.tell(node[10:])
        return tree.made(node, dice.of(*_INFO[node]))
    if kind == "attribute":
        return attributes.read_number(dice, tree)
    dice.tell(kind)
    if kind == "wireframe":
        return tree.made("ShaderNodeWireframe", 0, {"Size": dice.between(0.02, 0.1)})
    inputs = {"Normal": turned(dice, tree)} if dice.chance(0.5) else {}
    if dice.chance(0.4):
        return tree.made("ShaderNodeFresnel", 0, inputs | {"IOR": dice.between(0.5, 2.5)})
    output, inputs = dice.of("Fresnel", "Facing"), inputs | {"Blend": dice.edge(0.0, 0.95)}
    return tree.made("ShaderNodeLayerWeight", output, inputs)


def _particle(dice, tree, outputs):
    output = dice.of(*outputs)
    dice.tell(f"particle {output.lower()}")
    value = tree.made("ShaderNodeParticleInfo", output)
    inputs = {0: value, 1: (SCALES[output],) * 3}
    return tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY")


def vector(dice: Dice, tree):
    """A vector of some size."""
    kind = dice.of("info", "info", "info", "particle", "normal", "attribute", "instancer", "other")
    dice.tell(kind)
    if kind == "info":
        node = dice.of(*_VECTORS)
        output = dice.of(*_VECTORS[node])
        dice.tell(f"{node[10:]} {output}")
        return tree.made(node, output)
    if kind == "particle":
        return _particle(dice, tree, ("Location", "Velocity", "Angular Velocity"))
    if kind == "normal":
        return turned(dice, tree)
    if kind == "attribute":
        how = {
            "attribute_name": attributes.NAME,
            "attribute_type": dice.of("GEOMETRY", "INSTANCER"),
        }
        return tree.made("ShaderNodeAttribute", "Vector", **how)
    if kind == "instancer":
        output = dice.of("Generated", "UV", "Object")
        return tree.made("ShaderNodeTexCoord", output, from_instancer=True)
    node = tree.node("ShaderNodeTexCoord", object=bpy.context.scene.camera)
    return node.outputs["Object"]


def turned(dice: Dice, tree):
    """A normal, or a tangent, by any node that makes one."""
    kind = dice.of("map", "map", "bump", "tangent", "node")
    dice.tell(kind)
    if kind == "map":
        space = dice.of("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")
        uv = dice.of("", "UVMap", attributes.UV) if space == "TANGENT" else ""
        inputs = {"Color": dice.vector(0.0, 1.0), "Strength": dice.edge(0.0, 1.5)}
        return tree.made("ShaderNodeNormalMap", 0, inputs, space=space, uv_map=uv)
    if kind == "bump":
        height = tree.made("ShaderNodeTexNoise", 0, {"Scale": 2.0, "Detail": 0.0})
        inputs = {"Height": height, "Strength": dice.edge(0.0, 1.0), "Distance": 0.3}
        return tree.made("ShaderNodeBump", 0, inputs, invert=dice.chance(0.5))
    if kind == "tangent":
        # Round another axis a flat floor has none, and Cycles no number.
        how = {"direction_type": dice.of("UV_MAP", "RADIAL"), "axis": "Z"}
        return tree.made("ShaderNodeTangent", 0, **how)
    node = tree.node("ShaderNodeNormal")
    node.outputs[0].default_value = dice.vector(-1.0, 1.0)
    return node.outputs[0]

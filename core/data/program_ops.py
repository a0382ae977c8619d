"""What the operations of a program depend on."""

from __future__ import annotations

from .program import Op, Program, Ref, Shaders, Value

_OF_RAYS = ("ShaderNodeFresnel", "ShaderNodeLayerWeight", "under_coat", "under_sheen")
_RAY_OUTPUTS = {"Incoming", "Backfacing", "Ray Length", "Ray Depth", "Transparent Depth"}
COORDINATES = ("ShaderNodeTexCoord", "ShaderNodeNewGeometry", "ShaderNodeObjectInfo")
# Kinds that look at nothing but values at the corners; images do if their coordinates do.
_OF_CORNERS = ("ShaderNodeUVMap", "ShaderNodeVertexColor", "attribute")
# Nodes whose outputs depend on nothing but their inputs.
PURE = {
    "ShaderNodeMath",
    "ShaderNodeVectorMath",
    "ShaderNodeClamp",
    "ShaderNodeMapRange",
    "ShaderNodeCombineXYZ",
    "ShaderNodeSeparateXYZ",
    "ShaderNodeMix",
    "ShaderNodeMixRGB",
    "ShaderNodeHueSaturation",
    "ShaderNodeBrightContrast",
    "ShaderNodeGamma",
    "ShaderNodeInvert",
    "ShaderNodeRGBToBW",
    "ShaderNodeSeparateColor",
    "ShaderNodeCombineColor",
    "ShaderNodeMapping",
    "ShaderNodeVectorRotate",
}
# Operations that know nothing but their inputs.
BY_INPUTS = PURE | {
    "ShaderNodeValToRGB",
    "ShaderNodeRGBCurve",
    "ShaderNodeVectorCurve",
    "ShaderNodeFloatCurve",
    "convert",
    "scale",
    "product",
    "weigh",
    "sum",
}
_AROUND = ("ShaderNodeAmbientOcclusion", "ShaderNodeBevel")


def ops_behind(program: Program, value: Value) -> list[Op]:
    """The operations that a value depends on."""
    found, todo = {}, [value]
    while todo:
        value = todo.pop()
        if isinstance(value, Ref) and value.op not in found:
            found[value.op] = program.ops[value.op]
            todo.extend(program.ops[value.op].inputs.values())
    return list(found.values())


def passes_by_place(program: Program) -> bool:
    """Whether what a program lets through is a matter of the place alone, and not of the ray."""
    return not any(map(_is_of_ray, ops_behind(program, program.transparent)))


def passes_by_angle(program: Program) -> bool:
    """Whether what a program lets through is a matter of the place, of the angle between ray and
    normal, and of the side that it meets."""
    return all(
        _is_of_angle(op) or not _is_of_ray(op) for op in ops_behind(program, program.transparent)
    )


def _is_of_ray(op: Op) -> bool:
    return op.kind in _OF_RAYS or bool(_RAY_OUTPUTS & op.settings.get("outputs", set()))


def _is_of_angle(op: Op) -> bool:
    """The normal is the surface's own: a node may have another."""
    if op.kind in _OF_RAYS:
        return "Normal" not in op.inputs
    return op.kind == "ShaderNodeNewGeometry" and op.settings["outputs"] == {"Backfacing"}


def passes_alike(program: Program) -> bool:
    """Whether it lets as much through everywhere, of rays that meet it at one angle."""
    return all(
        op.kind in BY_INPUTS or op.kind == "ShaderNodeLightPath" or _is_of_angle(op)
        for op in ops_behind(program, program.transparent)
    )


def is_of_corners(op: Op) -> bool:
    """Whether an operation looks at nothing but values at a triangle's corners: so that triangles
    which have the same there look the same, whatever object they are of."""
    if _is_of_angle(op):
        return True
    outputs = op.settings.get("outputs", set())
    if op.kind == "ShaderNodeTexCoord":
        elsewhere = "world_to_object" in op.settings or op.settings.get("from_instancer")
        return outputs <= {"UV"} and not elsewhere
    if op.kind == "ShaderNodeTexImage":
        return op.settings["projection"] == "FLAT"
    if op.kind == "object_attribute":
        return False
    if op.kind.startswith("ShaderNodeTex") and "Vector" not in op.inputs:
        return False
    return op.kind in _OF_CORNERS or not outputs


def depends_on_around(program: Program, value: Value) -> bool:
    """Whether a value depends on what is around a point (near_rays.py)."""
    return any(op.kind in _AROUND for op in ops_behind(program, value))


def asks_around(shaders: Shaders) -> bool:
    """Whether any node asks what is around a point."""
    programs = [*shaders.programs, *(p for aov in shaders.aovs for p in aov.programs)]
    return any(op.kind in _AROUND for p in programs if p is not None for op in p.ops)

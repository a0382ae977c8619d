"""Coordinates, attributes and what depends on the view."""

import bpy

from .cases import CASES, Case, shown


def _set(node, name, value):
    """Set an input, in use or not: by name, only those in use are found."""
    next(s for s in node.inputs if s.identifier == name).default_value = value


for _name in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"):
    shown(
        f"Texture Coordinate {_name}",
        lambda t, name=_name: t.made(
            "ShaderNodeVectorMath", 0, {0: t.coordinates(name)}, operation="ABSOLUTE"
        ),
    )
for _name in (
    "Position",
    "Normal",
    "True Normal",
    "Incoming",
    "Backfacing",
    "Parametric",
    "Tangent",
    "Pointiness",
    "Random Per Island",
):
    shown(
        f"Geometry {_name}",
        lambda t, name=_name: t.made(
            "ShaderNodeVectorMath",
            0,
            {0: t.made("ShaderNodeNewGeometry", name)},
            operation="ABSOLUTE",
        ),
    )


def _of_one_mesh(name, output, **place):
    """All objects of the scene are joined, their edges split; place: of what comes of it."""

    def build(scene, tree):
        tree.glow(tree.made("ShaderNodeNewGeometry", output))
        objects = [obj for obj in scene.objects if obj.type == "MESH"]
        with bpy.context.temp_override(
            active_object=objects[0], object=objects[0], selected_editable_objects=objects
        ):
            bpy.ops.object.join()
        for key, value in place.items():
            setattr(objects[0], key, value)
        objects[0].modifiers.new("Split", "EDGE_SPLIT").split_angle = 0.7

    CASES.append(Case(name, build))


_of_one_mesh("Geometry Random Per Island, one mesh", "Random Per Island")
_of_one_mesh("Geometry Pointiness, split edges", "Pointiness", scale=(1.0, 0.8, 1.2))
_of_one_mesh("Geometry Parametric, mirrored", "Parametric", scale=(1.0, 1.0, -1.0))
for _name in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"):
    shown(
        f"Object Info {_name}",
        lambda t, name=_name: t.made(
            "ShaderNodeVectorMath",
            0,
            {0: t.made("ShaderNodeObjectInfo", name)},
            operation="ABSOLUTE",
        ),
    )
for _name in ("Is Camera Ray", "Is Shadow Ray", "Ray Length", "Is Diffuse Ray", "Ray Depth"):
    shown(f"Light Path {_name}", lambda t, name=_name: t.made("ShaderNodeLightPath", name))
for _name in ("View Vector", "View Z Depth", "View Distance"):
    shown(f"Camera Data {_name}", lambda t, name=_name: t.made("ShaderNodeCameraData", name))
for _kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):

    def _mapping(tree, kind=_kind):
        node = tree.node("ShaderNodeMapping", vector_type=kind)
        tree.link(tree.coordinates(), node.inputs["Vector"])
        if kind in ("POINT", "TEXTURE"):
            node.inputs["Location"].default_value = (0.3, -0.2, 0.5)
        node.inputs["Rotation"].default_value = (0.4, 0.8, -0.3)
        node.inputs["Scale"].default_value = (1.5, 0.7, 2.0)
        return tree.made("ShaderNodeVectorMath", 0, {0: node.outputs[0]}, operation="ABSOLUTE")

    shown(f"Mapping {_kind}", _mapping)
for _kind in ("AXIS_ANGLE", "X_AXIS", "Z_AXIS", "EULER_XYZ"):

    def _rotate(tree, kind=_kind):
        node = tree.node("ShaderNodeVectorRotate", rotation_type=kind)
        tree.link(tree.coordinates(), node.inputs["Vector"])
        _set(node, "Center", (0.1, 0.2, 0.3))
        _set(node, "Angle", 0.7)
        _set(node, "Rotation", (0.4, 0.8, -0.3))
        return tree.made("ShaderNodeVectorMath", 0, {0: node.outputs[0]}, operation="ABSOLUTE")

    shown(f"Vector Rotate {_kind}", _rotate)
for _kind, _from, _to in (
    ("POINT", "OBJECT", "CAMERA"),
    ("VECTOR", "WORLD", "OBJECT"),
    ("NORMAL", "OBJECT", "WORLD"),
):
    shown(
        f"Vector Transform {_kind} {_from} to {_to}",
        lambda t, k=_kind, f=_from, o=_to: t.made(
            "ShaderNodeVectorMath",
            0,
            {
                0: t.made(
                    "ShaderNodeVectorTransform",
                    0,
                    {0: t.coordinates()},
                    vector_type=k,
                    convert_from=f,
                    convert_to=o,
                )
            },
            operation="ABSOLUTE",
        ),
    )
shown("UV Map", lambda t: t.made("ShaderNodeUVMap", 0, uv_map="UVMap"))
for _output in ("Color", "Alpha"):
    shown(
        f"Color Attribute {_output}",
        lambda t, o=_output: t.made("ShaderNodeVertexColor", o, layer_name="Col"),
    )
for _output in ("Color", "Vector", "Fac", "Alpha"):
    shown(
        f"Attribute {_output}",
        lambda t, o=_output: t.made("ShaderNodeAttribute", o, attribute_name="Col"),
    )
shown(
    "Attribute, a UV map", lambda t: t.made("ShaderNodeAttribute", "Vector", attribute_name="UVMap")
)
shown(
    "Attribute that is not there",
    lambda t: t.made("ShaderNodeAttribute", "Color", attribute_name="no"),
)
shown("Fresnel", lambda t: t.made("ShaderNodeFresnel", 0, {0: 1.6}))
for _output in ("Fresnel", "Facing"):
    for _amount in (0.3, 0.5, 0.8):
        shown(
            f"Layer Weight {_output} {_amount}",
            lambda t, o=_output, a=_amount: t.made("ShaderNodeLayerWeight", o, {0: a}),
        )
# A colour that is no unit vector, as filtered or painted maps have it.
for _space in ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"):
    for _strength in (1.0, 0.4, 2.0):
        shown(
            f"Normal Map {_space}, strength {_strength:g}",
            lambda t, space=_space, strength=_strength: t.made(
                "ShaderNodeVectorMath",
                0,
                {
                    0: t.made(
                        "ShaderNodeNormalMap",
                        0,
                        {"Color": (0.7, 0.4, 0.65), "Strength": strength},
                        space=space,
                    )
                },
                operation="ABSOLUTE",
            ),
        )
shown("Normal", lambda t: t.made("ShaderNodeNormal", "Dot", {0: t.coordinates("Normal")}))

"""Where a direction is, in a world: Texture Coordinate, Geometry, Light Path, Camera Data, ...

A handler is as in program_nodes.py; what Cycles answers in a world was measured in 4.5 and 5.2.
"""

from __future__ import annotations

import numpy as np

from ....core.data.program import Op, Ref
from ....core.scene import PERSPECTIVE
from ..cameras.camera import export_camera
from ..errors import ExportError
from ..objects.object_properties import outputs_of
from .world_mapping import camera_turn

_NONE = np.zeros(3, np.float32)
# Light Path as measured in Cycles: what is not named is 0. A camera ray is at depth 1; light is
# what a diffuse surface finds, one bounce further.
CAMERA_RAYS = {"Is Camera Ray": 1.0, "Ray Depth": 1.0, "Ray Length": np.finfo(np.float32).max}
LIGHT_RAYS = {
    "Is Diffuse Ray": 1.0,
    "Is Reflection Ray": 1.0,
    "Ray Depth": 2.0,
    "Diffuse Depth": 1.0,
    "Ray Length": np.finfo(np.float32).max,
}
# Outputs that are not the same for all light, neither here nor in Cycles.
_NOT_OF_ALL_LIGHT = (
    "Is Diffuse Ray",
    "Is Glossy Ray",
    "Is Reflection Ray",
    "Ray Depth",
    "Diffuse Depth",
    "Glossy Depth",
)


def constants(node, values):
    """Outputs by identifier, three equal numbers where they are no number."""
    outputs = {}
    for socket in node.outputs:
        value = np.float32(values.get(socket.identifier, 0.0))
        outputs[socket.identifier] = value if socket.type == "VALUE" else np.repeat(value, 3)
    return outputs


def _attribute(builder, node, groups):
    """Of a view layer, a scene and its world; there is no mesh and no object."""
    if node.attribute_type == "VIEW_LAYER":
        return outputs_of(builder.layer, node.attribute_name)
    return constants(node, {"Alpha": 1.0})


def _light_path(builder, node, groups):
    builder.asks_for_rays = True
    if builder.rays is LIGHT_RAYS:
        for socket in node.outputs:
            if socket.is_linked and socket.identifier in _NOT_OF_ALL_LIGHT:
                value = builder.rays.get(socket.identifier, 0.0)
                builder.reader.warn(
                    node,
                    f"{socket.name} is {value:g} for all light, as for that on diffuse surfaces",
                )
    return constants(node, builder.rays)


def _texture_coordinate(builder, node, groups):
    here = builder.direction()
    place = here
    if node.object is not None:
        place = builder.transformed(here, np.array(node.object.matrix_world.inverted_safe())[:3])
    made = {"Generated": here, "Object": place, "UV": _NONE}
    made |= {name: builder.direction("Normal") for name in ("Normal", "Reflection")}
    seen = here
    if builder.camera is not None:
        turn = camera_turn(builder.camera)
        seen = builder.transformed(here, np.column_stack([turn, np.zeros(3)]))
    made["Camera"], made["Window"] = seen, here
    if node.outputs["UV"].is_linked:
        builder.reader.warn(node, "a world has no UV map: (0, 0, 0), as in Cycles; use Generated")
    if node.outputs["Camera"].is_linked and builder.camera is None:
        builder.reader.warn(node, "Camera without a camera: Generated is used")
    if node.outputs["Window"].is_linked:
        made["Window"] = _window(builder, node, seen)
    return made


def _window(builder, node, seen):
    """Where a direction lies in the scene camera's frame."""
    try:
        camera = export_camera(builder.depsgraph, [])
    except (ExportError, AttributeError):
        camera = None
    if camera is None or camera.kind != PERSPECTIVE:
        text = "Window needs a perspective camera in the scene: Generated is used"
        builder.reader.warn(node, text)
        return builder.direction()
    settings = {"window": tuple(map(float, camera.window))}
    return builder.run("world_window", Vector=seen, settings=settings)


def _geometry(builder, node, groups):
    back = builder.direction("Normal")
    made = constants(node, {})
    made |= {"Position": builder.direction(), "Parametric": np.float32([1.0, 0.0, 0.0])}
    made |= {name: back for name in ("Normal", "True Normal", "Incoming")}
    if node.outputs["Tangent"].is_linked:
        builder.reader.warn(node, "Tangent is not supported in a world: (0, 0, 0)")
    return made


def _camera_data(builder, node, groups):
    """Cycles takes the direction for a place."""
    if builder.camera is None:
        return constants(node, {})
    turn = camera_turn(builder.camera)
    matrix = np.column_stack([turn, -turn @ np.array(builder.camera.matrix_world.translation)])
    place = builder.transformed(builder.direction(), matrix)
    row = builder.add(Op("world_camera_data", {"Vector": place}, {}))
    return {socket.identifier: Ref(row, socket.identifier) for socket in node.outputs}


def _vector_transform(builder, node, groups):
    """Object space is world space."""
    vector = builder.behind(node.inputs[0], groups, "VECTOR")
    spaces = node.convert_from == "CAMERA", node.convert_to == "CAMERA"
    if builder.camera is not None and spaces[0] != spaces[1]:
        turn, move = camera_turn(builder.camera), np.zeros(3)
        if node.vector_type == "POINT":
            move = -turn @ np.array(builder.camera.matrix_world.translation)
        if spaces[0]:
            turn, move = turn.T, -turn.T @ move
        vector = builder.transformed(vector, np.column_stack([turn, move]))
        if node.vector_type == "NORMAL":
            way = {"operation": "NORMALIZE"}
            vector = builder.run("ShaderNodeVectorMath", "Vector", Vector=vector, settings=way)
    return {node.outputs[0].identifier: vector}


HANDLERS = {
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeLightPath": _light_path,
    "ShaderNodeTexCoord": _texture_coordinate,
    "ShaderNodeNewGeometry": _geometry,
    "ShaderNodeCameraData": _camera_data,
    "ShaderNodeVectorTransform": _vector_transform,
}

"""Nodes that tell where a point is and what it belongs to: coordinates, attributes, geometry, rays.

A function takes the context, the node's settings and its inputs (program.Op), and returns its
outputs by name. Each reproduces the Cycles node of its name.
"""

from __future__ import annotations

import numpy as np

from ..camera.panorama_places import panorama_places, space_axes
from .element_info import element_number
from .values import column, divided, dot, length, normalized, parts, vector

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
# Columns of an attribute -> the one that is its Fac, which else is the mean.
_FACTOR_OF = {1: 0, 2: 0, 5: 4}


def _window(context):
    x, y, z = parts(context.camera_position)
    if context.camera.kind == "PANORAMIC":
        seen = normalized(context.camera_position) @ space_axes(context.camera)[:3, :3].T
        places = panorama_places(context.camera.panorama, seen)
        return vector(places[:, 0], places[:, 1], 0.0 * x)
    left, right, bottom, top = context.camera.window
    scale = np.where(z != 0.0, z, 1.0) if context.camera.kind != "ORTHOGRAPHIC" else 1.0
    return vector(
        (x / scale - left) / (right - left), (y / scale - bottom) / (top - bottom), 0.0 * x
    )


def _of_object(context, settings):
    matrix = settings.get("world_to_object")
    if matrix is None:
        return context.object_position
    return (context.position @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


_COORDINATES = {
    "Generated": lambda c, s: c.generated,
    "Normal": lambda c, s: c.normal_to_object(c.normal),
    "UV": lambda c, s: c.uv(),
    "Object": _of_object,
    "Camera": lambda c, s: c.camera_position,
    "Window": lambda c, s: _window(c),
    "Reflection": lambda c, s: 2.0 * column(dot(c.normal, c.wo)) * c.normal - c.wo,
}


def texture_coordinate(context, settings, inputs):
    """settings: outputs, those that are used; world_to_object float32 (4, 4), of another object;
    from_instancer, whether Generated and UV are an instance's places on what made it"""
    made = {"Generated", "UV"} if settings.get("from_instancer") else set()
    return {
        name: context.of_object(f"origin:{name}")[:, :3]
        if name in made
        else _COORDINATES[name](context, settings)
        for name in settings["outputs"]
    }


def uv_map(context, settings, inputs):
    return {"UV": context.uv(settings["uv_map"])}


def attribute(context, settings, inputs):
    """settings: table, the name of the values: numbers, vectors of two or three, colors with alpha,
    or, where meshes have different ones, colors with alpha and Fac"""
    value = context.attribute(settings["table"])
    if value is None:  # there is none of that name: black, but opaque, as in Cycles
        value = np.zeros((len(context), 3), np.float32)
    width = value.shape[-1]
    alpha = value[..., 3] if width >= 4 else _ONE
    if width == 1:
        color = np.repeat(value, 3, -1)
    elif width == 2:
        color = np.concatenate([value, np.zeros_like(value[..., :1])], -1)
    else:
        color = value[..., :3]
    factor = value[..., _FACTOR_OF[width]] if width in _FACTOR_OF else color.mean(-1)
    return {"Color": color, "Vector": color, "Fac": factor, "Alpha": alpha}


def object_attribute(context, settings, inputs):
    """The object's own value. settings: table, its name among SurfaceData.object_tables"""
    value = context.of_object(settings["table"])
    color = value[:, :3]
    return {"Color": color, "Vector": color, "Fac": color.mean(-1), "Alpha": value[:, 3]}


def mapping(context, settings, inputs):
    location = inputs.get("Location", np.zeros(3, np.float32))
    scale, p = inputs["Scale"], inputs["Vector"]
    rotate = _rotation(inputs["Rotation"])
    kind = settings["vector_type"]
    if kind == "TEXTURE":
        value = divided(rotate(p - location, True), scale)
    elif kind == "NORMAL":
        value = normalized(rotate(divided(p, scale), False))
    else:
        value = rotate(p * scale, False)
        value = value + location if kind == "POINT" else value
    return {"Vector": value}


def _rotation(angles):
    """A function of (vectors, whether to turn back): Euler angles about x, then y, then z."""
    sines, cosines = np.sin(angles), np.cos(angles)

    def about(vectors, axis, back):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        s, c = sines[..., axis], cosines[..., axis]
        s = -s if back else s
        values = list(parts(vectors))
        values[i], values[j] = c * values[i] - s * values[j], s * values[i] + c * values[j]
        return vector(*values)

    def rotate(vectors, back):
        for axis in (2, 1, 0) if back else (0, 1, 2):
            vectors = about(vectors, axis, back)
        return vectors

    return rotate


def vector_rotate(context, settings, inputs):
    kind, v, center = settings["rotation_type"], inputs["Vector"], inputs["Center"]
    if kind == "EULER_XYZ":
        turned = _rotation(inputs["Rotation"])(v - center, settings["invert"]) + center
        return {"Vector": turned}
    angle = -inputs["Angle"] if settings["invert"] else inputs["Angle"]
    axis = {"X_AXIS": (1, 0, 0), "Y_AXIS": (0, 1, 0), "Z_AXIS": (0, 0, 1)}.get(kind)
    axis = inputs["Axis"] if axis is None else np.float32(axis)
    size = length(axis)
    k, s, c = normalized(axis), column(np.sin(angle)), column(np.cos(angle))
    d = v - center
    turned = d * c + np.cross(k, d) * s + k * column(dot(k, d)) * (1.0 - c) + center
    return {"Vector": np.where(column(size) != 0.0, turned, v)}


def vector_transform(context, settings, inputs):
    """settings: vector_type, convert_from, convert_to; world to camera is a matrix of the camera

    What stays where it is stays as it is, normals of any length too.
    """
    kind, v = settings["vector_type"], inputs["Vector"]
    source, target = settings["convert_from"], settings["convert_to"]
    if source == target:
        return {"Vector": v}
    to_world, from_world = _space_matrix(context, source), _space_matrix(context, target)
    matrix = np.linalg.inv(from_world) @ to_world
    if kind == "NORMAL":
        turned = np.einsum("...ji,...j->...i", np.linalg.inv(matrix)[..., :3, :3], v)
        return {"Vector": normalized(turned.astype(np.float32))}
    turned = np.einsum("...ij,...j->...i", matrix[..., :3, :3], v)
    if kind == "POINT":
        turned = turned + matrix[..., :3, 3]
    return {"Vector": turned.astype(np.float32)}


def _space_matrix(context, space):
    if space == "WORLD":
        return np.eye(4)
    if space == "CAMERA":
        return context.camera.camera_to_world @ space_axes(context.camera)
    return context.surface.object_to_world[context.object]


def geometry(context, settings, inputs):
    """settings: outputs, those that are used"""
    values = {
        "Position": lambda: context.position,
        "Normal": lambda: context.normal,
        "True Normal": lambda: context.geometric_normal,
        "Incoming": lambda: context.wo,
        "Backfacing": lambda: context.backfacing,
        "Parametric": lambda: context.parametric,
        "Tangent": lambda: _default_tangent(context),
        "Pointiness": lambda: element_number(context, "Pointiness"),
        "Random Per Island": lambda: element_number(context, "Random Per Island"),
    }
    return {name: values[name]() for name in settings["outputs"]}


def _default_tangent(context):
    return _laid_down(context, _around(context, "Z"))


def _around(context, axis):
    """Around an axis of the object, in the middle of its generated coordinates."""
    x, y, z = parts(context.generated - np.float32(0.5))
    zero = 0.0 * x
    return {
        "X": lambda: vector(zero, -z, y),
        "Y": lambda: vector(-z, zero, x),
        "Z": lambda: vector(-y, x, zero),
    }[axis]()


def _laid_down(context, direction):
    """A direction of object space in world space, at right angles to the normal."""
    across = normalized(np.cross(context.normal_to_world(direction), context.normal))
    return np.cross(context.normal, across)


def tangent(context, settings, inputs):
    """settings: axis to go around, or table (name of the tangents at the corners)"""
    if "axis" in settings:
        return {"Tangent": _laid_down(context, _around(context, settings["axis"]))}
    table = context.attribute(settings["table"])
    if table is None:
        return {"Tangent": np.zeros((len(context), 3), np.float32)}
    return {"Tangent": _laid_down(context, table[:, :3])}


def object_info(context, settings, inputs):
    surface, rows = context.surface, context.object
    values = {
        "Location": lambda: surface.object_to_world[rows][:, :3, 3].astype(np.float32),
        "Color": lambda: surface.color[rows, :3],
        "Alpha": lambda: surface.color[rows, 3],
        "Object Index": lambda: surface.pass_index[rows],
        "Material Index": lambda: context.material_index,
        "Random": lambda: surface.random[rows],
    }
    return {name: values[name]() for name in settings["outputs"]}


def camera_data(context, settings, inputs):
    position = context.camera_position
    return {
        "View Vector": normalized(position),
        "View Z Depth": np.abs(position[:, 2]),
        "View Distance": length(position),
    }


def light_path(context, settings, inputs):
    """Camera rays, shadow rays, and what asks for light that reaches other surfaces."""
    camera, shadow = np.float32(context.camera_ray), np.float32(context.shadow)
    values = {"Is Camera Ray": camera, "Is Shadow Ray": shadow}
    values["Ray Length"] = context.ray_length
    values["Transparent Depth"] = context.transparent_depth
    return {name: values.get(name, _ZERO) for name in settings["outputs"]}


FUNCTIONS = {
    "ShaderNodeTexCoord": texture_coordinate,
    "ShaderNodeUVMap": uv_map,
    "attribute": attribute,
    "object_attribute": object_attribute,
    "ShaderNodeMapping": mapping,
    "ShaderNodeVectorRotate": vector_rotate,
    "ShaderNodeVectorTransform": vector_transform,
    "ShaderNodeNewGeometry": geometry,
    "ShaderNodeTangent": tangent,
    "ShaderNodeObjectInfo": object_info,
    "ShaderNodeCameraData": camera_data,
    "ShaderNodeLightPath": light_path,
}

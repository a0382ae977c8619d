"""Vector nodes of a world to one matrix: world direction -> where the map is looked up.

Cycles' Mapping node, with R = R_z R_y R_x of its Euler angles, S its scale, t its location:
    POINT R S v + t     TEXTURE S^-1 R^T (v - t)     VECTOR R S v     NORMAL R S^-1 v, normalised
A scale of 0 divides to 0. As measured in Cycles, Generated, Object (without an object) and Position
are the direction; Normal, Reflection and Incoming are its negative; UV is 0; a Mapping node whose
vector is not linked maps its constant, so that the whole world has one colour.
"""

from __future__ import annotations

import numpy as np
from mathutils import Euler

from ..shaders.node_values import follow

_SAME = np.eye(3, 4)
_OPPOSITE = -np.eye(3, 4)
_ZERO = np.zeros(3)
_TEXTURE_COORDINATE = {"Generated": _SAME, "Normal": _OPPOSITE, "Reflection": _OPPOSITE}
_GEOMETRY = {
    "Position": _SAME,
    "Normal": _OPPOSITE,
    "True Normal": _OPPOSITE,
    "Incoming": _OPPOSITE,
}
# Column of a coordinate in the deprecated "texture mapping" that every texture node still has.
_AXES = {"NONE": None, "X": 0, "Y": 1, "Z": 2}


class NotAMatrix(Exception):
    """The vector is no linear function of the direction."""


def lookup_matrix(texture, groups, color, camera, warn) -> np.ndarray:
    """float64 (3, 4): what the vector at the texture node's input is, as a matrix of (d, 1).

    groups: the group nodes the texture node lies in; camera: the scene's camera object or None
    color(socket, groups): constant colour or vector behind a socket, float (3,), or NotAMatrix
    warn(node, text): takes what is not supported
    Raises NotAMatrix.
    """
    matrix = _matrix(texture.inputs["Vector"], groups, _SAME, (color, camera, warn))
    return _compose(own_matrix(texture, warn), matrix)


def mapping_matrix(kind, location, rotation, scale) -> np.ndarray:
    """float64 (3, 4) of a Mapping node: kind, and its three inputs of three numbers each."""
    turn = np.array(Euler(rotation).to_matrix())
    size = np.array(scale, float)
    inverse_size = np.divide(1.0, size, out=np.zeros(3), where=size != 0.0)
    move = np.array(location, float)
    if kind == "TEXTURE":
        linear = np.diag(inverse_size) @ turn.T
        move = -linear @ move
    elif kind == "NORMAL":
        linear, move = turn @ np.diag(inverse_size), np.zeros(3)
    else:
        linear = turn @ np.diag(size)
        move = move if kind == "POINT" else np.zeros(3)
    return np.column_stack([linear, move])


def _matrix(socket, groups, unlinked, context):
    """Matrix of the vector behind an input; ``unlinked``: what it is without a link, or None."""
    color, camera, warn = context
    end = follow(socket, groups)
    if end.node is None:
        if unlinked is not None and end.socket == socket:
            return unlinked
        return _constant(end.socket.default_value)
    node, output = end.node, end.socket
    if node.bl_idname == "ShaderNodeMapping":
        vector = _matrix(node.inputs["Vector"], end.groups, None, context)
        # Types VECTOR and NORMAL have no Location.
        sockets = (node.inputs.get(name) for name in ("Location", "Rotation", "Scale"))
        values = [_ZERO if s is None else color(s, end.groups) for s in sockets]
        if values[0].any() and _is_after_normal(node, end.groups):
            raise NotAMatrix
        return _compose(mapping_matrix(node.vector_type, *values), vector)
    if node.bl_idname == "ShaderNodeTexCoord":
        return _texture_coordinate(node, output.name, camera, warn)
    if node.bl_idname == "ShaderNodeNewGeometry" and output.name in _GEOMETRY:
        return _GEOMETRY[output.name]
    return _constant(color(socket, groups))


def _texture_coordinate(node, output, camera, warn):
    if output == "UV":
        warn(node, "a world has no UV map: one colour everywhere, as in Cycles; use Generated")
        return np.zeros((3, 4))
    if output == "Object":
        if node.object is None:
            return _SAME
        return np.array(node.object.matrix_world.inverted_safe())[:3]
    if output == "Camera" and camera is not None:
        return np.column_stack([camera_turn(camera), np.zeros(3)])
    if output not in _TEXTURE_COORDINATE:
        raise NotAMatrix
    return _TEXTURE_COORDINATE[output]


def camera_turn(camera) -> np.ndarray:
    """float64 (3, 3): world vectors to a camera object's right, up and ahead."""
    return np.diag([1.0, 1.0, -1.0]) @ np.array(camera.matrix_world.to_3x3().normalized()).T


def _is_after_normal(node, groups):
    end = follow(node.inputs["Vector"], groups)
    if end.node is None or end.node.bl_idname != "ShaderNodeMapping":
        return False
    return end.node.vector_type == "NORMAL" or _is_after_normal(end.node, end.groups)


def own_matrix(node, warn) -> np.ndarray:
    """float64 (3, 4) of a texture node's own mapping, of files from before 2.8 and of scripts."""
    mapping = node.texture_mapping
    axes = np.zeros((3, 3))
    for row, axis in enumerate((mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)):
        if axis != "NONE":
            axes[row, _AXES[axis]] = 1.0
    if mapping.use_min or mapping.use_max:
        warn(node, "minimum and maximum of the texture mapping are ignored")
    matrix = mapping_matrix(
        mapping.vector_type, mapping.translation, mapping.rotation, mapping.scale
    )
    return _compose(matrix, np.column_stack([axes, np.zeros(3)]))


def _constant(value):
    vector = np.array(value[:3] if hasattr(value, "__len__") else [value] * 3, float)
    return np.column_stack([np.zeros((3, 3)), vector])


def _compose(outer, inner):
    """outer after inner, both float (3, 4)."""
    return outer @ np.vstack([inner, [0.0, 0.0, 0.0, 1.0]])

"""Ways for objects to move, and to change their shape, over frames 0, 1 and 2."""

from __future__ import annotations

import bpy
import numpy as np

from .element_cases import add_nodes
from .view_cases import linear


def keyed(owner, path, values):
    """A property at frames 0, 1 and 2, straight between them."""
    for frame, value in enumerate(values):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)


def by_keys(obj, size=0.8):
    """A shape key that pulls each vertex along x by its height, and up."""
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Bent")
    for point in key.data:
        x, y, z = point.co
        point.co = (x + size * z * z, y + 0.3 * size * x, z + 0.4 * size * x)
    keyed(key, "value", (0.0, 0.5, 1.0))
    linear(obj.data.shape_keys)


def by_armature(obj):
    """Two bones, of which the upper one turns."""
    bones = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
    bpy.context.scene.collection.objects.link(bones)
    bones.location = obj.location
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    lower = bones.data.edit_bones.new("Lower")
    lower.head, lower.tail = (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)
    upper = bones.data.edit_bones.new("Upper")
    upper.head, upper.tail, upper.parent = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, sign in (("Lower", -1.0), ("Upper", 1.0)):
        group = obj.vertex_groups.new(name=name)
        for vertex in obj.data.vertices:
            group.add([vertex.index], min(max(0.5 + sign * vertex.co.z, 0.0), 1.0), "REPLACE")
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = bones
    bone = bones.pose.bones["Upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in enumerate((-0.9, 0.0, 0.9)):
        bone.rotation_euler = (0.0, 0.0, angle) if frame == 1 else (0.3 * angle, 0.0, angle)
        bone.keyframe_insert("rotation_euler", frame=frame)
    linear(bones)


def by_wave(obj):
    """Ripples that run over a fine plane."""
    modifier = obj.modifiers.new("Wave", "WAVE")
    modifier.height, modifier.width, modifier.narrowness = 0.5, 1.2, 1.5
    modifier.time_offset, modifier.speed = -40.0, 0.4
    modifier.use_normal = False


def lean(obj):
    """Geometry nodes that move what they get along x, by the frame after the first and height."""

    def build(nodes, link, start, end):
        time, position = (
            nodes.new(f"GeometryNodeInput{name}") for name in ("SceneTime", "Position")
        )
        since, by, scaled = (nodes.new("ShaderNodeMath") for _ in range(3))
        since.operation, since.inputs[1].default_value = "SUBTRACT", 1.0
        by.operation, scaled.operation, scaled.inputs[1].default_value = (*["MULTIPLY"] * 2, 0.6)
        parts, offset = nodes.new("ShaderNodeSeparateXYZ"), nodes.new("ShaderNodeCombineXYZ")
        move = nodes.new("GeometryNodeSetPosition")
        link(time.outputs["Frame"], since.inputs[0])
        link(position.outputs[0], parts.inputs[0])
        link(since.outputs[0], by.inputs[0])
        link(parts.outputs["Z"], by.inputs[1])
        link(by.outputs[0], scaled.inputs[0])
        link(scaled.outputs[0], offset.inputs["X"])
        link(start, move.inputs["Geometry"])
        link(offset.outputs[0], move.inputs["Offset"])
        link(move.outputs[0], end)

    add_nodes(obj, build)


def with_velocity(obj, size=40.0):
    """Say that each vertex goes along x by its height, metres a second."""
    mesh = obj.data
    places = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", places.reshape(-1))
    velocities = np.zeros_like(places)
    velocities[:, 0] = size * places[:, 2]
    attribute = mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", velocities.reshape(-1))


def make_cylinder(obj):
    """Give the cube the mesh of a fine cylinder."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.5, depth=2.0, end_fill_type="NOTHING")
    made = bpy.context.object
    mesh = made.data
    bpy.data.objects.remove(made)
    mesh.materials.append(obj.data.materials[0])
    obj.data, obj.rotation_euler, obj.scale = mesh, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    cut(obj, 12)
    mesh.shade_smooth()


def cut(obj, times):
    """Cut all edges of a mesh so many times."""
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=times)
    bpy.ops.object.mode_set(mode="OBJECT")


def move_and_turn(obj):
    """Along, and about z."""
    place = obj.location.copy()
    steps = [place + type(place)((0.5 * t, 0.2 * t, 0.2 * t)) for t in (-1.0, 0.0, 1.0)]
    keyed(obj, "location", steps)
    keyed(obj, "rotation_euler", [(0.0, 0.0, 0.7 * t) for t in (-1.0, 0.0, 1.0)])
    linear(obj)

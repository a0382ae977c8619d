"""Random objects: meshes, text, curves, metaballs with modifiers, and instances of them."""

from __future__ import annotations

import bpy
import numpy as np

from .attributes import NAME, add_attributes
from .dice import Dice

_PRIMITIVES = {
    "cube": lambda: bpy.ops.mesh.primitive_cube_add(size=1.2),
    "sphere": lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.8),
    "icosphere": lambda: bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.8),
    "torus": lambda: bpy.ops.mesh.primitive_torus_add(major_segments=20, minor_segments=8),
    "cone": lambda: bpy.ops.mesh.primitive_cone_add(vertices=12, radius1=0.7, depth=1.4),
    "monkey": lambda: bpy.ops.mesh.primitive_monkey_add(size=1.3),
    "plane": lambda: bpy.ops.mesh.primitive_plane_add(size=1.6),
    "text": lambda: bpy.ops.object.text_add(),
    "curve": lambda: bpy.ops.curve.primitive_bezier_circle_add(radius=0.7),
    "ball": lambda: bpy.ops.object.metaball_add(radius=0.9),
}
# A mirrored ball lies in itself: which of two faces in one place is met is anyone's guess.
_MODIFIERS = {
    "SUBSURF": {"levels": 1, "render_levels": 1},
    "BEVEL": {"width": 0.1, "segments": 2},
    "ARRAY": {"count": 2},
    "SOLIDIFY": {"thickness": 0.1},
    "WIREFRAME": {"thickness": 0.1},
    "SIMPLE_DEFORM": {"angle": 0.8},
    "EDGE_SPLIT": {"split_angle": 0.6},
    "WEIGHTED_NORMAL": {},
    "DECIMATE": {"ratio": 0.6},
    "CAST": {"factor": 0.5},
    "DISPLACE": {"strength": 0.15},
    "SMOOTH": {"factor": 0.7, "iterations": 2},
    "TRIANGULATE": {},
}


def add_object(dice: Dice, materials: list):
    """One new object somewhere round the middle of the scene."""
    kind = dice.of(*_PRIMITIVES)
    dice.tell(kind)
    _PRIMITIVES[kind]()
    obj = bpy.context.object
    if kind == "text":
        obj.data.body, obj.data.extrude, obj.data.align_x = "Wg", 0.1, "CENTER"
    if kind == "curve":
        obj.data.bevel_depth = 0.15
    obj.location = (dice.between(-1.8, 1.8), dice.between(-1.0, 1.5), dice.between(-0.6, 1.0))
    obj.rotation_euler = dice.vector(-3.0, 3.0)
    scale = dice.spread(0.5, 1.1)
    obj.scale = dice.vector(0.5, 1.1) if dice.chance(0.3) else (scale,) * 3
    if dice.chance(0.15):
        obj.scale.x *= -1.0
    for material in materials:
        obj.data.materials.append(material)
    if obj.type == "MESH":
        _shaped(dice, obj, len(materials))
    _looks(dice, obj)
    return obj


def _looks(dice, obj):
    obj.color, obj.pass_index = (*dice.color(), 1.0), dice.whole(0, 5)


def _shaped(dice, obj, n_materials):
    """Smooth or flat, colours, slots by face, modifiers."""
    mesh = obj.data
    mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), dice.chance(0.5)))
    slots = np.arange(len(mesh.polygons)) % n_materials
    mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
    _own_normals(dice, mesh)
    add_attributes(dice, mesh)
    colors = mesh.color_attributes.new("Col", "FLOAT_COLOR", dice.of("CORNER", "POINT"))
    n = len(colors.data)
    values = np.stack([np.arange(n) % k / k for k in (3, 5, 7)] + [np.ones(n)], -1)
    colors.data.foreach_set("color", values.astype(np.float32).ravel())
    if dice.chance(0.2):
        _keyed(dice, obj)
    for kind in {dice.of(*_MODIFIERS): 0 for _ in range(dice.of(0, 0, 1, 2))}:
        dice.tell(kind.lower())
        modifier = obj.modifiers.new(kind, kind)
        for name, value in _MODIFIERS[kind].items():
            setattr(modifier, name, value)


def _keyed(dice, obj):
    """A shape between two: what is generated stays where the first one has it."""
    dice.tell("shape key")
    obj.shape_key_add(name="Basis", from_mix=False)
    other, way = obj.shape_key_add(name="Other", from_mix=False), dice.vector(-0.4, 0.4)
    places = np.empty((len(other.data), 3), np.float32)
    other.data.foreach_get("co", places.ravel())
    places += np.float32(way) * np.sin(3.0 * places[:, ::-1])
    other.data.foreach_set("co", places.ravel())
    other.value = dice.between(0.2, 1.0)


def _own_normals(dice, mesh):
    """Sharp edges, or normals that someone has set."""
    kind = dice.of("none", "none", "none", "sharp edges", "custom normals")
    if kind == "sharp edges":
        mesh.set_sharp_from_angle(angle=dice.between(0.2, 1.2))
    if kind == "custom normals":
        normals = np.empty((len(mesh.loops), 3), np.float32)
        mesh.corner_normals.foreach_get("vector", normals.ravel())
        normals += [dice.vector(-0.25, 0.25) for _ in range(len(normals))]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        mesh.normals_split_custom_set(normals.tolist())
    if kind != "none":
        dice.tell(kind)


def add_floor(dice: Dice, material) -> None:
    """A square under all."""
    bpy.ops.mesh.primitive_plane_add(size=9.0, location=(0.0, 0.5, -1.2))
    bpy.context.object.data.materials.append(material)
    _looks(dice, bpy.context.object)


def add_copies(dice: Dice, obj) -> None:
    """Instances of an object: by a collection, vertices, faces or particles."""
    kind = dice.of("collection", "VERTS", "FACES", "particles", "nodes")
    dice.tell(f"instances {kind}")
    scene = bpy.context.scene
    if kind == "collection":
        group = bpy.data.collections.new("Group")
        group.objects.link(obj)
        for _ in range(dice.whole(1, 3)):
            empty = bpy.data.objects.new("Copy", None)
            empty.instance_type, empty.instance_collection = "COLLECTION", group
            empty.location, empty.scale = dice.vector(-1.0, 1.0), dice.vector(0.4, 1.2)
            if dice.chance(0.3):
                empty.scale.y *= -1.0
            empty.rotation_euler = dice.vector(-1.0, 1.0)
            _looks(dice, empty)
            scene.collection.objects.link(empty)
        if dice.chance(0.4):
            _nest(dice, empty)
        return
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=0.9, location=obj.location)
    parent = bpy.context.object
    parent.data.materials.append(obj.data.materials[0])
    _looks(dice, parent)
    if kind == "nodes":
        _instance_nodes(dice, parent, obj)
    elif kind == "particles":
        settings = parent.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count, settings.hair_length = "HAIR", 12, 0.3
        settings.render_type, settings.instance_object = "OBJECT", obj
        settings.particle_size = 0.5
    else:
        obj.parent, parent.instance_type = parent, kind
        obj.location, obj.scale = (0.0, 0.0, 0.0), (0.2, 0.2, 0.2)


def _nest(dice: Dice, inner) -> None:
    """Put an empty that shows a collection into one that another empty shows."""
    dice.tell("nested")
    group = bpy.data.collections.new("Outer")
    group.objects.link(inner)
    outer = bpy.data.objects.new("Nest", None)
    outer.instance_type, outer.instance_collection = "COLLECTION", group
    outer.location, outer.scale = dice.vector(-0.8, 0.8), dice.vector(0.5, 1.2)
    outer.rotation_euler = dice.vector(-1.0, 1.0)
    _looks(dice, outer)
    bpy.context.scene.collection.objects.link(outer)


def _instance_nodes(dice: Dice, parent, obj) -> None:
    """Geometry nodes that put an object on the parent's points, turned, of several sizes."""
    group = bpy.data.node_groups.new("Copies", "GeometryNodeTree")
    for name, way in (("In", "INPUT"), ("Out", "OUTPUT")):
        group.interface.new_socket(name, in_out=way, socket_type="NodeSocketGeometry")
    kinds = (
        "NodeGroupInput GeometryNodeObjectInfo GeometryNodeInstanceOnPoints FunctionNodeRandomValue"
    )
    kinds += " GeometryNodeStoreNamedAttribute NodeGroupOutput FunctionNodeRandomValue"
    given, info, copies, size, stored, out, turn = map(group.nodes.new, kinds.split())
    info.inputs["Object"].default_value = obj
    size.data_type = turn.data_type = "FLOAT_VECTOR"
    low = -0.3 if dice.chance(0.3) else 0.1
    size.inputs["Min"].default_value, size.inputs["Max"].default_value = (low,) * 3, (0.4,) * 3
    turn.inputs["Max"].default_value = (6.0, 6.0, 6.0)
    stored.domain = "INSTANCE"
    stored.data_type = dice.of("FLOAT_COLOR", "FLOAT_VECTOR", "FLOAT", "INT", "BOOLEAN")
    stored.inputs["Name"].default_value = NAME
    info.inputs["As Instance"].default_value = dice.chance(0.4)
    last = group.nodes.new("GeometryNodeRealizeInstances") if dice.chance(0.2) else stored
    value = next(s for s in stored.inputs if s.name == "Value" and s.enabled)
    if stored.data_type == "FLOAT_COLOR":
        value.default_value = (*dice.color(), 1.0)
    elif stored.data_type != "BOOLEAN":
        group.links.new(group.nodes.new("GeometryNodeInputIndex").outputs[0], value)
    dice.tell(f"{stored.data_type.lower()} of {'all' if last is not stored else 'instances'}")
    for source, target in (
        (given.outputs[0], copies.inputs["Points"]),
        (info.outputs["Geometry"], copies.inputs["Instance"]),
        (size.outputs[0], copies.inputs["Scale"]),
        (turn.outputs[0], copies.inputs["Rotation"]),
        (copies.outputs[0], stored.inputs[0]),
        (last.outputs[0], out.inputs[0]),
    ):
        group.links.new(source, target)
    if last is not stored:
        group.links.new(stored.outputs[0], last.inputs[0])
    parent.modifiers.new("Copies", "NODES").node_group = group

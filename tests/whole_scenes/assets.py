"""What Blender's bundled asset files hold: node groups on suitable objects; its HDR pictures."""

from __future__ import annotations

from pathlib import Path

import bpy
from parity.element_cases import add_nodes
from parity.scene import Tree

from .stage import Whole, add_hair, add_surface, stage

_PROFILE = "Set Hair Curve Profile"


def _folder(*parts) -> Path:
    return Path(bpy.utils.system_resource("DATAFILES"), *parts)


def files() -> list[Path]:
    """Of all asset files but brushes, which make no scene."""
    return [p for p in sorted(_folder("assets").rglob("*.blend")) if "brushes" not in p.parts]


def _groups(path: Path) -> list[str]:
    with bpy.data.libraries.load(str(path), assets_only=True) as (source, _):
        return list(source.node_groups)


def _load(path: Path, name: str):
    with bpy.data.libraries.load(str(path), assets_only=True) as (_, wanted):
        wanted.node_groups = [name]
    return wanted.node_groups[0]


def _sockets(group, direction, kind=None):
    return [
        item
        for item in group.interface.items_tree
        if item.item_type == "SOCKET"
        and item.in_out == direction
        and (kind is None or item.socket_type == kind)
    ]


def _is_geometry(group) -> bool:
    return all(_sockets(group, d, "NodeSocketGeometry") for d in ("INPUT", "OUTPUT"))


def _suitable(path: Path, name: str, material):
    """An object for a group, and the objects that its inputs may name: (object, others)."""
    if "hair" in path.name or "Hair" in name:
        hair, surface = add_hair(material)
        return hair, surface
    if name.startswith("Curve"):
        bpy.ops.curve.primitive_bezier_curve_add()
        bpy.context.object.data.materials.append(material)
        return bpy.context.object, None
    surface = add_surface(material)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=0.1, location=(0.0, 9.0, 0.0))
    bpy.context.object.data.materials.append(material)
    return surface, bpy.context.object


def _set_inputs(modifier, group, other, material):
    values = {"NodeSocketObject": other, "NodeSocketMaterial": material}
    for item in _sockets(group, "INPUT"):
        value = values.get(item.socket_type)
        if value is None:
            continue
        if hasattr(modifier, "properties"):  # since Blender 5
            getattr(modifier.properties.inputs, item.identifier).value = value
        else:
            modifier[item.identifier] = value


def _geometry(path: Path, name: str):
    def build():
        _, material = stage()
        obj, other = _suitable(path, name, material)
        group = _load(path, name)
        if group.is_modifier:
            modifier = obj.modifiers.new(name, "NODES")
            modifier.node_group = group
            _set_inputs(modifier, group, other, material)
            if name == "Generate Hair Curves":  # strands as thick as a meter without
                obj.modifiers.new("Profile", "NODES").node_group = _load(path, _PROFILE)
            obj.update_tag()
            return ""

        def wrap(nodes, link, start, end):
            node = nodes.new("GeometryNodeGroup")
            node.node_tree = group
            first = _sockets(group, "INPUT", "NodeSocketGeometry")[0].identifier
            last = _sockets(group, "OUTPUT", "NodeSocketGeometry")[0].identifier
            link(start, next(s for s in node.inputs if s.identifier == first))
            link(next(s for s in node.outputs if s.identifier == last), end)

        add_nodes(obj, wrap)
        return "no modifier by itself: in a group of its own"

    return build


def _shading(path: Path, name: str):
    def build():
        _, material = stage()
        add_surface(material)
        tree = Tree(material.node_tree)
        node = tree.node("ShaderNodeGroup")
        node.node_tree = _load(path, name)
        if node.inputs[0].type == "VECTOR":
            tree.link(tree.coordinates(), node.inputs[0])
        shown = tree.made("ShaderNodeVectorMath", 0, {0: node.outputs[0]}, operation="ABSOLUTE")
        tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": shown}))

    return build


def _world(path: Path):
    def build():
        scene, material = stage()
        add_surface(material)
        image = bpy.data.images.load(str(path))
        texture = scene.world.node_tree.nodes["Environment Texture"]
        texture.image = image

    return build


def scene_of(path: Path, name: str) -> Whole | None:
    group = _load(path, name)
    label = f"{path.stem}: {name}"
    if group.bl_idname == "ShaderNodeTree":
        return Whole("asset", label, _shading(path, name))
    if group.bl_idname == "GeometryNodeTree" and _is_geometry(group):
        return Whole("asset", label, _geometry(path, name))
    return None


def scenes() -> tuple[list[Whole], list[str]]:
    """(scenes, names of groups that make no geometry and shade nothing)"""
    found, values = [], []
    for path in files():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        for name in _groups(path):
            whole = scene_of(path, name)
            values.append(name) if whole is None else found.append(whole)
    worlds = sorted(_folder("studiolights", "world").glob("*.exr"))
    return found + [Whole("world", path.name, _world(path)) for path in worlds], values

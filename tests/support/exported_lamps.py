"""The lamp that the open file is exported with, and its nodes."""

import bpy

from iwis.iwis_addon.export import export_scene


def exported():
    """(the one lamp's row as a dict, warnings)."""
    lines = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    if not len(scene.lamps.kind):
        return None, lines
    assert len(scene.lamps.kind) == 1
    shared = "faces", "texels", "falloffs"
    own = {n: value for n, value in scene.lamps._asdict().items() if n not in shared}
    return {name: value[0] for name, value in own.items()}, lines


def nodes_of(obj):
    """The light's tree, with its Emission."""
    if bpy.app.version < (5, 0):
        obj.data.use_nodes = True
    tree = obj.data.node_tree
    return tree, tree.nodes["Emission"]


def dress(obj, kind="ShaderNodeTexNoise", output="Color"):
    """Have a light's colour come from a new node."""
    tree, emission = nodes_of(obj)
    node = tree.nodes.new(kind)
    tree.links.new(node.outputs[output], emission.inputs["Color"])
    return node


def add_light(kind, name="Lamp", **settings):
    """A light object at (1, 2, 3). settings: of the light, or of the object where it has them"""
    light = bpy.data.lights.new(f"{name} data", kind)
    obj = bpy.data.objects.new(name, light)
    obj.location = 1.0, 2.0, 3.0
    for key, value in settings.items():
        setattr(light if hasattr(light, key) else obj, key, value)
    bpy.context.scene.collection.objects.link(obj)
    return obj

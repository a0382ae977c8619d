"""Attribute nodes that read data-blocks and instances; nodes with nothing linked to an input."""

import bpy

from .cases import CASES, Case, lit, lit_by, shown, world
from .lamp_cases import ABOVE, add_lamp, dressed, matte
from .scene import Tree

_OF_OBJECTS = {
    "number": "Fac",
    "vector": "Color",
    "color": "Color",
    "color ": "Alpha",
    "flag": "Fac",
    "whole": "Color",
    "five": "Color",
    "of the mesh": "Color",
    "location": "Vector",
    "rotation_euler[0]": "Fac",
    "nothing": "Alpha",
}
_OF_LAYERS = {"number": "Fac", "of the world": "Color", "frame_current": "Fac", "nothing": "Alpha"}


def _with_properties(scene):
    for k, obj in enumerate(o for o in scene.objects if o.type == "MESH"):
        obj["number"], obj["vector"] = 0.2 + 0.2 * k, (0.1, 0.3 * k, 0.5)
        obj["color"], obj["flag"] = (0.1, 0.2, 0.3, 0.3 * k), k == 1
        obj["whole"], obj["five"] = [k, 1, 2], [0.1, 0.2, 0.3, 0.4, 0.5]
        obj.data["of the mesh"], obj.data["number"] = 0.3 + 0.1 * k, 0.9
    scene["number"], scene.world["of the world"] = 0.3, (0.2, 0.3, 0.9)
    scene.world["number"] = 0.6


def _attribute(kind, name, output):
    def build(scene, tree):
        _with_properties(scene)
        node = {"attribute_type": kind, "attribute_name": name.strip()}
        tree.glow(tree.made("ShaderNodeAttribute", output, **node))

    return build


def _instances(scene, tree, name, output, of_objects=True):
    """Cubes on the sphere's vertices, each with a number and a vector of its own.

    of_objects: whether they are instances of the object, else of its mesh
    """
    _with_properties(scene)
    sphere, cube = scene.objects["Sphere"], scene.objects["Cube"]
    cube.scale, cube.rotation_euler = (0.06, 0.06, 0.06), (0.0, 0.0, 0.0)
    group = bpy.data.node_groups.new("Cubes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    nodes = Tree(group, "NodeGroupOutput")
    mesh = nodes.made("NodeGroupInput", 0)
    shown_cube = nodes.node("GeometryNodeObjectInfo")
    shown_cube.inputs["Object"].default_value = cube
    shown_cube.inputs["As Instance"].default_value = of_objects
    on_points = {"Points": mesh, "Instance": shown_cube.outputs["Geometry"]}
    made = nodes.made("GeometryNodeInstanceOnPoints", 0, on_points)
    for kind, own in {"FLOAT": "made number", "FLOAT_VECTOR": "made vector"}.items():
        value = nodes.made("FunctionNodeRandomValue", "Value", data_type=kind)
        stored = {"data_type": kind, "domain": "INSTANCE"}
        inputs = {"Geometry": made, "Value": value}
        made = nodes.made("GeometryNodeStoreNamedAttribute", 0, inputs, **stored)
        made.node.inputs["Name"].default_value = own
    nodes.link(made, nodes.output.inputs[0])
    sphere.modifiers.new("Cubes", "NODES").node_group = group
    _attribute("INSTANCER", name, output)(scene, tree)


for _name, _output in _OF_OBJECTS.items():
    CASES.append(Case(f"Attribute of an object, {_name}", _attribute("OBJECT", _name, _output)))
for _name, _output in _OF_LAYERS.items():
    build = _attribute("VIEW_LAYER", _name, _output)
    CASES.append(Case(f"Attribute of a view layer, {_name}", build))
for _name in ("made number", "made vector", "number", "nothing"):
    for _output in ("Color", "Alpha"):
        CASES.append(
            Case(
                f"Attribute of an instancer, {_name}, {_output}",
                lambda scene, tree, n=_name, o=_output: _instances(scene, tree, n, o),
            )
        )


for _name in ("made number", "made vector", "number"):
    CASES.append(
        Case(
            f"Attribute of an instancer, {_name}, of a mesh",
            lambda scene, tree, n=_name: _instances(scene, tree, n, "Color", False),
        )
    )


def _colored_instances(kind):
    """Cubes made by three empties of a collection, or by the sphere's vertices or particles."""

    def build(scene, tree):
        sphere, cube = scene.objects["Sphere"], scene.objects["Cube"]
        sphere.color = (0.9, 0.2, 0.1, 1.0)
        if kind == "collection":
            boxes = bpy.data.collections.new("Boxes")
            boxes.objects.link(cube)
            for k in range(3):
                empty = bpy.data.objects.new("Instancer", None)
                empty.instance_type, empty.instance_collection = "COLLECTION", boxes
                empty.location, empty.color = (-1.8 + 0.6 * k, 0, 0.5), (0.3 * k, 0.4, 0.7, 1.0)
                scene.collection.objects.link(empty)
        elif kind == "vertices":
            cube.parent, cube.scale, sphere.instance_type = sphere, (0.06,) * 3, "VERTS"
        else:
            settings = sphere.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
            settings.type, settings.count, settings.hair_length = "HAIR", 60, 0.2
            settings.render_type, settings.instance_object = "OBJECT", cube
        tree.glow(tree.made("ShaderNodeObjectInfo", "Color"))

    return build


for _kind in ("collection", "vertices", "particles"):
    CASES.append(Case(f"Object Info, Color of instances, {_kind}", _colored_instances(_kind)))


def _lit_by_a_number(kind, name, output):
    """A lamp whose strength is a property of its own, or of the scene."""

    def build(scene, tree):
        _with_properties(scene)
        lamp = add_lamp(scene, "POINT", ABOVE, energy=300.0)
        scene.objects["Lamp"]["number"], lamp["of the light"] = 0.7, (0.3, 0.9, 1.2)
        lamp["number"] = 0.2  # behind the object's own
        node = {"attribute_type": kind, "attribute_name": name}
        strength = {"Strength": 1.0, "Color": (0.9, 0.6, 0.3)}
        target = "Color" if output == "Color" else "Strength"

        def emission(lamp_tree):
            value = lamp_tree.made("ShaderNodeAttribute", output, **node)
            return lamp_tree.made("ShaderNodeEmission", 0, strength | {target: value})

        dressed(lamp, emission)
        tree.surface(matte(tree))

    lit_by(f"Attribute of {kind.lower().replace('_', ' ')}, {name}, of a lamp", build, world=False)


_lit_by_a_number("VIEW_LAYER", "number", "Fac")
_lit_by_a_number("OBJECT", "number", "Fac")
_lit_by_a_number("OBJECT", "of the light", "Color")


def _strong_world(tree):
    scene = bpy.context.scene
    scene["number"], scene.world["number"] = 0.3, 0.6
    node = {"attribute_type": "VIEW_LAYER", "attribute_name": "number"}
    strength = tree.made("ShaderNodeAttribute", "Fac", **node)
    inputs = {"Color": (0.9, 0.7, 0.5), "Strength": strength}
    return tree.made("ShaderNodeBackground", 0, inputs)


world("Attribute of a view layer, number, of a world", _strong_world)


def _beside(tree, output):
    """An output that is the same everywhere, added to something that is not."""
    inputs = {0: tree.coordinates(), 1: output}
    return tree.made("ShaderNodeVectorMath", 0, inputs, operation="ADD")


shown("Attribute that is not there, Alpha", lambda t: t.made("ShaderNodeAttribute", "Alpha"))
for _kind in ("ShaderNodeBump", "ShaderNodeGamma", "ShaderNodeVectorRotate"):
    shown(f"{_kind[10:]}, no input linked", lambda t, k=_kind: _beside(t, t.made(k, 0)))
shown(
    "White Noise, no input linked", lambda t: _beside(t, t.made("ShaderNodeTexWhiteNoise", "Color"))
)
lit(
    "Bump without a height",
    lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Normal": t.made("ShaderNodeBump", 0)}),
)


def _of_edges(kind, field):
    """An attribute of the edges of all meshes, which vertices have the mean of."""

    def build(scene, tree):
        for obj in scene.objects:
            if obj.type == "MESH":
                own = obj.data.attributes.new("Edges", kind, "EDGE")
                for k, value in enumerate(own.data):
                    new = (k % 3 / 2, k % 5 / 4, k % 7 / 6)
                    new = (*new, 0.3 * new[0]) if field == "color" else new
                    setattr(value, field, k % 3 % 2 if field == "value" else new)
        output = "Fac" if field == "value" else "Vector"
        tree.glow(tree.made("ShaderNodeAttribute", output, attribute_name="Edges"))

    CASES.append(Case(f"Attribute of edges, {kind}", build))


for _kind, _field in (
    ("FLOAT_VECTOR", "vector"),
    ("INT", "value"),
    ("BOOLEAN", "value"),
    ("BYTE_COLOR", "color"),
):
    _of_edges(_kind, _field)


_KINDS = {
    "FLOAT": ("value", 0.7),
    "FLOAT2": ("vector", (0.6, 0.3)),
    "FLOAT_COLOR": ("color", (0.2, 0.5, 0.9, 0.4)),
}


def _of_kinds(output, kinds):
    """An attribute of one name and other kinds on the objects of a material; the last has none."""

    def build(scene, tree):
        for obj, kind in zip(scene.objects, kinds, strict=False):
            field, most = _KINDS[kind]
            own = obj.data.attributes.new("Own", kind, "POINT")
            for k, value in enumerate(own.data):
                part = k % 3 / 2
                new = tuple(part * m for m in most) if field != "value" else part * most
                setattr(value, field, new)
        tree.glow(tree.made("ShaderNodeAttribute", output, attribute_name="Own"))

    return build


for _output in ("Color", "Fac", "Alpha"):
    CASES.append(Case(f"Attribute of several kinds, {_output}", _of_kinds(_output, [*_KINDS])))
    two = _of_kinds(_output, ["FLOAT", "FLOAT_COLOR"])
    CASES.append(Case(f"Attribute of several kinds and none, {_output}", two))
CASES.append(Case("Attribute of two numbers, Fac", _of_kinds("Fac", ["FLOAT2"])))


def _of_empties(scene, tree):
    """Instancers that are empties have no attributes."""
    _with_properties(scene)
    _colored_instances("collection")(scene, tree)
    _attribute("INSTANCER", "number", "Color")(scene, tree)


CASES.append(Case("Attribute of an instancer, of a collection", _of_empties))

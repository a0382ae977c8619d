"""Point clouds, curves and particle hair beside Cycles' own points and curves.

A pixel sees several of the strands, so both engines have their usual filter.
"""

from __future__ import annotations

import bpy
import numpy as np

from .cases import CASES, Case

_FILTER = 1.5  # pixels; Cycles' default


def _case(name, build, lit=True, **options):
    CASES.append(Case(name, build, lit=lit, blurred=True, filter_width=_FILTER, **options))


def without_solids(scene):
    """Only the floor is left. Returns the material of all."""
    for obj in list(scene.objects):
        if obj.type == "MESH" and obj.name != "Plane":
            bpy.data.objects.remove(obj)
    return bpy.data.materials["M"]


def _matte(tree):
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.5, 0.2)}))


def _plastic(tree):
    inputs = {"Base Color": (0.2, 0.4, 0.8), "Roughness": 0.3}
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs))


def _half_clear(tree):
    """On a matte floor."""
    on_a_matte_floor()
    mix = tree.node("ShaderNodeMixShader")
    diffuse = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.5, 0.2)})
    for value, socket in zip((0.5, _clear(tree), diffuse), mix.inputs, strict=True):
        tree.link(value, socket)
    tree.surface(mix.outputs[0])


def _tinted_glass(tree):
    on_a_matte_floor()
    tree.surface(_clear(tree, (0.9, 0.5, 0.2)))


def _clear(tree, color=(1.0, 1.0, 1.0)):
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})


def on_a_matte_floor():
    scene = bpy.context.scene
    scene.cycles.transparent_max_bounces = scene.iwis.transparent_max_bounces = 64
    bpy.data.objects["Plane"].data.materials[0] = bpy.data.materials.new("Floor")


def _metal(tree):
    inputs = {"Base Color": (0.9, 0.7, 0.4), "Roughness": 0.25, "Metallic": 1.0}
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs))


def _attribute(name, output="Color"):
    return lambda tree: tree.glow(tree.made("ShaderNodeAttribute", output, attribute_name=name))


def _root_uv(tree):
    tree.glow(tree.coordinates("UV"))


def _info(kind, output, scale=1.0):
    def material(tree):
        value = tree.made(kind, output)
        scaled = tree.made("ShaderNodeVectorMath", 0, {0: value, 1: scale}, operation="MULTIPLY")
        tree.glow(tree.made("ShaderNodeVectorMath", 0, {0: scaled}, operation="ABSOLUTE"))

    return material


def add_nodes(obj, build):
    """A geometry nodes modifier; build(nodes, link, input, output) fills its tree."""
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    build(tree.nodes, tree.links.new, start.outputs[0], end.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree


def add_points(material, places, radii, **place):
    """An object whose vertices geometry nodes make points of the given radii, with a colour."""
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata(places.tolist(), [], [])
    mesh.attributes.new("size", "FLOAT", "POINT").data.foreach_set("value", radii)
    tint = mesh.attributes.new("tint", "FLOAT_COLOR", "POINT")
    tint.data.foreach_set("color", np.pad(np.abs(places), ((0, 0), (0, 1))).ravel())
    obj = bpy.data.objects.new("Points", mesh)
    for key, value in place.items():
        setattr(obj, key, value)
    bpy.context.scene.collection.objects.link(obj)

    def build(nodes, link, start, end):
        points, paint = nodes.new("GeometryNodeMeshToPoints"), nodes.new("GeometryNodeSetMaterial")
        size = nodes.new("GeometryNodeInputNamedAttribute")
        size.data_type, size.inputs["Name"].default_value = "FLOAT", "size"
        paint.inputs["Material"].default_value = material
        link(start, points.inputs["Mesh"])
        link(next(o for o in size.outputs if o.enabled), points.inputs["Radius"])
        link(points.outputs[0], paint.inputs["Geometry"])
        link(paint.outputs[0], end)

    add_nodes(obj, build)
    return obj


def _points(name, material, count=60, size=(0.06, 0.3), lit=True, **place):
    def build(scene, tree):
        material(tree)
        rng = np.random.default_rng(3)
        places = rng.uniform((-2.0, -1.0, -0.9), (2.0, 1.5, 0.9), (count, 3)).astype(np.float32)
        radii = rng.uniform(*size, count).astype(np.float32)
        add_points(without_solids(scene), places, radii, **place)

    _case(f"Points, {name}", build, lit)


def _instanced_points(name, material):
    """Scaled unevenly and there twice: of a single one Cycles makes round spheres."""

    def build(scene, tree):
        material(tree)
        rng = np.random.default_rng(3)
        places = rng.uniform((-2.0, -1.0, -0.9), (2.0, 1.5, 0.9), (40, 3)).astype(np.float32)
        points = add_points(without_solids(scene), places, np.full(40, 0.2, np.float32))
        points.users_collection[0].objects.unlink(points)
        group = bpy.data.collections.new("Points")
        group.objects.link(points)
        for x in (-0.7, 0.9):
            twin = bpy.data.objects.new("Twin", None)
            twin.instance_type, twin.instance_collection = "COLLECTION", group
            twin.scale, twin.location.x = (0.6, 0.4, 0.9), x
            scene.collection.objects.link(twin)

    _case(f"Points, {name}", build)


def add_curves(material, places, radii, **place):
    """A hair curves object. places: float32 (strands, keys, 3); radii: float32 (strands, keys)"""
    strands, keys = radii.shape
    data = bpy.data.hair_curves.new("Strands")
    data.add_curves([keys] * strands)
    data.position_data.foreach_set("vector", np.ascontiguousarray(places, np.float32).ravel())
    attributes = data.attributes
    radius = attributes.get("radius") or attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.ascontiguousarray(radii, np.float32).ravel())
    tint = attributes.new("tint", "FLOAT_COLOR", "POINT")
    colors = np.pad(np.abs(places), ((0, 0), (0, 0), (0, 1)))
    tint.data.foreach_set("color", np.ascontiguousarray(colors, np.float32).ravel())
    uv = attributes.new("surface_uv_coordinate", "FLOAT2", "CURVE")
    where = np.stack([np.linspace(0, 1, strands), np.linspace(1, 0, strands) ** 2], -1)
    uv.data.foreach_set("vector", np.ascontiguousarray(where, np.float32).ravel())
    data.materials.append(material)
    obj = bpy.data.objects.new("Strands", data)
    for key, value in place.items():
        setattr(obj, key, value)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def bent_strands(count, keys, spread=(2.2, 1.2), height=1.6, seed=5):
    """float32 (count, keys, 3): from the floor up, each bent to its own side."""
    rng = np.random.default_rng(seed)
    roots = rng.uniform(-1.0, 1.0, (count, 1, 3)) * (*spread, 0.0) + (0.0, 0.2, -1.0)
    t = np.linspace(0.0, 1.0, keys)[None, :, None]
    lean = rng.normal(0.0, 0.35, (count, 1, 3)) * (1.0, 1.0, 0.0)
    up = np.array([0.0, 0.0, 1.0]) * rng.uniform(0.6, 1.0, (count, 1, 1)) * height
    return (roots + t * up + 2.0 * t**2 * lean).astype(np.float32)


def _curves(
    name, material, count=24, keys=5, size=(0.12, 0.03), lit=True, shape="THICK", types=(), **place
):
    """types: (type, numbers of curves, None: all) one after the other"""

    def build(scene, tree):
        material(tree)
        scene.cycles_curves.shape = shape
        places = bent_strands(count, keys)
        radii = np.broadcast_to(np.linspace(*size, keys), (count, keys))
        data = add_curves(without_solids(scene), places, radii, **place).data
        for kind, some in types:
            data.set_types(type=kind, **({} if some is None else {"indices": some}))

    _case(f"Curves, {name}", build, lit)


def add_particle_hair(obj, count, children="NONE", **settings):
    """Hair on an object; settings: of its particle settings."""
    obj.modifiers.new("Hair", "PARTICLE_SYSTEM")
    hair = obj.particle_systems[0].settings
    hair.type, hair.count, hair.hair_length, hair.child_type = "HAIR", count, 0.6, children
    for key, value in settings.items():
        setattr(hair, key, value)
    return hair


def _hair(name, material, count=300, lit=True, children="NONE", **settings):
    def build(scene, tree):
        material(tree)
        scene.cycles_curves.shape = "THICK"
        add_particle_hair(bpy.data.objects["Sphere"], count, children, **settings)

    _case(f"Particle hair, {name}", build, lit)


_points("that let half of the light through", _half_clear)
_points("clear and tinted", _tinted_glass)
_curves("that let half of the light through", _half_clear)
_points("diffuse", _matte)
_points("Principled, rough metal", _metal)
_points("plastic, many small", _plastic, count=3000, size=(0.02, 0.06))
_points("scaled and turned", _matte, scale=(1.0, 0.6, 0.8), rotation_euler=(0.2, 0.3, 0.5))
_instanced_points("scaled unevenly, two instances", _matte)
_points("colour attribute", _attribute("tint"), lit=False)
_points("Point Info Position", _info("ShaderNodePointInfo", "Position"), lit=False)
_points("Point Info Radius", _info("ShaderNodePointInfo", "Radius", 4.0), lit=False)
_points("Point Info Random", _info("ShaderNodePointInfo", "Random"), lit=False)
_points("Generated", lambda tree: tree.glow(tree.coordinates("Generated")), lit=False)
_curves("diffuse, radius varies", _matte)
_curves("diffuse, radius varies, ribbons", _matte, shape="RIBBONS")
_curves("diffuse, linear 3D", _matte, shape="THICK_LINEAR")
_curves("Poly", _matte, types=[("POLY", None)])
_curves(
    "Poly, thin ribbons", _matte, 60, size=(0.03, 0.02), shape="RIBBONS", types=[("POLY", None)]
)
_curves("Poly but for the first", _matte, types=[("POLY", None), ("CATMULL_ROM", [0])])
_curves("Bezier and NURBS", _matte, types=[("BEZIER", [0, 1, 2, 3]), ("NURBS", [4, 5, 6])])
_curves("metal", _metal)
_curves("plastic, many thin", _plastic, count=2000, keys=8, size=(0.012, 0.003))
_curves("matte, many thin ribbons", _matte, 2000, 8, size=(0.012, 0.003), shape="RIBBONS")
_curves("scaled and turned", _matte, scale=(1.0, 0.7, 0.8), rotation_euler=(0.1, 0.2, 0.4))
_curves("colour attribute", _attribute("tint"), lit=False)
_curves("UV of the root", _root_uv, lit=False)
_curves("Generated", lambda tree: tree.glow(tree.coordinates("Generated")), lit=False)
for _output in ("Intercept", "Length", "Random", "Is Strand", "Tangent Normal"):
    _curves(f"Curves Info {_output}", _info("ShaderNodeHairInfo", _output), lit=False)
_curves("Curves Info Thickness", _info("ShaderNodeHairInfo", "Thickness", 5.0), lit=False)
_hair("diffuse", _matte, radius_scale=0.03)
_hair("plastic, children", _plastic, count=100, children="SIMPLE", rendered_child_count=20)
_hair("strand shape, closed tip", _matte, radius_scale=0.05, shape=0.5, use_close_tip=True)
_hair(
    "UV of the root", lambda tree: tree.glow(tree.coordinates("UV")), lit=False, radius_scale=0.03
)
_hair(
    "Intercept",
    _info("ShaderNodeHairInfo", "Intercept"),
    lit=False,
    radius_scale=0.05,
    tip_radius=1.0,
)

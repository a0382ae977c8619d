"""Displacement: vertices that materials move, and what is left of it as bump."""

import bpy
import numpy as np

from .cases import CASES, Case
from .lit_cases import image_of
from .scene import Tree

_LIT = {"lit": True, "samples": (256, 1024)}


def hills(tree):
    """Hills wider than a pixel: how finer ones turn normals is a matter of chance."""
    inputs = {"Vector": tree.coordinates(), "Scale": 1.2, "Detail": 0.0}
    return tree.made("ShaderNodeTexNoise", 0, inputs)


def _sphere():
    return bpy.data.objects["Sphere"]


def _finer(levels=4):
    """More vertices for the cube and the floor."""
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.name != "Sphere":
            obj.modifiers.new("Finer", "SUBSURF").render_levels = levels
            obj.modifiers["Finer"].subdivision_type = "SIMPLE"


def displaced(tree, method, value=None, **place):
    """Have the scene's material displace by a value, else by a noise; place: of the sphere"""
    if value is None:
        value = by_height(tree, hills(tree))
    tree.link(value, tree.output.inputs["Displacement"])
    bpy.data.materials["M"].displacement_method = method
    for key, setting in place.items():
        setattr(_sphere(), key, setting)


def by_height(tree, height, scale=0.5, **options):
    inputs = {"Height": height, "Midlevel": 0.45, "Scale": scale}
    return tree.made("ShaderNodeDisplacement", 0, inputs, **options)


def _by_vector(tree, space):
    inputs = {"Vector": tree.color(-0.4, 0.9), "Midlevel": 0.2, "Scale": 0.3}
    return tree.made("ShaderNodeVectorDisplacement", 0, inputs, space=space)


def _case(name, value=None, method="DISPLACEMENT", more=lambda scene: None, **place):
    """Two cases: the normal that is seen, and paint under a world. value(tree): what displaces"""

    def made(scene, tree, shown):
        _finer()
        displaced(tree, method, None if value is None else value(tree), **place)
        if shown:
            half = (0.5, 0.5, 0.5)
            normal = {0: tree.made("ShaderNodeNewGeometry", "Normal"), 1: half, 2: half}
            tree.glow(tree.made("ShaderNodeVectorMath", 0, normal, operation="MULTIPLY_ADD"))
        else:
            paint = {"Base Color": (0.6, 0.5, 0.4)}
            tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, paint))
        more(scene)

    CASES.append(Case(f"Displacement{name}, normals", lambda s, t: made(s, t, True)))
    CASES.append(Case(f"Displacement{name}", lambda s, t: made(s, t, False), **_LIT))


_case(" of vertices")
_case(" of vertices and bump", method="BOTH")
_case(" of vertices, of a stretched object", scale=(1.3, 0.9, 1.1))
_case(" of vertices and bump, of a stretched object", method="BOTH", scale=(1.3, 0.9, 1.1))
_case(" of vertices, world space", lambda t: by_height(t, hills(t), space="WORLD"))
_case(" of vertices, by an image", lambda t: by_height(t, image_of(t), 0.3))
_case(" of vertices and bump, by an image", lambda t: by_height(t, image_of(t), 0.3), "BOTH")
_case(" of vertices, all alike", lambda t: by_height(t, 0.9))
for _space in ("TANGENT", "OBJECT", "WORLD"):
    for _method, _what in (
        ("DISPLACEMENT", "of vertices"),
        ("BOTH", "of vertices and bump"),
        ("BUMP", "as bump"),
    ):
        _case(
            f" {_what}, vector in {_space.lower()} space",
            lambda t, space=_space: _by_vector(t, space),
            _method,
            scale=(1.3, 0.9, 1.1),
        )


def _two(tree):
    """The sum of two nodes."""
    values = (by_height(tree, hills(tree)), _by_vector(tree, "OBJECT"))
    return tree.made("ShaderNodeVectorMath", 0, dict(enumerate(values)), operation="ADD")


def _aslant(tree):
    """Along another normal than the surface's."""
    inputs = {"Height": hills(tree), "Scale": 0.5, "Normal": (0.6, -0.6, 0.5)}
    normal = tree.made("ShaderNodeCombineXYZ", 0, {0: 0.6, 1: -0.6, 2: 0.5})
    return tree.made("ShaderNodeDisplacement", 0, inputs | {"Normal": normal})


_case(" of vertices, two added", _two)
_case(" of vertices and bump, two added", _two, "BOTH")
_case(" as bump, two added", _two, "BUMP")
_case(" of vertices, along another normal", _aslant)
_case(" as bump, along another normal", _aslant, "BUMP")


def _flat(scene):
    _sphere().data.shade_flat()


def _half_flat(scene):
    """Smooth faces beside flat ones."""
    faces = _sphere().data.polygons
    faces.foreach_set("use_smooth", np.arange(len(faces)) // 64 % 2 == 0)


def _sharp(scene):
    """Marked edges, where normals differ on both sides."""
    edges = _sphere().data.edges
    edges.foreach_set("use_edge_sharp", np.arange(len(edges)) % 5 == 0)


def _hard(scene):
    """A smooth cube all of whose edges are sharp."""
    cube = bpy.data.objects["Cube"].data
    cube.shade_smooth()
    cube.edges.foreach_set("use_edge_sharp", np.ones(len(cube.edges), np.bool_))


def _own_normals(scene):
    """Bands of the sphere lean aside, and every other one has a material that moves nothing."""
    _half_plain(scene)
    mesh = _sphere().data
    leaning = np.float32([[0.4, 0.0, 0.3], [-0.2, 0.4, 0.0]])
    band = np.repeat(
        np.arange(len(mesh.polygons)) // 256 % 2, [p.loop_total for p in mesh.polygons]
    )
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    normals = np.array([v.normal for v in mesh.vertices])[vertices] + leaning[band]
    mesh.normals_split_custom_set(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _half_plain(scene):
    """Half of the sphere has a material that moves nothing."""
    plain = bpy.data.materials.new("Plain")
    if bpy.app.version < (5, 0):
        plain.use_nodes = True
    Tree(plain.node_tree).glow((0.3, 0.5, 0.2))
    _sphere().data.materials.append(plain)
    faces = _sphere().data.polygons
    faces.foreach_set("material_index", (np.arange(len(faces)) // 256 % 2).astype(np.int32))


def _among_plain(scene):
    """Every other band of faces has the same material without its displacement."""
    plain = bpy.data.materials["M"].copy()
    output = next(n for n in plain.node_tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    plain.node_tree.links.remove(output.inputs["Displacement"].links[0])
    _sphere().data.materials.append(plain)
    faces = _sphere().data.polygons
    faces.foreach_set("material_index", (np.arange(len(faces)) // 32 % 2).astype(np.int32))


def instanced(scene):
    """Copies of the sphere, one of them mirrored."""
    for place, size in (((0.9, -1.2, -0.4), (0.4, 0.4, 0.4)), ((0.4, 0.8, 0.9), (-0.5, 0.5, 0.5))):
        copy = _sphere().copy()
        copy.location, copy.scale = place, size
        scene.collection.objects.link(copy)


_case(" of vertices, flat", more=_flat)
_case(" of vertices and bump, flat", method="BOTH", more=_flat)
_case(" of vertices, half flat", more=_half_flat)
_case(" of vertices, sharp edges", more=_sharp)
_case(" of vertices and bump, sharp edges", method="BOTH", more=_sharp)
_case(" of vertices, hard edges", more=_hard)
_case(" of vertices and bump, hard edges", method="BOTH", more=_hard)
_case(" of vertices, custom normals", more=_own_normals)
_case(" of vertices and bump, custom normals", method="BOTH", more=_own_normals)
_case(" of vertices, of half a mesh", more=_half_plain)
_case(" of vertices, among plain faces", more=_among_plain)
_case(" of vertices, of copies", more=instanced)
_case(
    " of vertices, world space, of copies",
    lambda t: by_height(t, hills(t), space="WORLD"),
    more=instanced,
)


def _glowing(scene, tree):
    """What shines lights the floor with the shape that it has got."""
    displaced(tree, "DISPLACEMENT")
    tree.surface(tree.made("ShaderNodeEmission", 0, {"Color": (1.0, 0.7, 0.4), "Strength": 3.0}))
    plain = bpy.data.materials.new("Plain")
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.name != "Sphere":
            obj.data.materials[0] = plain


CASES.append(Case("Displacement of vertices that shine", _glowing, by_lamps=True))


def _mapped(name, method, strength=1.0, **options):
    """A normal map on what is displaced; on the cube, which is not, too."""

    def build(scene, tree):
        displaced(tree, method)
        color = tree.color(0.35, 0.75)
        known = bpy.types.ShaderNodeNormalMap.bl_rna.properties  # of Blender 5.2
        settings = {name: value for name, value in options.items() if name in known}
        turned = tree.made(
            "ShaderNodeNormalMap", 0, {"Color": color, "Strength": strength}, **settings
        )
        half = (0.5, 0.5, 0.5)
        shown = {0: turned, 1: half, 2: half}
        tree.glow(tree.made("ShaderNodeVectorMath", 0, shown, operation="MULTIPLY_ADD"))
        cube = bpy.data.objects["Cube"]
        cube.data.materials[0] = bpy.data.materials["M"].copy()
        cube.data.materials[0].displacement_method = "BUMP"

    CASES.append(Case(f"Displacement of vertices{name}", build))


for _base in ("ORIGINAL", "DISPLACED"):
    for _strength in (1.0, 0.4, 1.6):
        for _method, _what in (("DISPLACEMENT", ""), ("BOTH", " and bump")):
            _name = f"{_what}, normal map {_base.lower()}, strength {_strength:g}"
            _mapped(_name, _method, _strength, base=_base)
for _space in ("TANGENT", "WORLD"):
    _mapped(
        f", normal map of DirectX, {_space.lower()} space",
        "BUMP",
        convention="DIRECTX",
        space=_space,
    )

"""Adaptive subdivision: meshes that are diced as finely as they are seen."""

from __future__ import annotations

import bpy
import numpy as np

from .cases import CASES, Case
from .displacement_cases import by_height, displaced, hills, instanced
from .lit_cases import image_of
from .movers import by_keys

_LIT = {"lit": True, "samples": (256, 1024)}
_NEWER = bpy.app.version >= (5, 0)


def _sphere():
    return bpy.data.objects["Sphere"]


def _coarse():
    """A ball of few faces, triangles among them, in place of the sphere."""
    material = bpy.data.materials["M"]
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=5)
    made = bpy.context.object
    mesh, _sphere().data = made.data, made.data
    bpy.data.objects.remove(made)
    mesh.shade_smooth()
    mesh.materials.append(material)
    numbers = np.arange(len(mesh.loops))
    rgba = np.stack([numbers % 3 / 2, numbers % 5 / 4, numbers % 7 / 6, np.ones(len(numbers))], -1)
    colors = mesh.color_attributes.new("Col", "FLOAT_COLOR", "CORNER")
    colors.data.foreach_set("color", rgba.astype(np.float32).ravel())


def diced(obj, pixels=1.0, kind="CATMULL_CLARK", **settings):
    """Subdivide an object adaptively. settings: of its modifier"""
    modifier = obj.modifiers.new("Diced", "SUBSURF")
    modifier.subdivision_type = kind
    known = bpy.types.SubsurfModifier.bl_rna.properties
    for name, value in settings.items():
        if name in known:  # some are of Blender 5 alone
            setattr(modifier, name, value)
    if _NEWER:
        modifier.use_adaptive_subdivision, modifier.adaptive_pixel_size = True, pixels
    else:
        bpy.context.scene.cycles.feature_set = "EXPERIMENTAL"
        obj.cycles.use_adaptive_subdivision, obj.cycles.dicing_rate = True, pixels


def _all_diced(pixels=0.25, kind="CATMULL_CLARK", **settings):
    """The ball as told, the cube and the floor as they are."""
    for obj in bpy.data.objects:
        if obj.type == "MESH":
            own = kind if obj.name == "Sphere" else "SIMPLE"
            diced(obj, pixels, own, **settings)


def _normals(tree):
    half = (0.5, 0.5, 0.5)
    inputs = {0: tree.made("ShaderNodeNewGeometry", "Normal"), 1: half, 2: half}
    return tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY_ADD")


def _shown(name, value=_normals, more=lambda scene: None, **settings):
    """A value as light, on surfaces that nothing displaces."""

    def build(scene, tree):
        _coarse()
        _all_diced(**settings)
        tree.glow(value(tree))
        more(scene)

    CASES.append(Case(f"Adaptive subdivision, {name}", build))


def _few(scene, most):
    _sphere().data.shade_flat()
    scene.cycles.max_subdivisions = most


def _aside(scene):
    """Diced by a camera that is far, and beside which the ball lies."""
    _sphere().data.shade_flat()
    camera = bpy.data.objects.new("Aside", bpy.data.cameras.new("Aside"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (5.0, -9.0, 2.0), (1.4, 0.0, -0.2)
    scene.cycles.dicing_camera = camera


_shown("normals")
_shown("simple, normals", kind="SIMPLE")
_shown("edges of four pixels, normals", pixels=4.0)
_shown("flat, normals", more=lambda scene: _sphere().data.shade_flat())
_shown("flat, two parts an edge", more=lambda scene: _few(scene, 1))
_shown("flat, eight parts an edge", more=lambda scene: _few(scene, 3))
_shown("flat, by another camera", pixels=0.5, more=_aside)
_shown("UV", lambda tree: tree.coordinates("UV"))
_shown("UV all smooth", lambda tree: tree.coordinates("UV"), uv_smooth="SMOOTH_ALL")
_shown("UV as it is", lambda tree: tree.coordinates("UV"), uv_smooth="NONE")
_shown("Generated", lambda tree: tree.coordinates("Generated"))
_shown("colour attribute", lambda t: t.made("ShaderNodeVertexColor", 0, layer_name="Col"))
_shown("Pointiness", lambda t: t.made("ShaderNodeNewGeometry", "Pointiness"))
_shown("Random Per Island", lambda t: t.made("ShaderNodeNewGeometry", "Random Per Island"))
_shown("in its own space", adaptive_space="OBJECT", adaptive_object_edge_length=0.02)


def _creased(weight):
    def more(scene):
        mesh = _sphere().data
        attribute = mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
        rows = np.arange(len(mesh.edges)) % 4 == 0
        attribute.data.foreach_set("value", np.where(rows, weight, 0.0).astype(np.float32))

    return more


_shown("creases", more=_creased(1.0))
_shown("creases of .25", more=_creased(0.25))
_shown("creases that do not count", more=_creased(1.0), use_creases=False)


def _open(scene):
    """A cap of the ball, whose edge is open."""
    mesh = _sphere().data
    vertices = [v for v in mesh.vertices if v.co.z < 0.3]
    new = {v.index: row for row, v in enumerate(vertices)}
    faces = [[new.get(v) for v in p.vertices] for p in mesh.polygons]
    faces = [face for face in faces if None not in face]
    made = bpy.data.meshes.new("Cap")
    made.from_pydata([v.co for v in vertices], [], faces)
    made.shade_smooth()
    made.materials.append(bpy.data.materials["M"])
    _sphere().data = made


_shown("open", more=_open)
_shown("open, corners kept", more=_open, boundary_smooth="PRESERVE_CORNERS")


def _moved(name, method="DISPLACEMENT", value=None, more=lambda scene: None, **settings):
    """Two cases: the normals of what is displaced, and paint under a world."""

    def made(scene, tree, shown):
        _coarse()
        _all_diced(**settings)
        displaced(tree, method, None if value is None else value(tree))
        if shown:
            tree.glow(_normals(tree))
        else:
            paint = {"Base Color": (0.6, 0.5, 0.4)}
            tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, paint))
        more(scene)

    title = f"Adaptive subdivision, displaced{name}"
    CASES.append(Case(f"{title}, normals", lambda s, t: made(s, t, True)))
    CASES.append(Case(title, lambda s, t: made(s, t, False), **_LIT))


_moved("")
_moved(" and bump", "BOTH")
_moved(", simple", kind="SIMPLE")
_moved(" and bump, simple", "BOTH", kind="SIMPLE")
_moved(" by an image", value=lambda tree: by_height(tree, image_of(tree), 0.3))
_moved(", of copies", more=instanced)


def _changes(scene, tree):
    """What changes its shape while the shutter is open, displaced besides."""
    _coarse()
    _all_diced()
    displaced(tree, "DISPLACEMENT", by_height(tree, hills(tree), 0.2))
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.6, 0.5, 0.4)}))
    by_keys(_sphere())
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0


CASES.append(Case("Adaptive subdivision, displaced, in motion", _changes, lit=True, blurred=True))

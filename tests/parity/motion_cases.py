"""Motion blur of what changes its shape, and of lamps, which stand still for it."""

from __future__ import annotations

import math

import bpy
import numpy as np

from .cases import CASES, Case
from .element_cases import add_curves, add_particle_hair, add_points, bent_strands
from .movers import (
    by_armature,
    by_keys,
    by_wave,
    cut,
    lean,
    make_cylinder,
    move_and_turn,
    with_velocity,
)
from .view_cases import linear


def _checks(tree, coordinates="Object"):
    inputs = {"Vector": tree.coordinates(coordinates), "Scale": 4.0}
    return tree.made("ShaderNodeTexChecker", 0, inputs)


def _matte(tree):
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": _checks(tree)}))


def _glow_on_map(tree):
    """Checks by UV, which stay on the surface, and by the object, which do not."""
    fixed, loose = _checks(tree, "UV"), _checks(tree)
    tree.glow(tree.made("ShaderNodeMix", 2, {0: 0.5, 6: fixed, 7: loose}, data_type="RGBA"))


def _cut_out(tree):
    clear = tree.made("ShaderNodeBsdfTransparent", 0)
    matte = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.6, 0.4)})
    checks = {"Vector": tree.coordinates("UV"), "Scale": 8.0, "Color1": 1.0, "Color2": 0.0}
    share = tree.made("ShaderNodeTexChecker", "Fac", checks)
    tree.surface(tree.made("ShaderNodeMixShader", 0, {0: share, 1: clear, 2: matte}))


def _mapped(tree):
    place = {0: tree.coordinates("UV"), 1: (0.4, 0.4, 0.0), 2: (0.3, 0.3, 1.0)}
    color = tree.made("ShaderNodeVectorMath", 0, place, operation="MULTIPLY_ADD")
    normal = tree.made("ShaderNodeNormalMap", 0, {"Color": color, "Strength": 0.7})
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Normal": normal}))


def _glossy(tree):
    bump = tree.made("ShaderNodeBump", 0, {"Height": _checks(tree, "UV"), "Distance": 0.05})
    inputs = {"Roughness": 0.3, "Color": (0.9, 0.8, 0.7), "Normal": bump}
    tree.surface(tree.made("ShaderNodeBsdfAnisotropic", 0, inputs))


def _parts(scene):
    sphere = bpy.data.objects["Sphere"]
    cube = next(obj for obj in scene.objects if obj.type == "MESH" and "ube" in obj.name)
    floor = next(obj for obj in scene.objects if obj.type == "MESH" and "lane" in obj.name)
    return sphere, cube, floor


def _blurs(scene, steps=1, **render):
    for obj in scene.objects:
        obj.cycles.motion_steps = steps
    scene.frame_set(1)
    scene.render.use_motion_blur = True
    for key, value in {"motion_blur_shutter": 1.0, **render}.items():
        setattr(scene.render, key, value)


def _case(name, change, material=_matte, lit=True, by_lamps=False, **options):
    """change(scene, sphere, cube, floor) has something move."""

    def build(scene, tree):
        material(tree)
        change(scene, *_parts(scene))
        _blurs(scene, **options)

    CASES.append(Case(f"Motion {name}", build, lit=lit, by_lamps=by_lamps, blurred=True))


def _bent(scene, sphere, cube, floor):
    make_cylinder(cube)
    by_armature(cube)


def _shape_keys(scene, sphere, cube, floor):
    by_keys(sphere)
    cut(cube, 3)
    by_keys(cube, 0.5)


def _waves(scene, sphere, cube, floor):
    cut(floor, 60)
    by_wave(floor)


def _bent_and_moved(scene, sphere, cube, floor):
    by_keys(sphere)
    move_and_turn(sphere)
    _bent(scene, sphere, cube, floor)
    move_and_turn(cube)


def _instances(scene, sphere, cube, floor):
    by_keys(sphere)
    own = bpy.data.collections.new("Own")
    own.objects.link(sphere)
    scene.collection.objects.unlink(sphere)
    for place, scale, turn in (
        ((-0.4, 0.2, 0.0), (0.6, 0.6, 0.6), 0.0),
        ((1.6, -0.8, -0.2), (-0.5, 0.5, 0.7), 0.8),
        ((2.4, 0.9, 0.3), (0.5, 0.7, 0.5), -0.4),
    ):
        empty = bpy.data.objects.new("Instance", None)
        scene.collection.objects.link(empty)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty.location, empty.scale, empty.rotation_euler[2] = place, scale, turn
    move_and_turn(scene.objects["Instance"])
    cube.hide_render = True


def _flat(scene, sphere, cube, floor):
    sphere.data.shade_flat()
    _shape_keys(scene, sphere, cube, floor)


def _counts(scene, sphere, cube, floor):
    """A remesher, of which the vertices are others at each time."""
    by_keys(sphere)
    modifier = sphere.modifiers.new("Remesh", "REMESH")
    modifier.mode, modifier.voxel_size = "VOXEL", 0.15


def _not_all(scene, sphere, cube, floor):
    _shape_keys(scene, sphere, cube, floor)
    cube.cycles.use_deform_motion = False


def _curves(scene, sphere, cube, floor):
    cube.hide_render = sphere.hide_render = True
    scene.cycles_curves.shape = "THICK"
    radii = np.broadcast_to(np.linspace(0.12, 0.03, 5), (24, 5))
    lean(add_curves(floor.data.materials[0], bent_strands(24, 5), radii))


def _hair(scene, sphere, cube, floor):
    by_keys(sphere)
    scene.cycles_curves.shape = "THICK"
    add_particle_hair(sphere, 200, radius_scale=0.04)


def _points(scene, sphere, cube, floor):
    cube.hide_render = sphere.hide_render = True
    places = np.random.default_rng(3).uniform((-2.0, -1.0, -0.9), (2.0, 1.5, 0.9), (60, 3))
    radii = np.random.default_rng(4).uniform(0.06, 0.3, 60).astype(np.float32)
    lean(add_points(floor.data.materials[0], places.astype(np.float32), radii))


def _velocities(scene, sphere, cube, floor):
    with_velocity(sphere)
    cut(cube, 3)
    with_velocity(cube)


def _lamp(kind, **properties):
    def change(scene, sphere, cube, floor):
        light = bpy.data.lights.new("Lamp", kind)
        light.energy = 300.0
        for key, value in properties.items():
            setattr(light, key, value)
        lamp = bpy.data.objects.new("Lamp", light)
        scene.collection.objects.link(lamp)
        lamp.visible_camera = False
        for frame, t in enumerate((-1.0, 0.0, 1.0)):
            lamp.location = (1.5 * t, -1.5 + t, 2.5)
            lamp.rotation_euler = (0.5, 0.6 * t, 0.0)
            lamp.keyframe_insert("location", frame=frame)
            lamp.keyframe_insert("rotation_euler", frame=frame)
        linear(lamp)

    return change


def _shining(moves, keys):
    def change(scene, sphere, cube, floor):
        glow = bpy.data.materials.new("Glow")
        if bpy.app.version < (5, 0):
            glow.use_nodes = True
        nodes = glow.node_tree.nodes
        emission = nodes.new("ShaderNodeEmission")
        emission.inputs["Strength"].default_value = 4.0
        glow.node_tree.links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])
        sphere.data.materials[0] = glow
        sphere.scale = (0.4, 0.4, 0.4)
        if keys:
            by_keys(sphere, 1.5)
        if moves:
            move_and_turn(sphere)

    return change


_case("of an armature", _bent)
_case("of shape keys", _shape_keys)
_case("of shape keys, flat faces", _flat)
_case(
    "of shape keys, 5 steps, from the frame on", _shape_keys, steps=2, motion_blur_position="START"
)
_case("of shape keys, not of one", _not_all)
_case("of shape keys, checks that glow", _shape_keys, _glow_on_map, lit=False)
_case("of shape keys, glossy, bump", _shape_keys, _glossy)
_case("of shape keys, normal map", _shape_keys, _mapped)
_case("of shape keys, cut out", _shape_keys, _cut_out)
_case("of waves", _waves)
_case("of waves, 9 steps", _waves, steps=3)
_case("of shapes and objects", _bent_and_moved)
_case("of shapes, instances", _instances)
_case("of a remeshed shape, sharp", _counts)
_case("of geometry nodes", lambda scene, sphere, cube, floor: lean(sphere))
_case("of velocities", _velocities)
_case("of curves", _curves)
_case("of particle hair", _hair)
_case("of points", _points)
_case("of an area lamp, which stands", _lamp("AREA", size=1.0), lit=False, by_lamps=True)
_case(
    "of a spot, which stands",
    _lamp("SPOT", spot_size=math.radians(50.0), shadow_soft_size=0.1),
    lit=False,
    by_lamps=True,
)
_case("of an object that shines", _shining(True, False), lit=False, by_lamps=True)
_case("of a shape that shines", _shining(True, True), lit=False, by_lamps=True)

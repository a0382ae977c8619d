"""Simplify: objects that are culled by camera and distance, and images that are made smaller."""

from __future__ import annotations

import bpy

from .cases import lit_by, shown, world
from .lamp_cases import add_lamp, matte
from .scene import picture


def _simplify(**settings):
    scene = bpy.context.scene
    scene.render.use_simplify = True
    for name, value in settings.items():
        setattr(scene.cycles, name, value)


def _wall(location, size=1.6):
    """Throws its shadow into the picture from beside it, or from behind the camera."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    bpy.context.object.data.materials.append(bpy.data.materials["M"])
    return bpy.context.object


def _flag(objects, camera=False, distance=False):
    for obj in objects:
        obj.cycles.use_camera_cull, obj.cycles.use_distance_cull = camera, distance


def _culled(name, change):
    """Under a sun from the left and from behind the camera, which walls are before."""

    def build(scene, tree):
        tree.surface(matte(tree))
        add_lamp(scene, "SUN", (-3.0, -2.6, 1.5), energy=3.0, angle=0.02)
        _wall((-3.4, -2.2, 0.0))
        _wall((-2.5, -7.4, 2.0), 1.0)
        change(scene, bpy.data.objects)

    lit_by(f"Culling, {name}", build)


def _by_camera(margin):
    def change(scene, objects):
        _simplify(use_camera_cull=True, camera_cull_margin=margin)
        _flag([objects["Cube.001"], objects["Cube.002"]], camera=True)

    return change


for _margin in (0.0, 0.1, 0.3, 1.0):
    _culled(f"camera, margin {_margin}", _by_camera(_margin))


def _orthographic(scene, objects):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 5.0
    _by_camera(0.1)(scene, objects)


def _panoramic(scene, objects):
    scene.camera.data.type = "PANO"
    data = scene.camera.data
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    _by_camera(0.0)(scene, objects)


def _by_distance(metres):
    def change(scene, objects):
        _simplify(use_distance_cull=True, distance_cull_margin=metres)
        _flag([o for o in objects if o.type == "MESH"], distance=True)

    return change


def _by_both(scene, objects):
    _simplify(use_camera_cull=True, use_distance_cull=True, distance_cull_margin=4.2)
    _flag([o for o in objects if o.type == "MESH"], True, True)


def _not_allowed(scene, objects):
    _simplify(use_camera_cull=True, use_distance_cull=True, distance_cull_margin=1.0)


def _lamp(scene, objects):
    _simplify(use_camera_cull=True, use_distance_cull=True, distance_cull_margin=1.0)
    _flag([objects["Lamp"]], True, True)


def _instances(scene, objects):
    own = bpy.data.collections.new("Own")
    wall = objects["Cube.001"]
    scene.collection.objects.unlink(wall)
    own.objects.link(wall)
    for x in (0.0, 2.2):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty.location.x = x
        scene.collection.objects.link(empty)
    _by_camera(0.1)(scene, objects)


_culled("orthographic camera", _orthographic)
_culled("panoramic camera: nothing is", _panoramic)
for _metres in (0.0, 4.2, 5.5):
    _culled(f"distance {_metres}", _by_distance(_metres))
_culled("camera and distance: both must agree", _by_both)
_culled("objects that do not allow it stay", _not_allowed)
_culled("lamps stay", _lamp)
_culled("of two instances one", _instances)


def _small_picture(limit, resolution=1.0, color_space="Non-Color", **options):
    def make(tree):
        _simplify(texture_limit_render=limit)
        if hasattr(bpy.context.scene.cycles, "texture_resolution_render"):
            bpy.context.scene.cycles.texture_resolution_render = resolution
        image = picture(width=300, height=200, **options)
        image.colorspace_settings.name = color_space
        node = tree.node("ShaderNodeTexImage", image=image, interpolation="Closest")
        tree.link(tree.coordinates("UV"), node.inputs[0])
        return node.outputs["Color"]

    return make


shown("Texture Limit, bytes", _small_picture("128"))
shown("Texture Limit, sRGB", _small_picture("128", color_space="sRGB"))
shown("Texture Limit, floats", _small_picture("256", float_buffer=True))
shown("Texture Limit, alpha", _small_picture("128", alpha=True, color_space="sRGB"))
if bpy.app.version >= (5, 0):
    shown("Texture Resolution", _small_picture("OFF", 0.02))
    shown("Texture Resolution and Limit", _small_picture("256", 0.2, color_space="sRGB"))


def _small_sky(color_space, **options):
    def make(tree):
        _simplify(texture_limit_render="128")
        image = picture(width=512, height=256, **options)
        image.colorspace_settings.name = color_space
        node = tree.node("ShaderNodeTexEnvironment", image=image, interpolation="Closest")
        return node.outputs["Color"]

    return make


world("Texture Limit, world", _small_sky("Non-Color", float_buffer=True))
world("Texture Limit, world, sRGB", _small_sky("sRGB"))

"""Cameras: panoramas from the middle of the scene, depth of field."""

from __future__ import annotations

import math

import bpy

from .cases import CASES, Case

_CENTRE = (0.15, -1.3, 0.1)


def _shows_place(tree):
    """Light that tells where a point is: another ray is another colour."""
    place = tree.made("ShaderNodeNewGeometry", "Position")
    half = tree.made("ShaderNodeVectorMath", 0, {0: place, "Scale": 0.3}, operation="SCALE")
    tree.glow(tree.made("ShaderNodeVectorMath", 0, {0: half}, operation="ABSOLUTE"))


def _checker(tree):
    checks = {"Vector": tree.coordinates(), "Scale": 4.0}
    return tree.made("ShaderNodeTexChecker", 0, checks)


def _diffuse_checks(tree):
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": _checker(tree)}))


def _askew(name, kind, material, lit=True):
    """A camera under a parent that is scaled unevenly, and not along its axes."""

    def build(scene, tree):
        material(tree)
        camera = scene.camera
        camera.data.type, camera.data.ortho_scale = kind, 5.0
        parent = bpy.data.objects.new("Parent", None)
        scene.collection.objects.link(parent)
        parent.scale, parent.rotation_euler = (1.0, 1.6, 0.8), (0.2, 0.1, 0.6)
        bpy.context.view_layer.update()
        camera.parent = parent
        camera.location = parent.matrix_world.inverted() @ camera.location

    CASES.append(Case(f"Camera {name}", build, lit=lit))


def _gloss(tree):
    tree.surface(tree.made("ShaderNodeBsdfGlossy", 0, {"Roughness": 0.4}))


def _depth(tree):
    near = tree.made("ShaderNodeCameraData", "View Z Depth")
    tree.glow(tree.made("ShaderNodeMath", 0, {0: near, 1: 0.1}, operation="MULTIPLY"))


def _panorama(name, kind, material=_shows_place, lit=False, blurred=False, dof=None, **properties):
    def build(scene, tree):
        material(tree)
        camera = scene.camera
        camera.location, camera.rotation_euler = _CENTRE, (math.radians(80), 0.1, 0.3)
        data = camera.data
        data.type, data.clip_start = "PANO", 0.01
        owner = data if hasattr(data, "panorama_type") else data.cycles
        owner.panorama_type = kind
        for key, value in properties.items():
            setattr(data if hasattr(data, key) else owner, key, value)
        if dof:
            _open_lens(data, **dof)

    CASES.append(Case(f"Camera {name}", build, lit=lit, blurred=blurred))


def _open_lens(data, **properties):
    data.dof.use_dof = True
    for key, value in properties.items():
        setattr(data.dof, key, value)


def _blurred(name, material=_diffuse_checks, lit=True, kind="PERSP", target=False, **dof):
    def build(scene, tree):
        material(tree)
        data = scene.camera.data
        data.type, data.ortho_scale = kind, 5.0
        if target:
            dof["focus_object"] = bpy.data.objects["Sphere"]
        _open_lens(data, **dof)

    CASES.append(Case(f"Camera {name}", build, lit=lit, blurred=True))


_askew("askew, gloss", "PERSP", _gloss)
_askew("askew, orthographic, gloss", "ORTHO", _gloss)
_askew("askew, depth", "PERSP", _depth, lit=False)
_panorama("equirectangular", "EQUIRECTANGULAR")
_panorama(
    "equirectangular, a part, lens shift",
    "EQUIRECTANGULAR",
    longitude_min=-1.1,
    longitude_max=0.7,
    latitude_min=-0.5,
    latitude_max=0.9,
    shift_x=0.1,
    shift_y=-0.05,
)
_panorama("cube map face", "EQUIANGULAR_CUBEMAP_FACE")
_panorama("mirror ball", "MIRRORBALL")
_panorama("fisheye equidistant", "FISHEYE_EQUIDISTANT", fisheye_fov=3.6)
_panorama("fisheye equisolid", "FISHEYE_EQUISOLID", fisheye_lens=8.0, fisheye_fov=3.0)
_panorama(
    "fisheye equisolid, vertical fit",
    "FISHEYE_EQUISOLID",
    fisheye_lens=8.0,
    fisheye_fov=5.0,
    sensor_fit="VERTICAL",
)
_panorama("fisheye lens polynomial", "FISHEYE_LENS_POLYNOMIAL", fisheye_fov=3.3)
_panorama(
    "central cylindrical",
    "CENTRAL_CYLINDRICAL",
    central_cylindrical_range_u_min=-2.5,
    central_cylindrical_range_v_max=1.5,
    central_cylindrical_radius=1.2,
)
_panorama("fisheye equidistant before a world", "FISHEYE_EQUIDISTANT", lit=True)
_panorama("panorama clipped", "EQUIRECTANGULAR", clip_start=1.2, clip_end=2.2)


def _window(tree):
    tree.glow(tree.coordinates("Window"))


_panorama("Window coordinates, fisheye equisolid", "FISHEYE_EQUISOLID", _window)
_panorama("Window coordinates, equirectangular", "EQUIRECTANGULAR", _window)
_panorama(
    "Camera coordinates, panorama",
    "EQUIRECTANGULAR",
    lambda tree: tree.glow(
        tree.made("ShaderNodeVectorMath", 0, {0: tree.coordinates("Camera")}, operation="ABSOLUTE")
    ),
)
_blurred("depth of field", aperture_fstop=0.12, focus_distance=5.0)
_blurred(
    "depth of field, 5 blades, focus object",
    target=True,
    aperture_fstop=0.08,
    aperture_blades=5,
    aperture_rotation=0.4,
    aperture_ratio=2.0,
)
_blurred(
    "depth of field, orthographic, 3 blades",
    kind="ORTHO",
    aperture_fstop=1.2,
    aperture_blades=3,
    focus_distance=6.5,
)
_blurred(
    "depth of field of glowing checks",
    lambda tree: tree.glow(_checker(tree)),
    lit=False,
    aperture_fstop=0.1,
    focus_distance=4.0,
    aperture_blades=6,
)
_panorama(
    "depth of field, equirectangular, 3 blades",
    "EQUIRECTANGULAR",
    _diffuse_checks,
    lit=True,
    blurred=True,
    dof={"aperture_fstop": 0.12, "focus_distance": 1.0, "aperture_blades": 3},
)
_panorama(
    "depth of field, mirror ball, 3 blades",
    "MIRRORBALL",
    _diffuse_checks,
    lit=True,
    blurred=True,
    dof={
        "aperture_fstop": 0.12,
        "focus_distance": 1.0,
        "aperture_blades": 3,
        "aperture_rotation": 0.5,
    },
)


def linear(owner):
    """Have what is keyed go straight from key to key."""
    action = owner.animation_data.action
    layered = getattr(action, "layers", None)
    curves = action.layers[0].strips[0].channelbags[0].fcurves if layered else action.fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def _moving(name, material=_diffuse_checks, lit=True, kind="PERSP", zoom=1.0, steps=1, **render):
    """A camera that travels and turns; zoom: of its lens over a frame."""

    def build(scene, tree):
        material(tree)
        camera = scene.camera
        camera.cycles.motion_steps = steps
        camera.data.type, camera.data.ortho_scale = kind, 5.0
        start, turn, lens = camera.location.copy(), camera.rotation_euler.copy(), camera.data.lens
        for frame in (0, 1, 2):
            t = frame - 1.0
            camera.location = start + type(start)((0.5 * t, 0.3 * t, 0.1 * t))
            camera.rotation_euler = (turn.x, turn.y + 0.2 * t, turn.z + 0.1 * t)
            camera.keyframe_insert("location", frame=frame)
            camera.keyframe_insert("rotation_euler", frame=frame)
            if zoom != 1.0:
                camera.data.lens = lens * zoom**t
                camera.data.keyframe_insert("lens", frame=frame)
        linear(camera)
        if zoom != 1.0:
            linear(camera.data)
        scene.frame_set(1)
        scene.render.use_motion_blur = True
        for key, value in render.items():
            setattr(scene.render, key, value)

    CASES.append(Case(f"Camera {name}", build, lit=lit, blurred=True))


_moving("motion", motion_blur_shutter=0.8)
_moving(
    "motion from the frame on, glowing checks",
    lambda tree: tree.glow(_checker(tree)),
    lit=False,
    motion_blur_position="START",
    motion_blur_shutter=0.9,
)
_moving("motion up to the frame, zoom", motion_blur_position="END", zoom=1.3)
_moving("motion, orthographic, 5 steps", kind="ORTHO", steps=2, motion_blur_shutter=1.0)


def _objects_moving(name, material=_diffuse_checks, lit=True, steps=1, follow=False, **render):
    """The sphere goes along, the cube turns; follow: the camera goes with the sphere."""

    def build(scene, tree):
        material(tree)
        sphere = bpy.data.objects["Sphere"]
        others = [o for o in scene.objects if o.type == "MESH" and "ube" in o.name]
        movers = [sphere, *others, *([scene.camera] if follow else [])]
        for obj in movers:
            obj.cycles.motion_steps = steps
            place, turn = obj.location.copy(), obj.rotation_euler.copy()
            for frame in (0, 1, 2):
                t = frame - 1.0
                obj.location = place
                if obj in others:
                    obj.rotation_euler = (turn.x, turn.y + 0.3 * t, turn.z + 0.9 * t)
                    obj.keyframe_insert("rotation_euler", frame=frame)
                else:
                    obj.location = place + type(place)((0.6 * t, 0.2 * t, 0.3 * t))
                obj.keyframe_insert("location", frame=frame)
            linear(obj)
        scene.frame_set(1)
        scene.render.use_motion_blur = True
        for key, value in render.items():
            setattr(scene.render, key, value)

    CASES.append(Case(f"Camera {name}", build, lit=lit, blurred=True))


_objects_moving("objects in motion", motion_blur_shutter=0.8)
_objects_moving(
    "objects in motion, glowing checks",
    lambda tree: tree.glow(_checker(tree)),
    lit=False,
    steps=2,
    motion_blur_position="START",
    motion_blur_shutter=1.0,
)
_objects_moving("objects in motion, followed", follow=True, motion_blur_shutter=1.0)

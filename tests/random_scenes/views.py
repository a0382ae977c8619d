"""Random cameras, films, and which rays see what."""

from __future__ import annotations

import math

import bpy

from .dice import Dice

WIDTH, HEIGHT = 32, 24


def view(dice: Dice, scene) -> None:
    """A camera that looks at the scene, or stands in it, and a film."""
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    data = bpy.data.cameras.new("Camera")
    camera = scene.camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    camera.location = (0.3, -6.0, 1.6)
    camera.rotation_euler = (math.radians(77), 0.0, 0.05)
    kind = dice.of("PERSP", "PERSP", "PERSP", "ORTHO", "PANO")
    dice.tell(kind.lower())
    data.type, data.lens, data.ortho_scale = kind, dice.between(35.0, 60.0), dice.between(4, 7)
    data.shift_x, data.shift_y = (dice.between(-0.1, 0.1), 0.05) if dice.chance(0.2) else (0, 0)
    data.clip_start = dice.of(0.1, 0.1, 5.5)
    data.clip_end = dice.of(100.0, 100.0, dice.between(6.0, 9.0))
    if kind == "PANO":
        _panorama(dice, camera)
    if dice.chance(0.15):
        data.dof.use_dof, data.dof.focus_distance = True, dice.between(3.0, 8.0)
        data.dof.aperture_fstop = dice.spread(0.2, 3.0)
        data.dof.aperture_blades, data.dof.aperture_rotation = dice.of(0, 3, 6), dice.between(0, 3)
        data.dof.aperture_ratio = dice.of(1.0, dice.between(0.5, 2.0))
        dice.tell("depth of field")
    scene.render.film_transparent = dice.chance(0.3)
    scene.cycles.film_exposure = dice.of(1.0, 1.0, dice.between(0.5, 2.0))
    if dice.chance(0.15):
        scene.render.pixel_aspect_x = dice.of(1.5, 0.7)
        data.sensor_fit = dice.of("AUTO", "HORIZONTAL", "VERTICAL")
    scene.cycles.pixel_filter_type = dice.of(*["BLACKMAN_HARRIS"] * 3, "GAUSSIAN", "BOX")
    if dice.chance(0.15):
        scene.render.use_border, scene.render.use_crop_to_border = True, True
        scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.9
        scene.render.border_min_y, scene.render.border_max_y = 0.1, 0.8
        dice.tell("border")


def _panorama(dice, camera):
    data = camera.data
    owner = data if hasattr(data, "panorama_type") else data.cycles
    kinds = ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL")
    more = ("EQUIANGULAR_CUBEMAP_FACE", "FISHEYE_LENS_POLYNOMIAL", "CENTRAL_CYLINDRICAL")
    owner.panorama_type = dice.of(*kinds, *more)
    dice.tell(owner.panorama_type.lower())
    # Cycles' bumps ask the next pixel's ray, which beyond a fisheye's circle has no direction.
    dice.bumps = False
    camera.location = (0.1, -2.5, 0.4)
    data.clip_start, data.clip_end = 0.05, dice.of(100.0, 4.0)


def flags(dice: Dice, scene) -> None:
    """Shadow catchers, holdouts, what the camera does not see.

    Before a world Cycles takes the world behind a catcher twice by the part of a pixel that it
    fills: dark edges of what stands before it, which IWIS has not. So catchers are for films alone.
    """
    film = scene.render.film_transparent
    kinds = ("camera", "holdout", "catcher") if film else ("camera", "holdout")
    for obj in scene.objects:
        if obj.type in ("LIGHT", "CAMERA", "EMPTY") or not dice.chance(0.12):
            continue
        kind = dice.of(*kinds)
        dice.tell(f"no camera: {obj.name}" if kind == "camera" else f"{kind}: {obj.name}")
        if kind == "camera":
            obj.visible_camera = False
        elif kind == "holdout":
            obj.is_holdout = True
        else:
            obj.is_shadow_catcher = True

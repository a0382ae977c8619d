"""The camera of one view of a stereo pair, or of one of several cameras."""

from __future__ import annotations

import dataclasses

import bpy
import numpy as np

from ..core.scene import Camera, Scene
from .export.cameras.camera import camera_matrix, camera_optics


def at_once(view: str) -> bool:
    """Whether a view is to be handed to Blender whole, not tile by tile.

    Blender 5.2's window stands for good where its image editor shows a stereo pair while parts of
    it arrive: it takes the lock of the picture twice. Cycles' pictures arrive whole.
    """
    return bool(view) and not bpy.app.background


def camera_of_view(engine, scene, exported: Scene, view: str) -> Camera:
    """The camera of a view: the exported one, moved and shifted as Blender does for an eye.

    scene: Blender's evaluated scene; view: name of the view, "" where there is only one
    """
    if not view or not scene.render.use_multiview:
        return exported.camera
    engine.active_view_set(view)
    camera = engine.camera_override or scene.camera  # of this view, where each has its own
    lens = exported.camera
    if camera.name != scene.camera.name:
        # The motion that was exported is that of the scene's own camera.
        lens = dataclasses.replace(lens, **camera_optics(camera, scene.render, []), motion=None)
    matrix = np.array(engine.camera_model_matrix(camera), dtype=np.float64).reshape(4, 4)
    move = engine.camera_shift_x(camera) - camera.data.shift_x
    if lens.motion is not None:
        eye = np.linalg.inv(camera_matrix(camera)) @ matrix
        # The lens was exported in the middle of the shutter's time, this is the frame's.
        matrix = lens.camera_to_world @ eye
        moved = lens.motion.matrices @ eye
        lens = dataclasses.replace(lens, motion=lens.motion._replace(matrices=moved))
    return _placed(lens, matrix, move, camera.data)


def _placed(camera: Camera, matrix, shift_x, data) -> Camera:
    """The camera at `matrix`, its window moved by `shift_x` times its fitted side."""
    left, right, bottom, top = camera.window
    along_x = data.sensor_fit == "HORIZONTAL" or (
        data.sensor_fit == "AUTO" and right - left >= top - bottom
    )
    move = shift_x * (right - left if along_x else top - bottom)
    motion = camera.motion
    if motion is not None:
        motion = motion._replace(windows=motion.windows + np.array([move, move, 0.0, 0.0]))
    window = left + move, right + move, bottom, top
    return dataclasses.replace(camera, camera_to_world=matrix, window=window, motion=motion)

"""The camera of one view of a stereo pair, or of one of several cameras."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..core.scene import Camera, Scene


def camera_of_view(engine, scene, exported: Scene, view: str) -> Camera:
    """The exported camera, moved and shifted as Blender does for the view.

    scene: Blender's evaluated scene; view: name of the view, "" where there is only one
    """
    if not view or not scene.render.use_multiview:
        return exported.camera
    engine.active_view_set(view)
    blender_camera = engine.camera_override or scene.camera
    matrix = np.array(engine.camera_model_matrix(blender_camera), dtype=np.float64).reshape(4, 4)
    return _placed(exported.camera, matrix, engine.camera_shift_x(blender_camera), blender_camera)


def _placed(camera, matrix, shift_x, blender_camera):
    left, right, bottom, top = camera.window
    along_x = blender_camera.data.sensor_fit == "HORIZONTAL" or (
        blender_camera.data.sensor_fit == "AUTO" and right - left >= top - bottom
    )
    fitted = right - left if along_x else top - bottom
    move = (shift_x - blender_camera.data.shift_x) * fitted
    return dataclasses.replace(
        camera, camera_to_world=matrix, window=(left + move, right + move, bottom, top)
    )

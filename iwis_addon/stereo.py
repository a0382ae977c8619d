"""The camera of one view of a stereo pair, or of one of several cameras."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..core.scene import ORTHOGRAPHIC, PERSPECTIVE, Camera, Scene


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
        lens = _with_lens_of(lens, scene, camera.data)
    matrix = np.array(engine.camera_model_matrix(camera), dtype=np.float64).reshape(4, 4)
    return _placed(lens, matrix, engine.camera_shift_x(camera) - camera.data.shift_x, camera.data)


def _with_lens_of(exported: Camera, scene, data) -> Camera:
    """The exported frame seen through another camera's lens."""
    corners = np.array(data.view_frame(scene=scene), dtype=np.float64)
    orthographic = data.type == "ORTHO"
    if not orthographic:
        corners /= -corners[:, 2:]
    (left, bottom), (right, top) = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    return dataclasses.replace(
        exported,
        kind=ORTHOGRAPHIC if orthographic else PERSPECTIVE,
        window=(left, right, bottom, top),
        clip_start=data.clip_start,
        clip_end=data.clip_end,
    )


def _placed(camera: Camera, matrix, shift_x, data) -> Camera:
    """The camera at `matrix`, its window moved by `shift_x` times its fitted side."""
    left, right, bottom, top = camera.window
    along_x = data.sensor_fit == "HORIZONTAL" or (
        data.sensor_fit == "AUTO" and right - left >= top - bottom
    )
    move = shift_x * (right - left if along_x else top - bottom)
    return dataclasses.replace(
        camera, camera_to_world=matrix, window=(left + move, right + move, bottom, top)
    )

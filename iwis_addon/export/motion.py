"""The camera's motion while the shutter is open, read as Cycles reads it.

Blender is set to frames and parts of frames around the middle of the shutter's time, where all else
is exported, and back. The camera's own Motion Blur settings (object properties, Cycles) say at how
many times its place is read; between two of them it turns evenly.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable

import numpy as np
from mathutils import Matrix

from ...core.scene import PERSPECTIVE, Camera, CameraMotion, Scene
from .camera import camera_matrix, camera_optics

# The middle of the shutter's time, in units of it, from the frame.
_MIDDLE = {"START": 0.5, "CENTER": 0.0, "END": -0.5}
_CURVE_POINTS = 257
# Between two places of the table the matrix is interpolated: after a degree it is off by 4e-5.
_STEP_RAD, _MOST_STEPS = math.radians(1.0), 64
_WITHOUT_SURFACE = {"CAMERA", "LIGHT", "EMPTY", "ARMATURE", "SPEAKER", "LATTICE", "LIGHT_PROBE"}


def export_in_motion(engine, depsgraph, warnings: list[str], export: Callable[[], Scene]) -> Scene:
    """What export() gives in the middle of the shutter's time, its camera with its motion.

    engine: the RenderEngine, whose frame_set moves depsgraph and scene; they are set back. Without
    motion blur nothing is moved. warnings: gets a line where objects move, which are not blurred
    """
    scene, render = depsgraph.scene_eval, depsgraph.scene_eval.render
    layer = depsgraph.view_layer_eval
    if not render.use_motion_blur or not getattr(layer, "use_motion_blur", True):
        return export()
    now = scene.frame_current + scene.frame_subframe
    middle = now + _MIDDLE[render.motion_blur_position] * render.motion_blur_shutter
    try:
        if middle != now:
            _go_to(engine, middle)
        exported = export()
        motion = _camera_motion(engine, depsgraph, exported.camera, middle, warnings)
    finally:
        _go_to(engine, now)
    camera = dataclasses.replace(exported.camera, motion=motion)
    return dataclasses.replace(exported, camera=camera)


def _go_to(engine, time: float) -> None:
    frame = math.floor(time)
    engine.frame_set(frame, time - frame)


def _camera_motion(engine, depsgraph, middle: Camera, time: float, warnings) -> CameraMotion | None:
    """None where the camera stands still."""
    scene = depsgraph.scene_eval
    own = getattr(scene.camera, "cycles", None)
    moves = own is None or own.use_motion_blur
    steps = (2 << (max(own.motion_steps if own else 1, 1) - 1)) + 1 if moves else 3
    half = 0.5 * scene.render.motion_blur_shutter
    matrices, windows, places = [], [], []
    for relative in np.linspace(-1.0, 1.0, steps):
        if relative != 0.0:
            _go_to(engine, time + relative * half)
        if abs(relative) == 1.0:
            places.append(_places(depsgraph))
        if not moves:
            continue
        if relative == 0.0:  # the graph stands elsewhere: this is what was exported
            matrices.append(middle.camera_to_world)
            windows.append(middle.window)
            continue
        camera = depsgraph.scene_eval.camera
        matrices.append(camera_matrix(camera))
        windows.append(camera_optics(camera, depsgraph.scene_eval.render, [])["window"])
    _tell(scene, places, warnings)
    if not moves:
        return None
    if middle.kind != PERSPECTIVE:  # Cycles blurs no other change of what the frame shows
        windows = [middle.window] * steps
    return _as_table(matrices, windows, shutter_times(scene.render))


def _as_table(matrices, windows, times) -> CameraMotion | None:
    if np.allclose(matrices, matrices[:1], atol=1e-9) and np.allclose(windows, windows[0]):
        return None
    parts = [Matrix(matrix).decompose() for matrix in matrices]
    pairs = list(itertools.pairwise(parts))
    angle = max(a[1].rotation_difference(b[1]).angle for a, b in pairs)
    fine = min(max(math.ceil(angle / _STEP_RAD), 1), _MOST_STEPS)
    table = []
    for (place_a, turn_a, size_a), (place_b, turn_b, size_b) in pairs:
        for k in range(fine):
            t = k / fine
            turn = turn_a.slerp(turn_b, t)
            table.append(Matrix.LocRotScale(place_a.lerp(place_b, t), turn, size_a.lerp(size_b, t)))
    table.append(Matrix(matrices[-1]))
    # As Cycles: the window changes evenly from the first to the middle, and from there to the last.
    key = np.array([windows[0], windows[len(windows) // 2], windows[-1]])
    t = np.linspace(0.0, 2.0, len(table))
    shown = np.stack([np.interp(t, (0.0, 1.0, 2.0), column) for column in key.T], -1)
    return CameraMotion(np.array([np.array(m) for m in table], np.float64), shown, times)


def shutter_times(render) -> np.ndarray:
    """CameraMotion.times of the shutter's curve: how much light it lets in, over its time."""
    x, curve = np.linspace(0.0, 1.0, _CURVE_POINTS), render.motion_blur_shutter_curve
    curve.initialize()
    open_ = np.array([max(curve.evaluate(curve.curves[0], place), 0.0) for place in x])
    light = np.concatenate([[0.0], np.cumsum(0.5 * (open_[1:] + open_[:-1]))])
    if not light[-1] > 0.0:
        return x
    return np.interp(x, light / light[-1], x)


def _places(depsgraph) -> dict:
    """Where the objects with a surface are, by name."""
    return {
        (obj.name, obj.library): obj.matrix_world.copy()
        for obj in depsgraph.objects
        if obj.type not in _WITHOUT_SURFACE
    }


def _tell(scene, places, warnings) -> None:
    before, after = places
    moved = sorted(key[0] for key, place in before.items() if place != after.get(key, place))
    if moved:
        names = ", ".join(moved[:3]) + (", ..." if len(moved) > 3 else "")
        warnings.append(
            f"Scene {scene.name}: motion blur is the camera's only; {len(moved)} moving objects "
            f"stand still as in the middle of the shutter's time: {names}"
        )
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and cycles.rolling_shutter_type != "NONE":
        warnings.append(f"Scene {scene.name}: rolling shutter is ignored")

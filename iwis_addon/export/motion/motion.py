"""The motion of camera and objects while the shutter is open, read as Cycles reads it.

Blender is set to frames and parts of frames around the middle of the shutter's time, where all else
is exported, and back. The Motion Blur settings of camera and objects (object properties, Cycles)
say at how many times their places are read; between two of them a camera turns evenly.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable

import numpy as np
from mathutils import Matrix

from ....core.scene import PERSPECTIVE, CameraMotion, Scene
from ..cameras.camera import camera_matrix, camera_optics
from ..placed.mesh import MeshExport
from .changing_shapes import ChangingShapes
from .object_motion import Motions, object_motion, read_places, read_steps, steps_of

# The middle of the shutter's time, in units of it, from the frame.
_MIDDLE = {"START": 0.5, "CENTER": 0.0, "END": -0.5}
_CURVE_POINTS = 257
# Between two places of the table the matrix is interpolated: after a degree it is off by 4e-5.
_STEP_RAD, _MOST_STEPS = math.radians(1.0), 64


def export_in_motion(engine, depsgraph, warnings: list[str], export: Callable[..., Scene]) -> Scene:
    """What export() gives in the middle of the shutter's time, with motion of camera and objects.

    engine: the RenderEngine, whose frame_set moves depsgraph and scene; they are set back. Without
    motion blur nothing is moved. export(geometry=[]): fills in what the mesh table was made of
    warnings: gets a line where something moves or changes its shape and is not blurred
    Lamps are as in the middle, as in Cycles.
    """
    render, layer = depsgraph.scene_eval.render, depsgraph.view_layer_eval
    if not render.use_motion_blur or not getattr(layer, "use_motion_blur", True):
        return export(geometry=[])
    begin = len(warnings)
    found = _in_motion(engine, depsgraph, warnings, export)
    if found.copies is None or not found.copies.move(found.motion, found.mesh.object_index):
        return found
    del warnings[begin:]  # what moves must not be a copy
    whole = functools.partial(export, written_out=True)
    return _in_motion(engine, depsgraph, warnings, whole)


def _in_motion(engine, depsgraph, warnings: list[str], export: Callable[..., Scene]) -> Scene:
    """See export_in_motion. warnings: what export() tells of, too"""
    scene, render = depsgraph.scene_eval, depsgraph.scene_eval.render
    geometry: list[MeshExport] = []
    own = own_camera(depsgraph)
    now = scene.frame_current + scene.frame_subframe
    middle = now + _MIDDLE[render.motion_blur_position] * render.motion_blur_shutter
    try:
        if middle != now:
            go_to(engine, middle)
        exported = export(geometry=geometry, own_camera=own)
        steps = read_steps(depsgraph)
        shapes = ChangingShapes(depsgraph, geometry[0], steps, render.motion_blur_shutter)
        cameras = own, exported.camera
        camera, objects = _motions(engine, depsgraph, cameras, middle, steps, shapes)
    finally:
        go_to(engine, now)
    times = shutter_times(render)
    copies = 0 if exported.copies is None else len(exported.copies.objects)
    own = geometry[0].inventory.instances, objects, times, shapes.tables()
    moved, still = object_motion(*own, copies)
    _tell(depsgraph.scene_eval, still, warnings)
    warnings.extend(shapes.lines(depsgraph.scene_eval.name))
    motion = _as_table(*camera, times, keep=moved is not None)
    camera = dataclasses.replace(exported.camera, motion=motion)
    return dataclasses.replace(exported, camera=camera, motion=moved)


def go_to(engine, time: float) -> None:
    """Move depsgraph and scene to a frame, or a part of one."""
    frame = math.floor(time)
    engine.frame_set(frame, time - frame)


def own_camera(depsgraph):
    """The object of the frame's camera: other frames may have another one, by a marker."""
    camera = depsgraph.scene_eval.camera
    return camera and camera.original


def _motions(engine, depsgraph, cameras, time: float, steps, shapes: ChangingShapes):
    """((matrices, windows) of the camera at its steps, Motions of the objects).

    cameras: the object, and the Camera of the middle; steps: of Motions; shapes: looks at each time
    """
    own, middle = cameras
    camera_steps = steps_of(getattr(own, "cycles", None))
    most = max(camera_steps, *steps.values(), 3)
    half = 0.5 * depsgraph.scene_eval.render.motion_blur_shutter
    seen, places = [], []
    for number, relative in enumerate(np.linspace(-1.0, 1.0, most)):
        if relative != 0.0:
            go_to(engine, time + relative * half)
            seen.append(camera_now(depsgraph, own))
            places.append(read_places(depsgraph, steps))
            shapes.look(depsgraph, number, most)
        else:  # the graph stands elsewhere: this is what was exported
            seen.append((middle.camera_to_world, middle.window))
            places.append(None)
    if camera_steps:
        seen = seen[:: (most - 1) // (camera_steps - 1)]
    else:
        seen = [(middle.camera_to_world, middle.window)]
    matrices, windows = zip(*seen, strict=True)
    if middle.kind != PERSPECTIVE:  # Cycles blurs no other change of what the frame shows
        windows = [middle.window] * len(windows)
    return (list(matrices), list(windows)), Motions(steps, places)


def camera_now(depsgraph, own):
    """(camera_to_world, window) of own_camera as the graph has it."""
    camera = own.evaluated_get(depsgraph)
    return camera_matrix(camera), camera_optics(camera, depsgraph.scene_eval.render, [])["window"]


def _as_table(matrices, windows, times, keep: bool) -> CameraMotion | None:
    """None where the camera stands still; keep: not then either, for objects move before it."""
    if np.allclose(matrices, matrices[:1], atol=1e-9) and np.allclose(windows, windows[0]):
        if not keep:
            return None
        return CameraMotion(np.array(matrices[:1]), np.array(windows[:1], np.float64), times)
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


def _tell(scene, still: list[str], warnings) -> None:
    if still:
        names = ", ".join(still[:3]) + (", ..." if len(still) > 3 else "")
        warnings.append(
            f"Scene {scene.name}: {len(still)} moving objects are not blurred, for they have no "
            f"size or are not there all the time that the shutter is open: {names}"
        )
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and cycles.rolling_shutter_type != "NONE":
        warnings.append(f"Scene {scene.name}: rolling shutter is ignored")

"""The Vector pass: where camera, objects and shapes are a frame before and a frame later."""

from __future__ import annotations

import dataclasses
import functools
from collections import Counter
from collections.abc import Callable

import numpy as np

from ....core.data.object_motion import PixelMotion
from ....core.scene import Scene
from ..placed.mesh import MeshExport
from .changing_shapes import ChangingShapes
from .motion import camera_now, go_to, own_camera
from .object_motion import Key, read_places

_STILL = 1e-9  # of a matrix


def wants_vectors(depsgraph) -> bool:
    """Whether the Vector pass is asked for, and not motion blur, with which it is 0, as Cycles'."""
    layer, render = depsgraph.view_layer_eval, depsgraph.scene_eval.render
    blurred = render.use_motion_blur and getattr(layer, "use_motion_blur", True)
    return layer.use_pass_vector and not blurred


def export_with_vectors(
    engine, depsgraph, warnings: list[str], export: Callable[..., Scene]
) -> Scene:
    """What export() gives, with pixel_motion. The rest as for export_in_motion; warnings: what
    export() tells of"""
    begin = len(warnings)
    found = _with_vectors(engine, depsgraph, export)
    if found.copies is None or not found.pixel_motion.shapes:
        return found
    del warnings[begin:]  # what changes its shape must not be a copy
    return _with_vectors(engine, depsgraph, functools.partial(export, written_out=True))


def _with_vectors(engine, depsgraph, export: Callable[..., Scene]) -> Scene:
    geometry: list[MeshExport] = []
    scene = depsgraph.scene_eval
    own = own_camera(depsgraph)
    exported = export(geometry=geometry)
    camera, instances = exported.camera, geometry[0].inventory.instances
    keys = Counter(Key(instance.name, instance.number) for instance in instances)
    steps = {key: 3 for key, count in keys.items() if count == 1}
    shapes = ChangingShapes(depsgraph, geometry[0], steps, shutter=2.0)
    now = scene.frame_current + scene.frame_subframe
    moves, windows, places = [], [], []
    try:
        for number, time in ((0, now - 1.0), (2, now + 1.0)):
            go_to(engine, time)
            to_world, window = camera_now(depsgraph, own)
            moves.append(to_world @ np.linalg.inv(camera.camera_to_world))
            windows.append(np.subtract(window, camera.window))
            places.append(read_places(depsgraph, steps))
            shapes.look(depsgraph, number, 3)
    finally:
        go_to(engine, now)
    rows = _matrices(instances, places)
    motion = PixelMotion(*rows, shapes.tables(), np.array(moves), np.array(windows))
    return dataclasses.replace(exported, pixel_motion=motion)


def _matrices(instances, places):
    """(row of each instance, float64 (2, m, 4, 4)) of PixelMotion."""
    row, found = np.full(len(instances), -1, np.int32), []
    for number, instance in enumerate(instances):
        middle = instance.object_to_world
        there = [at.get(Key(instance.name, instance.number), middle) for at in places]
        size = max(float(np.abs(middle).max()), 1.0)
        still = np.abs(np.array(there) - middle).max() <= _STILL * size
        if still or not np.isfinite(there).all() or not abs(np.linalg.det(middle)) > 0.0:
            continue
        row[number] = len(found)
        found.append(there @ np.linalg.inv(middle))
    matrices = np.array(found).reshape(-1, 2, 4, 4).transpose(1, 0, 2, 3)
    return row, np.ascontiguousarray(matrices)

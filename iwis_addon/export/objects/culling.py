"""Simplify's culling: objects that Cycles leaves out as they are outside of the picture, or far.

What is left out throws no shadow either. Each object says by which of the two it may be; of one
that may be by both, both must agree. Boxes are those of the objects' own bounds, in world space.
"""

from __future__ import annotations

import numpy as np

from ....core.scene import ORTHOGRAPHIC, PERSPECTIVE, Camera


class Culling:
    """margin: of the picture's size, beyond its edges; distance: metres from the camera; None:
    nothing is left out by it"""

    def __init__(self, camera: Camera, margin: float | None, distance: float | None):
        self._camera, self._margin, self._distance = camera, margin, distance
        self._to_camera = np.linalg.inv(camera.camera_to_world)

    def leaves_out(self, item) -> bool:
        """Of depsgraph.object_instances; lamps are always there."""
        obj = item.object
        own = getattr(obj.original, "cycles", None)  # of an add-on: the graph's copy may be old
        if own is None or obj.type == "LIGHT":
            return False
        tests = []
        if self._margin is not None and own.use_camera_cull:
            tests.append(self._is_outside)
        if self._distance is not None and own.use_distance_cull:
            tests.append(self._is_far)
        if not tests:
            return False
        matrix = np.array(item.matrix_world, np.float64)
        corners = np.array(obj.bound_box, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        return all(test(corners) for test in tests)

    def _is_far(self, corners) -> bool:
        eye = self._camera.camera_to_world[:3, 3]
        nearest = np.clip(eye, corners.min(0), corners.max(0))
        return bool(((eye - nearest) ** 2).sum() > self._distance**2)

    def _is_outside(self, corners) -> bool:
        """Places in the picture are from 0 to 1; those of what is before the near plane turn round,
        as in Cycles."""
        camera, margin = self._camera, self._margin
        x, y, z = (corners @ self._to_camera[:3, :3].T + self._to_camera[:3, 3]).T
        left, right, bottom, top = camera.window
        depth = (-z - camera.clip_start) / (camera.clip_end - camera.clip_start)
        if camera.kind == PERSPECTIVE:
            depth *= camera.clip_end
            with np.errstate(divide="ignore", invalid="ignore"):
                x, y = x / -z, y / -z
        if (depth < -margin).all():
            return True
        place = np.stack([(x - left) / (right - left), (y - bottom) / (top - bottom)])
        place = np.where(depth < 0.0, 1.0 - place, place)
        low, high = place.min(1), place.max(1)
        return bool((low >= 1.0 + margin).any() or (high <= -margin).any())


def culling_of(depsgraph, camera: Camera) -> Culling | None:
    """What the scene says of it; None: nothing is left out.

    camera: of the render, or of a window, where it may have no place yet
    """
    scene = depsgraph.scene
    own = getattr(scene, "cycles", None)  # Cycles' own, there as long as its add-on is enabled
    if own is None or not scene.render.use_simplify or scene.render.use_multiview:
        return None
    if camera.camera_to_world is None or camera.kind not in (PERSPECTIVE, ORTHOGRAPHIC):
        return None
    margin = own.camera_cull_margin if own.use_camera_cull else None
    far = own.use_distance_cull and own.distance_cull_margin > 0.0
    distance = own.distance_cull_margin if far else None
    if margin is None and distance is None:
        return None
    return Culling(camera, margin, distance)

"""Adaptive subdivision: which objects Cycles dices, and how fine."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from ....core.scene import Camera
from ..cameras.camera import export_camera

_LEAST_PIXELS = 0.1  # as in Cycles


class Fineness(NamedTuple):
    """What decides how fine an object is diced.

    linear: whether faces stay as they are; size: pixels, or in_space lengths of its own, to an edge
    max_level: an edge has 2**max_level parts at most; keeps_corners, creases, uv_smooth: of the
        modifier
    """

    linear: bool
    size: float
    in_space: bool
    max_level: int
    keeps_corners: bool
    creases: bool
    uv_smooth: str


class Dicing:
    """The camera and the scene's settings that objects are diced by."""

    def __init__(self, depsgraph, camera: Camera):
        # An add-on's own properties change without an update of the graph, whose copies are old.
        self._settings = getattr(depsgraph.scene, "cycles", None)
        self._window = depsgraph.mode == "VIEWPORT"
        own = getattr(self._settings, "dicing_camera", None)
        if camera.camera_to_world is None:  # of a window that does not tell its view
            there = depsgraph.scene_eval.camera is not None
            camera = export_camera(depsgraph, []) if there else None
        self._depsgraph, self._camera, self._own = depsgraph, camera, own

    def fineness_of(self, obj) -> Fineness | None:
        """Of an evaluated object of type MESH; None where Cycles takes its mesh as it is."""
        last = obj.modifiers[-1] if len(obj.modifiers) else None
        if last is None or last.type != "SUBSURF" or self._settings is None:
            return None
        if not (last.show_viewport if self._window else last.show_render):
            return None
        size = self._size_of(obj, last)
        if size is None:
            return None
        settings, in_space = self._settings, getattr(last, "adaptive_space", "PIXEL") == "OBJECT"
        if not in_space and self._camera is None and self._own is None:
            return None
        rate = settings.preview_dicing_rate if self._window else settings.dicing_rate
        return Fineness(
            linear=last.subdivision_type == "SIMPLE",
            size=size * rate if in_space else max(size * rate, _LEAST_PIXELS),
            in_space=in_space,
            max_level=settings.max_subdivisions,
            keeps_corners=last.boundary_smooth == "PRESERVE_CORNERS",
            creases=last.use_creases,
            uv_smooth=last.uv_smooth,
        )

    def _size_of(self, obj, modifier) -> float | None:
        """Pixels or lengths to an edge before the scene's rate; None: it is not adaptive."""
        if bpy.app.version >= (5, 0):
            if not modifier.use_adaptive_subdivision:
                return None
            if modifier.adaptive_space == "OBJECT":
                return modifier.adaptive_object_edge_length
            return modifier.adaptive_pixel_size
        own = getattr(obj.original, "cycles", None)
        wants = own is not None and own.use_adaptive_subdivision
        return own.dicing_rate if wants and self._settings.feature_set == "EXPERIMENTAL" else None

    def view_of(self, obj, fineness: Fineness):
        """A dicing_view.View for an object: as Cycles, where it stands itself, wherever its
        instances do."""
        from ....core.fine_meshes.dicing_view import (  # the exporters load without numba
            camera_view,
            own_space,
        )

        if fineness.in_space:
            return own_space(fineness.size)
        if self._own is not None:
            self._camera = export_camera(self._depsgraph, [], own=self._own)
            self._own = None
        offscreen = self._settings.offscreen_dicing_scale
        matrix = np.array(obj.matrix_world, np.float64)
        return camera_view(self._camera, matrix, fineness.size, offscreen)

"""Baking by Blender's own operator, `object.bake`: export, core.bake, the picture into Blender.

Blender finds the point of each texel, calls the engine once for each image, and does the rest:
margins, tangent space, saving. Every object is another engine object of Blender's.
"""

from __future__ import annotations

import contextlib

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..core.scene import Scene
from . import dependencies
from .bake_kinds import is_baked, parts_of
from .export import ExportCancelled, ExportError, export_scene
from .export.bake import bake_points, camera_of_bake, with_asked
from .export.placed.mesh import MeshExport
from .job import RenderJob
from .preferences import share_cache_dir
from .settings import render_settings
from .sink import BlenderSink
from .worker import run_in_worker


class BakeRender:
    """From the engine's update() over its bake()s, one an image, to its end."""

    def __init__(self, engine, job: RenderJob):
        self.engine, self.job = engine, job
        self.scene: Scene | None = None
        self._geometry: MeshExport | None = None
        self._images = 0

    def export(self, depsgraph) -> None:
        """Copy the scene out of Blender; self.scene stays None after a cancel."""
        scene, warnings, geometry = depsgraph.scene_eval, [], []
        self._settings = render_settings(scene)
        self._from_camera = _seen_from_camera(scene)
        share_cache_dir()
        with contextlib.suppress(ExportCancelled):
            found = export_scene(
                depsgraph,
                warnings=warnings,
                cache=self.job.export_cache,
                cancelled=self._cancelled,
                camera=camera_of_bake(depsgraph, warnings),
                geometry=geometry,
                written_out=True,
                diced=False,
            )
            self._geometry = geometry[0]
            self.scene = with_asked(found, depsgraph, self._geometry)
        self.job.warn(warnings)

    def bake(self, obj, kind: str, parts: int, width: int, height: int) -> None:
        """Bake one image of an evaluated object; parts: bits as Blender gives them."""
        if not is_baked(kind):
            raise ExportError(
                f"IWIS does not bake {kind.capitalize()}: its light goes straight through what is "
                "clear; bake another type, or this one with Cycles"
            )
        self._images += 1
        # The layer's name is what Blender tells the images of an object by.
        result = self.engine.begin_result(0, 0, width, height, layer=f"IWIS {self._images}")
        try:
            if self.scene is not None and not self._cancelled():
                self._fill(result.layers[0].passes, obj, kind, parts, (height, width))
        finally:
            self.engine.end_result(result)

    def _fill(self, passes, obj, kind, parts, size) -> None:
        found = {one.name: _pixels(one, size) for one in passes}
        points = bake_points(found, obj, self.scene, self._geometry, self._from_camera)
        wish = kind, parts_of(parts)
        region = (0, 0, size[1], size[0])
        sink = BlenderSink(self.engine, obj.name, "", [], region, self._settings)
        self.engine.update_stats("", f"Baking {obj.name}")
        made = run_in_worker(lambda relay: self._bake(points, wish, relay), sink)
        if made is None:  # cancelled: the core still holds the caches
            self.job.forget_caches()
            return
        picture, stats = made
        self.job.warn(stats.warnings)
        target = passes["Combined"]
        channels = np.ascontiguousarray(picture[..., : target.channels])
        target.rect.foreach_set(channels.ravel())

    def _bake(self, points, wish, relay):
        dependencies.require()
        from ..core.bake import Wish, bake

        own = self._settings, relay, self.job.render_cache()
        return bake(self.scene, points, Wish(*wish), *own)

    def _cancelled(self) -> bool:
        return self.engine.test_break() or RenderJob.interrupt.is_set()


def _seen_from_camera(scene) -> bool:
    return scene.render.bake.view_from == "ACTIVE_CAMERA" and scene.camera is not None


def _pixels(one, size) -> np.ndarray:
    """float32 (h, w, channels) of a pass."""
    values = np.empty((*size, one.channels), np.float32)
    one.rect.foreach_get(values.ravel())
    return values


@persistent
def _on_bake_end(_obj, _depsgraph=None):
    # Only in a window. The caches of a bake without one stay until the next render.
    if RenderJob.current is not None:
        RenderJob.current.forget_caches()


_HANDLERS = ("object_bake_complete", "object_bake_cancel")


def register() -> None:
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).append(_on_bake_end)


def unregister() -> None:
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(_on_bake_end)

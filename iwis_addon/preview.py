"""One preview of a material, world or light, or Freestyle's lines: Blender's own small scene.

Blender makes these while a user works, each in a scene and file of its own, and cancels them at
every edit. So a preview touches nothing of the user's render: no job, no records, no warnings.
"""

from __future__ import annotations

import contextlib
import dataclasses

import bpy
import numpy as np

from ..core.film import Progress
from ..core.scene import Scene
from ..core.settings import RenderSettings
from . import dependencies
from .export import ExportCancelled, LiveExport, export_scene
from .job import RenderJob
from .passes import TABLE
from .preferences import share_cache_dir
from .render_result import deliver_empty
from .settings import render_settings
from .sink import BlenderSink
from .worker import run_in_worker

# Of Freestyle's lines: points a pixel, and the factor of the distance between them.
_STROKE_POINTS, _STROKES_APART = 32, 1000.0
# A thumbnail of 32 pixels shows no more; the spheres' shadows are soft at this error.
_MAX_SAMPLES, _ERROR_THRESHOLD = 64, 0.05


class PreviewRender:
    """As FinalRender: from the engine's update() to its render()'s end."""

    def __init__(self, engine, depsgraph):
        self.engine, self.layer = engine, depsgraph.view_layer.name
        self.scene: Scene | None = None
        self.delivered: set[str] = set()

    def export(self, depsgraph) -> None:
        """Copy the preview's scene; self.scene stays None after a cancel."""
        self.settings = self.settings_of(depsgraph.scene_eval)
        with contextlib.suppress(ExportCancelled):
            self.scene = export_scene(
                depsgraph, warnings=[], cancelled=self._cancelled, live=LiveExport()
            )

    def settings_of(self, scene) -> RenderSettings:
        """What it takes of the scene's own settings."""
        return preview_settings(scene)

    def run(self, _depsgraph) -> None:
        """Render the one view; what is done by then stays after a cancel."""
        if self.scene is None or self._cancelled():
            return
        region = self.scene.camera.region
        combined = [row for row in TABLE if row.layer == "combined"]
        sink = _PreviewSink(self.engine, self.layer, "", combined, region, self.settings)
        share_cache_dir()
        try:
            run_in_worker(self._render, sink, grace_seconds=0.0)
        finally:
            if sink.tiles_written:
                self.delivered.add("")

    def complete(self) -> None:
        """Deliver an empty picture where there is none."""
        deliver_empty(self.engine, self.layer, self.delivered)

    def _cancelled(self) -> bool:
        return self.engine.test_break() or RenderJob.interrupt.is_set()

    def _render(self, relay) -> None:
        dependencies.require()
        from ..core.render import render

        if not relay.cancelled():
            render(self.scene, self.settings, relay)


class StrokeRender(PreviewRender):
    """Of Freestyle's lines: a scene of Blender's own, of flat faces that shine, in no user's file.

    They take no samples, so edges get as many points a pixel as pictures at most have.
    """

    def export(self, depsgraph) -> None:
        super().export(depsgraph)
        if self.scene is not None:
            self.scene = _spread(self.scene)

    def settings_of(self, scene) -> RenderSettings:
        return dataclasses.replace(
            render_settings(scene),
            estimator="UNBIASED",
            stop_rule="FIXED",
            max_samples=_STROKE_POINTS * RenderSettings().batch_size,
            batch_size=RenderSettings().batch_size,
        )


def _spread(scene: Scene) -> Scene:
    """The scene with its lines, which lie 1e-5 before one another, further apart along z.

    So rays that go through one meet the next. The camera looks along z, without perspective.
    """
    apart = np.array([1.0, 1.0, _STROKES_APART], np.float32)
    matrix = scene.camera.camera_to_world.copy()
    matrix[2, 3] *= _STROKES_APART
    camera = dataclasses.replace(
        scene.camera,
        camera_to_world=matrix,
        clip_start=scene.camera.clip_start * _STROKES_APART,
        clip_end=scene.camera.clip_end * _STROKES_APART,
    )
    mesh = dataclasses.replace(scene.mesh, vertices=scene.mesh.vertices * apart)
    return dataclasses.replace(scene, mesh=mesh, camera=camera)


def is_of_strokes(scene) -> bool:
    """Whether a scene is the one that Blender makes of Freestyle's lines."""
    return all(scene != known for known in bpy.data.scenes)


class _PreviewSink(BlenderSink):
    """Tiles are shown; a preview has no status line and no figures."""

    def progress(self, _progress: Progress) -> None:
        pass


def preview_settings(scene) -> RenderSettings:
    """What a preview takes, whatever a user chose for pictures; threads as Blender says."""
    return dataclasses.replace(
        RenderSettings(),
        max_samples=_MAX_SAMPLES,
        error_threshold=_ERROR_THRESHOLD,
        threads=render_settings(scene).threads,
        cache_dir=render_settings(scene).cache_dir,
    )

"""One final render of one view layer: export, core.render, delivery of every view."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import logging
import threading

import bpy

from ..core.denoising.denoise import Denoising
from ..core.film import Film
from ..core.scene import Scene
from ..core.stats import RenderStats
from . import dependencies, stereo
from .denoiser import denoising
from .export import ExportCancelled, ExportError, export_scene
from .export.motion.motion import export_in_motion
from .export.motion.pixel_motion import export_with_vectors, wants_vectors
from .job import RenderJob, RenderRecord
from .leave import end_without_waiting
from .manifest import stamp_mattes
from .number_film import NumberFilm
from .output import NO_LAYER, check_room
from .passes import add_passes, is_denoised
from .preferences import share_cache_dir
from .render_result import check_memory, deliver_empty, result_views
from .settings import denoise_settings, render_settings
from .sink import BlenderSink
from .worker import run_in_worker

log = logging.getLogger(__name__)


def _load_core(settings) -> None:
    """Import the core, and have its machine code read, while Blender's thread exports."""
    try:
        dependencies.require()
        from ..core.render import render
        from ..core.tiles.early_kernels import read_early

        read_early(settings, render)
    except Exception:  # the render itself meets it again, and says it
        log.debug("the core could not be loaded early", exc_info=True)


class FinalRender:
    """From the engine's update() to its render()'s end. Keeps nothing of bpy but the engine."""

    def __init__(self, engine, depsgraph, job: RenderJob):
        self.engine, self.job = engine, job
        self.layer = depsgraph.view_layer.name
        self.frame = depsgraph.scene.frame_current
        self.scene: Scene | None = None
        self.delivered: set[str] = set()
        self._export_stats = RenderStats()

    def export(self, depsgraph) -> None:
        """Copy all that the picture needs out of Blender; self.scene stays None after a cancel."""
        if self.job.unsaved:
            raise OSError(f"{self.job.unsaved}; the frames after it are not rendered")
        if self.job.layer_turned_on:
            raise ExportError(NO_LAYER)
        scene = depsgraph.scene_eval
        check_memory(self.engine, scene, depsgraph.view_layer_eval)
        self.settings = render_settings(scene)
        self._denoising = _denoising(scene, depsgraph.view_layer_eval)
        self._data = depsgraph.view_layer_eval.iwis.use_pass_denoising_data
        share_cache_dir()
        threading.Thread(target=_load_core, args=(self.settings,), name="iwis-load").start()
        self._keep_film = scene.iwis.keep_film
        with self._export_stats.phase("export"), contextlib.suppress(ExportCancelled):
            self.engine.update_stats("", "Exporting")
            export = functools.partial(
                export_scene,
                depsgraph,
                warnings=self._export_stats.warnings,
                cache=self.job.export_cache,
                cancelled=self._cancelled,
            )
            told = self._export_stats.warnings
            if wants_vectors(depsgraph):
                self.scene = export_with_vectors(self.engine, depsgraph, told, export)
            else:
                self.scene = export_in_motion(self.engine, depsgraph, told, export)
        self.job.warn(self._export_stats.warnings)

    def run(self, depsgraph) -> None:
        """Render and deliver every view; deliver what is done after a cancel."""
        rows = add_passes(self.engine, depsgraph.scene_eval, depsgraph.view_layer_eval)
        for view in result_views(self.engine):
            if self.scene is None or self._cancelled():
                self._record(view, RenderStats(cancelled=True), output_seconds=0.0)
                self._raise_interrupt()
                return
            camera = stereo.camera_of_view(self.engine, depsgraph.scene_eval, self.scene, view)
            self._render_view(view, dataclasses.replace(self.scene, camera=camera), rows)
        self._raise_interrupt()
        stamp_mattes(self.engine.get_result(), self.layer, self.scene.asked.mattes)
        check_room(depsgraph.scene_eval, sum(len(row.channel_ids) for row in rows))

    def _cancelled(self) -> bool:
        return self.engine.test_break() or RenderJob.interrupt.is_set()

    def _raise_interrupt(self) -> None:
        """End an interrupted job without a picture where there is nothing to be seen in it."""
        if RenderJob.interrupt.is_set() and not self.delivered:
            raise KeyboardInterrupt

    def _render_view(self, view, scene, rows):
        films = self._new_films(view, scene.camera.region)
        region, whole = scene.camera.region, stereo.at_once(view)
        sink = BlenderSink(self.engine, self.layer, view, rows, region, self.settings, films, whole)
        self.engine.update_stats("", "Loading; a machine's first render compiles for half a minute")
        try:
            stats = run_in_worker(lambda relay: self._render(scene, relay), sink)
        finally:
            sink.finish()
            if sink.tiles_written:
                self.delivered.add(view)
        if stats is None:
            # The core still holds the caches: the next render must not meet it there.
            self.job.forget_caches()
            x0, y0, x1, y1 = scene.camera.region
            stats = RenderStats(width=x1 - x0, height=y1 - y0, cancelled=True)
        self._record(view, stats, sink.output_seconds)

    def _new_films(self, view, region) -> list:
        """What the job keeps of a view's picture beside Blender's result."""
        key, films = (self.layer, view), []
        if self._keep_film:
            self.job.films[key] = Film(region)
            films.append(self.job.films[key])
        if self._keep_film or not bpy.app.background:
            self.job.numbers[key] = NumberFilm(region, self.settings)
            films.append(self.job.numbers[key])
        return films

    def _render(self, scene, relay):
        dependencies.require()
        from ..core.render import render

        if relay.cancelled():  # Blender's thread may be gone; leave its next render's cache alone
            return RenderStats(cancelled=True)
        cache = self.job.render_cache()
        if not self._denoising.settings.denoise and not self._data:
            return render(scene, self.settings, relay, cache)
        from ..core.denoised_render import render_denoised

        return render_denoised(scene, self.settings, self._denoising, self._data, relay, cache)

    def _record(self, view, stats, output_seconds):
        if not any(r.frame == self.frame and r.layer == self.layer for r in self.job.records):
            stats.seconds["export"] += self._export_stats.seconds["export"]
            stats.cpu_seconds["export"] += self._export_stats.cpu_seconds["export"]
        stats.seconds["output"] += output_seconds
        self.job.warn(stats.warnings)
        stats.warnings[:0] = self._export_stats.warnings
        self.job.records.append(RenderRecord(self.frame, self.layer, view, stats))

    def complete(self) -> None:
        """Deliver an empty picture for every view that has none.

        Without a result Blender dies when it writes the file.
        """
        deliver_empty(self.engine, self.layer, self.delivered)
        self.job.mark_rendered()
        if bpy.app.background and not bpy.app.module and self._cancelled():
            end_without_waiting(bpy.app.tempdir)


def _denoising(scene, view_layer) -> Denoising:
    wanted = denoise_settings(scene.iwis)
    return denoising(dataclasses.replace(wanted, denoise=is_denoised(scene, view_layer)))

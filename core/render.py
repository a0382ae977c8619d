"""render(scene, settings, sink): tiles, threads, cancel. The entry point of the core.

Workers compute tiles and never call the sink; the thread that called render() hands tiles on and
asks whether to stop, so that Blender's data is touched by one thread only.
"""

from __future__ import annotations

import dataclasses
import os

from .embree.copied_rows import written_out
from .embree.embree_instances import can_copy, can_instance
from .film import Progress, TileSink
from .lamplight.posed_lamps import shines_from_rest
from .machine.tile_pool import run_pool
from .machine.watch import Cancelled, StopFlag, watched
from .paper_mode.paper_tables import PaperTables
from .render_cache import RenderCache, with_rows
from .sampling.light_rays import Light
from .scene import GLOSSY_TOON, TOON, Scene
from .settings import RenderSettings
from .stats import RenderStats
from .surfaces.near_rays import with_near_rays
from .tiles.budget import BudgetRender
from .tiles.center_tile import CenterTile
from .tiles.early_kernels import read_early
from .tiles.filtered_tile import FilteredTile
from .tiles.tile_job import Job, Rect, TileWork
from .tiles.tiles import tile_plan
from .tiles.time_slices import with_slices
from .tiles.warm_up import warm_up
from .unit_square.sequence import common_points


def render(
    scene: Scene, settings: RenderSettings, sink: TileSink, cache: RenderCache | None = None
) -> RenderStats:
    """Deliver every tile of the camera's region to the sink; return what it cost.

    On cancel the tiles in work are delivered with the samples they have, and stats.cancelled is
    set. Errors of workers are raised here.
    """
    x0, y0, x1, y1 = scene.camera.region
    triangles = len(scene.mesh.triangles) + (scene.copies.triangles if scene.copies else 0)
    stats = RenderStats(width=x1 - x0, height=y1 - y0, triangles=triangles)
    cache = cache or RenderCache()
    scene = _as_settings_show(scene, settings, stats.warnings)
    stop = StopFlag()
    threads = worker_count(settings)
    accel = light = tables = None
    read_early(settings, render)
    with stats.phase("bvh"):
        accel = watched(lambda _: cache.rays(scene, stop.is_set), sink, stop, "bvh")
    if not stop.is_set():
        with stats.phase("tables"):
            light, tables = _prepare_light(scene, settings, sink, cache, stop, stats)
    stats.cancelled = stop.is_set()
    if stats.cancelled:
        return stats
    sequence = common_points(settings.max_samples, settings.point_set)
    seen = cache.backdrop(scene)
    scene, accel = with_rows(scene, accel, settings, threads)
    scene = with_near_rays(scene, settings, accel)
    own = scene, settings, accel, light, tables, sequence, stop, seen
    job = with_slices(Job(*own, takes_away=cache.takes_away))
    if settings.stop_rule == "BUDGET":
        _render_budget(job, threads, sink, stats)
    else:
        with stats.phase("sampling"):
            _render_tiles(job, threads, sink, stats)
    return stats


def _as_settings_show(scene: Scene, settings: RenderSettings, warnings: list[str]) -> Scene:
    """The scene without what settings, or this Embree, leave out; warnings: gets a line for it."""
    if settings.estimator == "PAPER" and scene.shaders is not None:
        # Its tables are made for a material as a whole: MaterialParams holds means.
        warnings.append("Mode PAPER shows textures and mixtures by one mean value a material")
        if scene.shaders.has_model(TOON, GLOSSY_TOON):
            warnings.append("Mode PAPER shows Toon BSDFs as Diffuse and Glossy BSDFs")
        if scene.shaders.has_films:
            warnings.append("Mode PAPER leaves out thin films")
        scene = dataclasses.replace(scene, shaders=None)
    if settings.pixel_filter == "CENTER" and (
        scene.camera.lens or scene.camera.motion or scene.motion
    ):
        warnings.append(
            "Pixel Filter Center takes one point a pixel: no depth of field and no motion blur; "
            "choose Blackman-Harris or Box"
        )
        scene = dataclasses.replace(scene, motion=None)
    elif scene.motion is not None and not can_instance():
        warnings.append("Embree's own interface is missing: moving objects stand still")
        scene = dataclasses.replace(scene, motion=None)
    copies = scene.copies
    if copies and (copies.move(scene.motion, scene.mesh.object_index) or not can_copy()):
        scene = written_out(scene)
    scatters = scene.shaders is not None and scene.shaders.scatters
    if settings.pixel_filter == "CENTER" and scatters:
        warnings.append(
            "Pixel Filter Center takes one point a pixel: no light goes under surfaces, which are "
            "diffuse in place of subsurface; choose Blackman-Harris or Box"
        )
    if scene.motion is not None and shines_from_rest(scene):
        warnings.append(
            f"{len(scene.lamps.faces.face)} faces shine: those that move light other surfaces from "
            "where they are in the middle of the time that the shutter is open"
        )
    return scene


def worker_count(settings: RenderSettings) -> int:
    """Threads to use: as many as this process may run on, or the setting if it is sensible.

    1024 threads on two cores take six times as long as two: they wait for Python's lock.
    """
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # not on Linux
        cores = os.cpu_count() or 1
    return min(settings.threads, 4 * cores) if settings.threads else cores


def prepare_tables(
    scene: Scene, settings: RenderSettings, sink: TileSink, cache: RenderCache | None = None
) -> RenderStats:
    """Build what a render in mode PAPER would, and leave it in the cache folder: for a farm job."""
    stats, stop = RenderStats(triangles=len(scene.mesh.triangles)), StopFlag()
    paper = dataclasses.replace(settings, estimator="PAPER")
    with stats.phase("tables"):
        _prepare_light(scene, paper, sink, cache or RenderCache(), stop, stats)
    stats.cancelled = stop.is_set()
    return stats


def _prepare_light(scene, settings, sink, cache, stop, stats) -> tuple[Light, PaperTables | None]:
    threads = worker_count(settings)

    def work(tell):
        def step(fraction, text):
            tell(fraction, text)
            if stop.is_set():
                raise Cancelled

        light = cache.light(scene.environment, settings.cache_dir, step)
        stats.warnings.extend(cache.light_warnings)
        if settings.estimator != "PAPER" or stop.is_set():
            return light, None
        tables, warnings, notes = cache.tables(scene, light, settings, threads, step)
        stats.warnings.extend(text for text in warnings if text not in stats.warnings)
        stats.tables.extend(notes)
        return light, tables

    return watched(work, sink, stop, "tables") or (None, None)


def _plan(job: Job, threads: int) -> list[Rect]:
    return tile_plan(job.scene.camera.region, job.settings.tile_px, threads)


def _render_tiles(job: Job, threads: int, sink: TileSink, stats: RenderStats) -> None:
    rects = _plan(job, threads)

    def work(rect):
        tile = make_tile(job, rect)
        tile.advance(job.settings.max_samples)
        return tile.develop(), tile.counts()

    done = 0

    def take(result):
        nonlocal done
        tile, counts = result
        done += 1
        stats.add_tile(counts)
        with stats.phase("output"):
            sink.write_tile(tile)
            n = len(rects)
            sink.progress(Progress("sampling", done / n, done, n, stats.samples_total))

    stats.cancelled = run_pool(rects, threads, work, take, sink.cancelled, job.stop)


def _render_budget(job: Job, threads: int, sink: TileSink, stats: RenderStats) -> None:
    rects = _plan(job, threads)
    tiles = [make_tile(job, rect) for rect in rects]
    if job.settings.time_limit:
        with stats.phase("tables"):
            watched(lambda _: warm_up(job, make_tile), sink, job.stop, "tables")
    stats.cancelled = job.stop.is_set()
    if not stats.cancelled:
        with stats.phase("sampling"):
            BudgetRender(job, tiles, threads, sink, stats).run()


def make_tile(job: Job, rect: Rect) -> TileWork:
    """The work at a tile, as the pixel filter has it."""
    return (CenterTile if job.settings.pixel_filter == "CENTER" else FilteredTile)(job, rect)

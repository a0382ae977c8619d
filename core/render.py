"""render(scene, settings, sink): tiles, threads, cancel. The entry point of the core.

Workers compute tiles and never call the sink; the thread that called render() hands tiles on and
asks whether to stop, so that Blender's data is touched by one thread only.
"""

from __future__ import annotations

import dataclasses
import os
import queue
import threading

from .center_tile import CenterTile
from .film import Progress, Tile, TileSink
from .filtered_tile import FilteredTile
from .light_rays import Light
from .paper_tables import PaperTables
from .render_cache import RenderCache
from .scene import Scene
from .sequence import common_points
from .settings import RenderSettings
from .stats import RenderStats
from .tile_job import Job, Rect, TileCounts
from .watch import POLL_SECONDS, Cancelled, StopFlag, watched


def render(
    scene: Scene, settings: RenderSettings, sink: TileSink, cache: RenderCache | None = None
) -> RenderStats:
    """Deliver every tile of the camera's region to the sink; return what it cost.

    On cancel the tiles in work are delivered with the samples they have, and stats.cancelled is
    set. Errors of workers are raised here.
    """
    x0, y0, x1, y1 = scene.camera.region
    stats = RenderStats(width=x1 - x0, height=y1 - y0, triangles=len(scene.mesh.triangles))
    cache = cache or RenderCache()
    stop = StopFlag()
    threads = worker_count(settings)
    accel = light = tables = None
    with stats.phase("bvh"):
        accel = watched(lambda _: cache.accel(scene.mesh, stop.is_set), sink, stop, "bvh")
    if not stop.is_set():
        with stats.phase("tables"):
            light, tables = _prepare_light(scene, settings, sink, cache, stop, stats)
    stats.cancelled = stop.is_set()
    if stats.cancelled:
        return stats
    sequence = common_points(settings.max_samples, settings.point_set)
    job = Job(scene, settings, accel, light, tables, sequence, stop)
    with stats.phase("sampling"):
        _render_tiles(job, threads, sink, stats)
    return stats


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


def tile_rects(region: tuple[int, int, int, int], tile_px: int) -> list[Rect]:
    """The tiles that cover a region, those at its centre first."""
    x0, y0, x1, y1 = region
    rects = []
    for y in range(y0 - y0 % tile_px, y1, tile_px):
        for x in range(x0 - x0 % tile_px, x1, tile_px):
            left, low = max(x, x0), max(y, y0)
            right, top = min(x + tile_px, x1), min(y + tile_px, y1)
            rects.append(Rect(left, low, right - left, top - low))
    middle_x, middle_y = (x0 + x1) / 2, (y0 + y1) / 2
    rects.sort(key=lambda r: (r[0] + r[2] / 2 - middle_x) ** 2 + (r[1] + r[3] / 2 - middle_y) ** 2)
    return rects


def _render_tiles(job: Job, threads: int, sink: TileSink, stats: RenderStats) -> None:
    rects = tile_rects(job.scene.camera.region, job.settings.tile_px)
    waiting: queue.SimpleQueue = queue.SimpleQueue()
    for rect in rects:
        waiting.put(rect)
    finished: queue.SimpleQueue = queue.SimpleQueue()
    workers = [
        threading.Thread(target=_work, args=(job, waiting, finished), name=f"iwis-{k}", daemon=True)
        for k in range(min(threads, len(rects)))
    ]
    for worker in workers:
        worker.start()
    try:
        _collect(job, workers, finished, len(rects), sink, stats)
    finally:
        job.stop.set()
        for worker in workers:
            worker.join()


def _work(job: Job, waiting, finished) -> None:
    try:
        while not job.stop.is_set():
            finished.put(_render_tile(job, waiting.get_nowait()))
    except queue.Empty:
        pass
    except BaseException as error:  # raised again in the caller's thread
        finished.put(error)


def _collect(job, workers, finished, n_tiles, sink, stats) -> None:
    """Hand finished tiles to the sink until all are there, a worker fails or the sink cancels."""
    done = 0
    while done < n_tiles:
        if not stats.cancelled and sink.cancelled():
            stats.cancelled = True
            job.stop.set()
        alive = any(worker.is_alive() for worker in workers)
        try:
            result = finished.get(timeout=POLL_SECONDS)
        except queue.Empty:
            if not alive:
                return
            continue
        if isinstance(result, BaseException):
            raise result
        tile, counts = result
        done += 1
        stats.shaded_pixels += counts.shaded
        stats.samples_total += counts.samples
        stats.samples_max = max(stats.samples_max, counts.samples_max)
        stats.shadow_rays += counts.shadow_rays
        stats.primary_rays += counts.primary_rays
        with stats.phase("output"):
            sink.write_tile(tile)
            sink.progress(
                Progress(
                    phase="sampling",
                    fraction=done / n_tiles,
                    tiles_done=done,
                    tiles_total=n_tiles,
                    samples=stats.samples_total,
                )
            )


def _render_tile(job: Job, rect: Rect) -> tuple[Tile, TileCounts]:
    work = (
        FilteredTile(job, rect) if job.settings.pixel_filter != "CENTER" else CenterTile(job, rect)
    )
    work.advance(job.settings.max_samples)
    return work.develop(), work.counts()

"""Pictures of one scene by every method, which share its BVH, its light and its tables."""

from __future__ import annotations

import dataclasses
import time
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ..core.camera.camera import camera_rays
from ..core.comparisons import reference
from ..core.comparisons.two_stage import TwoStageSampler, continue_adaptively
from ..core.film import Film
from ..core.machine.watch import StopFlag
from ..core.render import render, worker_count
from ..core.render_cache import RenderCache
from ..core.sampling.incremental import continue_points, new_sums
from ..core.sampling.stop_rule import paper_rule
from ..core.scene import Scene
from ..core.settings import RenderSettings
from ..core.surfaces.seen_points import SeenPoints, with_lobes
from ..core.tiles.tile_job import Job, Rect, trace_points
from ..core.unit_square.sequence import common_points, pixel_sequence, sequence_point

SHARES = {
    "light": reference.LIGHT_SAMPLING,
    "BRDF": reference.BSDF_SAMPLING,
    "MIS": reference.MIS_SAMPLING,
}
ADAPTIVE = "two-stage, adaptive"
METHODS = ("WIS", "two-stage", *SHARES)
NO_HIT = 1e9  # metres: farther is the world
_BLOCK = 256
PAPER = RenderSettings(
    estimator="PAPER",
    stop_rule="PAPER",
    error_threshold=0.1,
    max_samples=100,
    pixel_filter="CENTER",
)


class Picture(NamedTuple):
    """rgb: float64 (h, w, 3), 0 where nothing is hit; samples: float64 (h, w)
    visibility: float64 (h, w), K / N of mode PAPER; unoccluded: float64 (h, w, 3), I_s
    seconds, cpu_seconds: of sampling
    """

    rgb: np.ndarray
    samples: np.ndarray
    visibility: np.ndarray
    unoccluded: np.ndarray
    seconds: float
    cpu_seconds: float


class Run:
    """Renders of one scene; threads: 0 = all cores.

    progress: called with a line of text while tables are built
    notes: of tables that were built
    """

    def __init__(self, scene: Scene, threads=0, cache_dir="", coefficients=0.05, progress=None):
        self.scene = scene
        self.settings = dataclasses.replace(
            PAPER, threads=threads, cache_dir=cache_dir, coefficients=coefficients
        )
        self._threads = worker_count(self.settings)
        self._cache = RenderCache()
        self._job: Job | None = None
        self._seen: SeenPoints | None = None
        self._progress = progress
        self.notes: list[str] = []

    def picture(self, **changes) -> Picture:
        """A render as the engine makes it, without the background."""
        film = Film(self.scene.camera.region)
        settings = dataclasses.replace(self.settings, **changes)
        sink = film if self._progress is None else _Telling(film, self._progress)
        stats = render(self.scene, settings, sink, self._cache)
        self.notes += stats.tables
        layers = {name: film.layers[name].astype(np.float64) for name in _LAYERS}
        shown = (layers["depth"] < NO_HIT) & (layers["samples"] > 0.0)
        rgb = np.where(shown, layers["combined"][..., :3], 0.0)
        return Picture(
            rgb,
            layers["samples"][..., 0],
            layers["visibility"][..., 0],
            layers["unoccluded"],
            stats.seconds["sampling"] + stats.seconds["output"],
            stats.cpu_seconds["sampling"] + stats.cpu_seconds["output"],
        )

    def shown(self) -> np.ndarray:
        """bool (h, w): the pixels that show the object."""
        x0, y0, x1, y1 = self.scene.camera.region
        mask = np.zeros((y1 - y0) * (x1 - x0), bool)
        mask[self.seen().points.pixel] = True
        return mask.reshape(y1 - y0, x1 - x0)

    def seen(self) -> SeenPoints:
        """The shading points of the whole picture, one a pixel."""
        if self._seen is None:
            camera = self.scene.camera
            rays = camera_rays(camera, 0, 0, camera.width, camera.height)
            self._seen = with_lobes(self.scene, trace_points(self.job(), rays))
        return self._seen

    def sampled(self, method: str, count: int, threshold: float = 0.0) -> Picture:
        """A picture by one of METHODS or ADAPTIVE with ``count`` samples a pixel.

        threshold: of ADAPTIVE, whose pixels have ``count`` at the most
        """
        camera, seen = self.scene.camera, self.seen()
        rgb = np.zeros((camera.height * camera.width, 3))
        samples = np.zeros(camera.height * camera.width)
        points = common_points(count, "PIXEL")

        def work(start):
            own = seen.at(slice(start, start + _BLOCK))
            sums = self._sample(own, method, points, threshold)
            pixel, n = own.points.pixel, np.maximum(sums.count, 1)[:, None]
            rgb[pixel], samples[pixel] = (sums.diffuse + sums.glossy) / n, sums.count

        begin, cpu = time.perf_counter(), time.process_time()
        with ThreadPoolExecutor(self._threads) as pool:
            list(pool.map(work, range(0, len(seen.rows), _BLOCK)))
        spent = time.perf_counter() - begin, time.process_time() - cpu
        shape = camera.height, camera.width
        rgb, empty = rgb.reshape(*shape, 3), np.zeros(shape)
        return Picture(rgb, samples.reshape(shape), empty, np.zeros_like(rgb), *spent)

    def sampler(self, seen: SeenPoints, method: str, points: np.ndarray):
        """The incremental.Sampler of a method; points: of common_points."""
        rect = Rect(0, 0, self.scene.camera.width, self.scene.camera.height)
        kind, job = "PIXEL", self.job()
        sequence = pixel_sequence(points, seen.points.pixel, rect[:3], self.settings.seed, kind)
        if method == "WIS":
            extra = seen.rows, job.tables, sequence, len(points), job.accel.offset
            return reference.make_wis(seen.points, seen.lobes, *extra)
        if method in SHARES:
            extra = job.light, SHARES[method], sequence, job.accel.offset
            return reference.MixtureSampler(seen.points, seen.lobes, *extra)
        return TwoStageSampler(seen.points, seen.lobes, job.light, sequence, job.accel.offset)

    def pixel_points(self, seen: SeenPoints, count: int) -> np.ndarray:
        """The first points of a pixel's own sequence in mode PAPER, float64 (count, 2)."""
        kind, width = self.settings.point_set, self.scene.camera.width
        place = (0, 0, width), self.settings.seed, kind
        sequence = pixel_sequence(common_points(count, kind), seen.points.pixel, *place)
        return np.array([sequence_point(sequence, 0, k) for k in range(count)])

    def _sample(self, own: SeenPoints, method: str, points, threshold: float):
        sums, accel = new_sums(len(own.rows)), self.job().accel
        sampler = self.sampler(own, method, points)
        if method == ADAPTIVE:
            continue_adaptively(sampler, sums, accel, threshold, len(points))
        else:
            continue_points(sampler, sums, accel, paper_rule(-1.0, len(points), len(points)))
        return sums

    def job(self) -> Job:
        """What a tile of PAPER works on: BVH, light, tables."""
        if self._job is None:
            tell = self._progress or (lambda text: None)
            light = self._cache.light(self.scene.environment)
            tables, _, notes = self._cache.tables(
                self.scene,
                light,
                self.settings,
                self._threads,
                lambda fraction, text: tell(f"{text}: {10 * int(10 * fraction)} %"),
            )
            self.notes += notes
            sequence = common_points(self.settings.max_samples, "PIXEL")
            accel = self._cache.rays(self.scene)
            self._job = Job(self.scene, self.settings, accel, light, tables, sequence, StopFlag())
        return self._job


_LAYERS = ("combined", "depth", "samples", "visibility", "unoccluded")


class _Telling:
    """A TileSink that also says how far the tables are."""

    def __init__(self, film: Film, progress):
        self._film, self._tell = film, progress

    def write_tile(self, tile) -> None:
        self._film.write_tile(tile)

    def progress(self, progress) -> None:
        if progress.phase == "tables" and progress.text:
            self._tell(f"{progress.text}: {10 * int(10 * progress.fraction)} %")

    def cancelled(self) -> bool:
        return self._film.cancelled()

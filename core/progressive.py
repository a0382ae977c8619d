"""Pictures for a window: a coarse one at once, finer ones, then rounds until nothing is wanted.

Coarse pictures are pictures of a camera with fewer pixels, a few samples each, and are thrown away.
The last step has the frame's own pixels; its rounds (8, 16, 32 ... samples) add to what is there,
until the stop rule has all it asks for: then the picture is the one that render() makes.
"""

from __future__ import annotations

import copy
import dataclasses
import math
import queue
import threading
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from .denoise import Guided
from .film import LAYERS
from .near_rays import with_near_rays
from .render import make_tile, worker_count
from .render_cache import RenderCache, with_rows
from .scene import Camera, Scene
from .sequence import common_points
from .settings import RenderSettings
from .tile_job import Job, TileWork
from .tiles import tile_rects
from .turns import Turns
from .view_denoiser import ViewDenoiser
from .watch import Cancelled, StopFlag

# Pixels of the frame to either side of one pixel of a picture, the finest first.
STEPS = (1, 2, 4, 8, 16)
# What a picture carries, of film.LAYERS.
SHOWN = ("combined", "samples", "error", "visibility")
# The first picture's time: with Blender's own drawing, ten pictures a second while one orbits.
FIRST_SECONDS = 0.06
_COARSE_SAMPLES = 4
_TILE_PX = 32  # at the most: a coarse picture has few pixels, and all threads are to have some
_SECONDS_BETWEEN_PICTURES = 0.15


class Picture(NamedTuple):
    """What can be shown now.

    step: pixels of the frame that a pixel of the layers covers, to either side
    region: (x0, y0, x1, y1) of the frame that the layers cover, in units of ``step``
    layers: of SHOWN, float32 (h, w, channels), row 0 at the bottom; with step 1 they go on changing
    fraction: of the rounds that may come; converged: no sample is wanted any more
    """

    step: int
    region: tuple[int, int, int, int]
    layers: dict[str, np.ndarray]
    fraction: float
    converged: bool


class Pace:
    """How long a point of a coarse picture takes here: chooses the step to begin with."""

    def __init__(self):
        self._seconds_per_point = 2e-5

    def first_step(self, camera: Camera) -> int:
        """The finest step above 1 whose picture is there within FIRST_SECONDS, or the coarsest."""
        x0, y0, x1, y1 = camera.region
        whole = (x1 - x0) * (y1 - y0) * self._seconds_per_point
        return next((s for s in STEPS[1:] if whole <= FIRST_SECONDS * s * s), STEPS[-1])

    def note(self, points: int, seconds: float) -> None:
        """Learn from a coarse picture."""
        self._seconds_per_point += 0.5 * (seconds / max(points, 1) - self._seconds_per_point)


def coarse_camera(camera: Camera, step: int) -> Camera:
    """The camera whose pixels are ``step`` times as wide and high; those at the edge reach out."""
    left, right, bottom, top = camera.window
    width, height = -(-camera.width // step), -(-camera.height // step)
    x0, y0, x1, y1 = camera.region
    return dataclasses.replace(
        camera,
        width=width,
        height=height,
        window=(
            left,
            left + (right - left) * (width * step / camera.width),
            bottom,
            bottom + (top - bottom) * (height * step / camera.height),
        ),
        region=(x0 // step, y0 // step, -(-x1 // step), -(-y1 // step)),
    )


def render_progressive(
    scene: Scene,
    settings: RenderSettings,
    show: Callable[[Picture], None],
    cache: RenderCache,
    pace: Pace,
    restart: StopFlag,
    close: StopFlag,
    denoiser: ViewDenoiser | None = None,
) -> None:
    """Show pictures, each better than the last, until the last is converged.

    show is called by this thread. ``restart`` ends the work once a picture was shown: somebody who
    drags an object for a minute is to see it move. ``close`` ends it at once. Estimator UNBIASED
    only: the paper's tables would take longer than anybody waits for. denoiser: of the pictures of
    the frame's own pixels, where it is due.
    Raises watch.Cancelled where ``close`` ended the building of the BVH.
    """
    settings = dataclasses.replace(settings, estimator="UNBIASED")
    accel = cache.rays(scene, close.is_set, quick=True)
    light = cache.light(scene.environment, settings.cache_dir)
    step, stop, last = pace.first_step(scene.camera), close, None
    few = dataclasses.replace(
        settings, stop_rule="FIXED", pixel_filter="CENTER", max_samples=_COARSE_SAMPLES
    )
    seen = cache.backdrop(scene)
    threads = worker_count(settings)
    looks, own = with_rows(scene, accel, few, threads)
    looks = with_near_rays(looks, few, own)
    coarse_job = Job(looks, few, own, light, None, _points(few), stop, seen)
    while step > 1 and not stop.is_set():
        camera = coarse_camera(scene.camera, step)
        job = dataclasses.replace(coarse_job, scene=_seen_by(looks, camera), stop=stop)
        last = _coarse_picture(job, step, pace)
        if not stop.is_set():
            show(last)
        step, stop = step // 2, restart
    if not stop.is_set():
        try:
            accel = cache.rays(scene, stop.is_set)  # another one where objects have moved
        except Cancelled:
            return
        points = _points(settings)
        scene, accel = with_rows(scene, accel, settings, threads)
        scene = with_near_rays(scene, settings, accel)
        job = Job(scene, settings, accel, light, None, points, stop, seen, first_passes=1)
        _Rounds(job, last, show, denoiser or ViewDenoiser()).run()


def _points(settings: RenderSettings) -> np.ndarray:
    return common_points(settings.max_samples, settings.point_set)


def _seen_by(scene: Scene, camera: Camera) -> Scene:
    """The scene with another camera, and no second look at a million triangles."""
    scene = copy.copy(scene)
    object.__setattr__(scene, "camera", camera)
    return scene


def _works(job: Job) -> list[TileWork]:
    tile_px = min(job.settings.tile_px, _TILE_PX)
    return [make_tile(job, rect) for rect in tile_rects(job.scene.camera.region, tile_px)]


def _new_layers(region) -> dict[str, np.ndarray]:
    x0, y0, x1, y1 = region
    return {name: np.zeros((y1 - y0, x1 - x0, LAYERS[name]), np.float32) for name in SHOWN}


def _coarse_picture(job: Job, step: int, pace: Pace) -> Picture:
    """A picture of a few samples a pixel, with a bit of it missing if it was stopped."""
    started = time.perf_counter()
    region = job.scene.camera.region
    picture = Picture(step, region, _new_layers(region), 0.0, False)
    for _ in _advance(_works(job), _COARSE_SAMPLES, picture.layers, job):
        pass
    if not job.stop.is_set():
        pace.note(picture.layers["samples"].size, time.perf_counter() - started)
    return picture


def _advance(
    works: list[TileWork], samples: int, layers: dict, job: Job, guided: Guided | None = None
) -> Iterator[bool]:
    """Take tiles on in threads, write each into the layers; yield whether each is done.

    guided: of the same picture; None: nobody wants it
    """
    waiting, finished = queue.SimpleQueue(), queue.SimpleQueue()
    count = min(worker_count(job.settings), len(works))
    turns = Turns(count)
    for work in works:
        waiting.put(work)

    def work_on():
        try:
            while not job.stop.is_set():
                work = waiting.get_nowait()
                with turns.taken():
                    done = work.advance(samples)
                    _write(work, layers, job.scene, guided)
                    work.rest()
                finished.put((work, done))
        except queue.Empty:
            pass
        except BaseException as error:  # raised again in the caller's thread
            finished.put(error)
        finally:
            finished.put(None)

    threads = [
        threading.Thread(target=work_on, name=f"iwis-view-{k}", daemon=True) for k in range(count)
    ]
    for thread in threads:
        thread.start()
    while count:
        result = finished.get()
        if isinstance(result, BaseException):
            raise result
        if result is None:
            count -= 1
        else:
            yield result


def _write(work: TileWork, layers: dict, scene: Scene, guided: Guided | None) -> None:
    tile = work.develop()
    x, y = tile.x - scene.camera.region[0], tile.y - scene.camera.region[1]
    for name in SHOWN:
        layers[name][y : y + tile.height, x : x + tile.width] = tile.layers[name]
    if guided is not None:
        guided.take(Guided.of_layers(tile.layers, scene), x, y)


class _Rounds:
    """The frame's own pixels, round after round."""

    def __init__(self, job: Job, coarse: Picture | None, show, denoiser: ViewDenoiser):
        self._job, self._show, self._denoiser = job, show, denoiser
        self._layers = _new_layers(job.scene.camera.region)
        self._guided = None
        if denoiser.begin():
            height, width = self._layers["combined"].shape[:2]
            self._guided = Guided.empty(width, height)
        if coarse is not None:
            _enlarge(coarse, job.scene.camera.region, self._layers)
        self._shown_at = time.perf_counter()

    def run(self) -> None:
        """See render_progressive."""
        job, most, works = self._job, self._job.settings.max_samples, _works(self._job)
        rounds = [1 << k for k in range(3, max(math.ceil(math.log2(most)), 3))] + [most]
        for number, samples in enumerate(rounds):
            going = []
            for work, done in _advance(works, samples, self._layers, job, self._guided):
                if not done:
                    going.append(work)
                waited = time.perf_counter() - self._shown_at
                if waited > _SECONDS_BETWEEN_PICTURES and not self._denoiser.shows:
                    self._tell(self._picture(number, rounds))
            if job.stop.is_set():
                return
            works = going
            if not works:
                break
            self._end_round(self._picture(number + 1, rounds), samples)
        last = self._picture(len(rounds), rounds)._replace(converged=True)
        self._tell(last if self._guided is None else self._denoised(last, most))

    def _end_round(self, picture: Picture, samples: int) -> None:
        """Show it, denoised where that is due; with noise only if no other one was shown."""
        if self._guided is not None and self._denoiser.due(samples):
            self._tell(self._denoised(picture, samples))
        elif not self._denoiser.shows:
            self._tell(picture)

    def _denoised(self, picture: Picture, samples: int) -> Picture:
        job = self._job
        own = self._guided, job.scene, job.settings, worker_count(job.settings), samples
        combined = self._denoiser.take(*own, lambda fraction: not job.stop.is_set())
        return picture._replace(layers={**picture.layers, "combined": combined})

    def _picture(self, number, rounds) -> Picture:
        region = self._job.scene.camera.region
        return Picture(1, region, self._layers, number / len(rounds), False)

    def _tell(self, picture: Picture) -> None:
        self._shown_at = time.perf_counter()
        if not self._job.stop.is_set():
            self._show(picture)


def _enlarge(coarse: Picture, region, layers) -> None:
    """Fill layers with a coarse picture, each of its pixels as large as it stands for."""
    x0, y0, x1, y1 = region
    columns = np.arange(x0, x1) // coarse.step - coarse.region[0]
    rows = np.arange(y0, y1) // coarse.step - coarse.region[1]
    for name, layer in layers.items():
        layer[:] = coarse.layers[name][rows][:, columns]

"""Pictures for a window: a coarse one at once, finer ones, then rounds until nothing is wanted.

Coarse pictures are pictures of a camera with fewer pixels, a few samples each, and are thrown away.
The last step has the frame's own pixels; its rounds (8, 16, 32 ... samples) add to what is there,
until the stop rule has all it asks for: then the picture is the one that render() makes.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable

import numpy as np

from ..denoising.denoise import Guided
from ..denoising.view_denoiser import ViewDenoiser
from ..machine.watch import Cancelled, StopFlag
from ..render import worker_count
from ..render_cache import RenderCache, with_rows
from ..scene import Scene
from ..settings import RenderSettings
from ..surfaces.near_rays import with_near_rays
from ..tiles.tile_job import Job
from ..unit_square.sequence import common_points
from .coarse_pictures import COARSE_SAMPLES, Pace, enlarge, show_coarse
from .shown_picture import SHOWN, Picture, advance, new_shown_layers, tile_works

_SECONDS_BETWEEN_PICTURES = 0.15


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
    few = dataclasses.replace(
        settings, stop_rule="FIXED", pixel_filter="CENTER", max_samples=COARSE_SAMPLES
    )
    accel = cache.rays(scene, close.is_set, quick=True)
    light = cache.light(scene.environment, settings.cache_dir)
    seen, threads = cache.backdrop(scene), worker_count(settings)
    looks, own = with_rows(scene, accel, few, threads)
    looks = with_near_rays(looks, few, own)
    coarse_job = Job(looks, few, own, light, None, _points(few), close, seen)
    last, stop = show_coarse(coarse_job, pace, show, restart)
    if not stop.is_set():
        try:
            accel = cache.rays(scene, stop.is_set)  # another one where objects have moved
        except Cancelled:
            return
        points = _points(settings)
        scene, accel = with_rows(scene, accel, settings, threads)
        scene = with_near_rays(scene, settings, accel)
        own = scene, settings, accel, light, None, points, stop, seen
        job = Job(*own, first_passes=1, takes_away=cache.takes_away)
        _Rounds(job, last, show, denoiser or ViewDenoiser()).run()


def _points(settings: RenderSettings) -> np.ndarray:
    return common_points(settings.max_samples, settings.point_set)


class _Rounds:
    """The frame's own pixels, round after round."""

    def __init__(self, job: Job, coarse: Picture | None, show, denoiser: ViewDenoiser):
        self._job, self._show, self._denoiser = job, show, denoiser
        self._layers = new_shown_layers(job.scene.camera.region, job.scene.asked)
        self._guided = None
        if denoiser.begin():
            height, width = self._layers["combined"].shape[:2]
            self._guided = Guided.empty(width, height)
        if coarse is not None:
            enlarge(coarse, job.scene.camera.region, self._layers)
        self._shown_at = time.perf_counter()

    def run(self) -> None:
        """See render_progressive."""
        job, most, works = self._job, self._job.settings.max_samples, tile_works(self._job)
        rounds = [1 << k for k in range(3, max(math.ceil(math.log2(most)), 3))] + [most]
        for number, samples in enumerate(rounds):
            going = []
            for work, done in advance(works, samples, self._layers, job, self._guided):
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
        scene = self._job.scene
        fraction, shown = number / len(rounds), scene.asked.shown or SHOWN[0]
        return Picture(1, scene.camera.region, self._layers, fraction, False, shown)

    def _tell(self, picture: Picture) -> None:
        self._shown_at = time.perf_counter()
        if not self._job.stop.is_set():
            self._show(picture)

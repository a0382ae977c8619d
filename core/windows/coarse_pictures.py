"""Coarse pictures for a window, the first one at once: of cameras with fewer pixels, few samples
each, thrown away in the end."""

from __future__ import annotations

import copy
import dataclasses
import time

import numpy as np

from ..machine.watch import StopFlag
from ..scene import Camera, Scene
from ..tiles.tile_job import Job
from .shown_picture import SHOWN, Picture, advance, new_shown_layers, tile_works

# Pixels of the frame to either side of one pixel of a picture, the finest first.
STEPS = (1, 2, 4, 8, 16)
# The first picture's time: with Blender's own drawing, ten pictures a second while one orbits.
FIRST_SECONDS = 0.06
COARSE_SAMPLES = 4


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


def _seen_by(scene: Scene, camera: Camera) -> Scene:
    """The scene with another camera, and no second look at a million triangles."""
    scene = copy.copy(scene)
    object.__setattr__(scene, "camera", camera)
    return scene


def _coarse_picture(job: Job, step: int, pace: Pace) -> Picture:
    """A picture of a few samples a pixel, with a bit of it missing if it was stopped."""
    started = time.perf_counter()
    region, asked = job.scene.camera.region, job.scene.asked
    layers = new_shown_layers(region, asked)
    picture = Picture(step, region, layers, 0.0, False, asked.shown or SHOWN[0])
    for _ in advance(tile_works(job), COARSE_SAMPLES, picture.layers, job):
        pass
    if not job.stop.is_set():
        pace.note(picture.layers["samples"].size, time.perf_counter() - started)
    return picture


def show_coarse(job: Job, pace: Pace, show, restart: StopFlag) -> tuple[Picture | None, StopFlag]:
    """Show pictures of smaller cameras; the last one, and what ends the work from there on.

    job: of the frame's camera, ``stop`` is what ends the first picture
    """
    camera, stop, last = job.scene.camera, job.stop, None
    step = pace.first_step(camera)
    while step > 1 and not stop.is_set():
        smaller = _seen_by(job.scene, coarse_camera(camera, step))
        last = _coarse_picture(dataclasses.replace(job, scene=smaller, stop=stop), step, pace)
        if not stop.is_set():
            show(last)
        step, stop = step // 2, restart
    return last, stop


def enlarge(coarse: Picture, region, layers) -> None:
    """Fill layers with a coarse picture, each of its pixels as large as it stands for."""
    x0, y0, x1, y1 = region
    columns = np.arange(x0, x1) // coarse.step - coarse.region[0]
    rows = np.arange(y0, y1) // coarse.step - coarse.region[1]
    for name, layer in layers.items():
        layer[:] = coarse.layers[name][rows][:, columns]

"""Cycles on the CPU, cut down to the work of IWIS: direct light, one shading point a pixel.

``max_bounces = 0`` is the light that reaches a surface straight from the world, by light and BSDF
sampling with multiple importance; a Blackman-Harris filter .01 pixels wide is the pixel's centre.
"""

import contextlib
import os
import resource
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from iwis.core.exr import read_exr_layers


class Timed(NamedTuple):
    """A picture and what it cost.

    rgb: float32 (h, w, 3), row 0 at the bottom; alpha: float32 (h, w), 0 where the world is seen
    cpu: user + system seconds of the process
    """

    rgb: np.ndarray
    alpha: np.ndarray
    cpu: float


def cpu_seconds() -> float:
    """User + system time of this process, all threads."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


@contextlib.contextmanager
def quiet():
    """Keep what Blender writes to standard output while it renders out of a benchmark's tables."""
    sys.stdout.flush()
    kept = os.dup(1)
    with open(os.devnull, "w") as null:
        os.dup2(null.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def use_cycles(scene, threads: int) -> None:
    """Direct light only, no filter, no denoiser, no adaptivity, everything kept between renders."""
    cycles, render = scene.cycles, scene.render
    render.engine = "CYCLES"
    cycles.device = "CPU"
    for name in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{name}_bounces", 0)
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.time_limit = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    render.threads_mode, render.threads = "FIXED", threads
    render.use_persistent_data = True
    render.use_compositing = render.use_sequencer = False
    render.film_transparent = True
    use_exr(render.image_settings)


def use_exr(image) -> None:
    """Full floats, uncompressed: writing the file must not cost what is measured."""
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode = "OPEN_EXR", "RGBA"
    image.color_depth, image.exr_codec = "32", "NONE"


def render_cycles(scene, samples: int, seed: int = 0) -> Timed:
    """One render of the open file by Cycles as use_cycles() has set it."""
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.update_tag()  # with persistent data Cycles does not see a new sample count by itself
    bpy.context.view_layer.update()
    with tempfile.TemporaryDirectory(prefix="iwis-cycles-") as folder:
        scene.render.filepath = str(Path(folder) / "cycles.exr")
        before = cpu_seconds()
        with quiet():
            bpy.ops.render.render(write_still=True)
        cpu = cpu_seconds() - before
        layers = read_exr_layers(Path(folder) / "cycles.exr")
    (rgba,) = layers.values()
    return Timed(np.ascontiguousarray(rgba[..., :3]), rgba[..., 3], cpu)

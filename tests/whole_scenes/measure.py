"""One scene by both engines, at a small size: does it come out, and is it the same light?"""

from __future__ import annotations

import importlib
import sys
import warnings as python_warnings
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from .stage import Missing, Whole

WIDTH, HEIGHT, BLOCK = 72, 48, 6
SAMPLES = 256
# Means of blocks of 6 x 6 pixels: Cycles' noise of 256 samples in them is about 1 %.
_SAME_MEAN, _SAME_BLOCKS = 0.01, 0.03


class Measured(NamedTuple):
    """state: "same", "differs", "black", "failed" or "missing"; mean, blocks: difference of the
    means, root mean square difference of the blocks, of Cycles' mean; lines: what IWIS warns of;
    remark: of the scene, or what failed; pictures: IWIS', Cycles', (h, w, 4), bottom row first"""

    group: str
    name: str
    state: str
    mean: float = 0.0
    blocks: float = 0.0
    lines: tuple[str, ...] = ()
    remark: str = ""
    pictures: tuple | None = None


def addon(part: str):
    """A module of IWIS, whatever this Blender calls the package."""
    name = next(m for m in sys.modules if m.split(".")[-1] == "iwis")
    return importlib.import_module(f"{name}.{part}")


def measure(whole: Whole, folder: Path, samples: int = SAMPLES) -> Measured:
    """Never raises but for what is wrong in this program: a failure is a result."""
    try:
        with python_warnings.catch_warnings():
            python_warnings.simplefilter("ignore")
            remark = whole.build() or ""
    except Missing as missing:
        return Measured(whole.group, whole.name, "missing", remark=str(missing))
    except RuntimeError as error:
        what = f"Blender: {' '.join(str(error).split())}"
        return Measured(whole.group, whole.name, "missing", remark=what)
    _make_small(bpy.context.scene)
    try:
        ours = _render(_use_iwis, folder, samples)
        theirs = _render(_use_cycles, folder, samples)
    except RuntimeError as error:
        return Measured(whole.group, whole.name, "failed", remark=" ".join(str(error).split()))
    lines = tuple(dict.fromkeys(addon("iwis_addon.job").RenderJob.get().records[-1].stats.warnings))
    state, mean, blocks = compared(ours, theirs)
    return Measured(whole.group, whole.name, state, mean, blocks, lines, remark, (ours, theirs))


def compared(ours, theirs) -> tuple[str, float, float]:
    """(state, mean, blocks) of two pictures (h, w, 4)."""
    a, b = (_blocks(picture[..., :3]) for picture in (ours, theirs))
    if not np.isfinite(ours).all():
        return "failed", np.nan, np.nan
    scale = max(float(b.mean()), 1e-6)
    mean = float(a.mean() - b.mean()) / scale
    blocks = float(np.sqrt(((a - b) ** 2).mean())) / scale
    if ((a.mean(-1) < 0.1 * b.mean(-1)) & (b.mean(-1) > 0.05 * scale)).any():
        return "black", mean, blocks
    same = abs(mean) <= _SAME_MEAN and blocks <= _SAME_BLOCKS
    return "same" if same else "differs", mean, blocks


def _blocks(picture):
    h, w, channels = picture.shape
    return picture.reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, channels).mean((1, 3))


def _make_small(scene) -> None:
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    render.use_border = render.use_motion_blur = render.use_sequencer = False
    render.use_compositing = False
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGBA"


def _use_cycles(scene, samples) -> None:
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.max_bounces = samples, 0
    cycles.use_adaptive_sampling = cycles.use_denoising = False


def _use_iwis(scene, samples) -> None:
    scene.render.engine = "IWIS"
    scene.iwis.max_samples, scene.iwis.stop_rule = samples, "FIXED"


def _render(use, folder: Path, samples: int) -> np.ndarray:
    scene = bpy.context.scene
    use(scene, samples)
    path = folder / "picture.exr"
    path.unlink(missing_ok=True)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(HEIGHT, WIDTH, 4)

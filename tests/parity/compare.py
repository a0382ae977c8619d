"""One case, rendered by both: how much they differ beyond their own noise, and where.

A case that only glows has no noise: one render each. Another one is rendered twice by both, with
other seeds, under lamps eight times by IWIS: of the mean square of their difference the noise,
known from these, is taken off.
"""

from __future__ import annotations

import warnings as python_warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from iwis.iwis_addon.job import RenderJob
from support.cycles_render import render_cycles
from support.iwis_render import render_iwis

from .cases import Case
from .scene import empty_scene

LIMIT = 0.01
# Pixels at an edge see, in Cycles, a ray within a hundredth of a pixel of the centre.
EDGES = 0.01
BLURRED_PASSES, IWIS_BATCH = 256, 4


class Result(NamedTuple):
    """difference: root mean square, of the mean; bias: of the means; odd: share of pixels that
    differ by more than a tenth; warnings: what IWIS said; ours, cycles: pictures (h, w, 3)"""

    difference: float
    bias: float
    odd: float
    warnings: list[str]
    ours: np.ndarray
    cycles: np.ndarray

    @property
    def agrees(self) -> bool:
        return self.difference <= LIMIT and abs(self.bias) <= LIMIT


def run_case(case: Case, folder: Path) -> Result:
    """Build, render and compare."""
    scene, tree = empty_scene(case.lit)
    scene.render.filepath = str(folder / "case")  # what a case writes goes there
    case.build(scene, tree)
    ours = [_render_iwis(scene, seed, folder, case) for seed in range(case.renders)]
    warnings = RenderJob.get().records[-1].stats.warnings
    seeds = range(2 if case.noisy else 1)
    theirs = [_render_cycles(scene, seed, folder, case) for seed in seeds]
    return _compared(np.array(ours), np.array(theirs), case, warnings)


def _render_iwis(scene, seed, folder, case):
    scene.iwis.seed = seed
    scene.iwis.pixel_filter = "BLACKMAN_HARRIS" if case.blurred else "CENTER"
    scene.iwis.filter_width = case.filter_width  # 0.01: the middle of the pixel
    scene.iwis.max_samples = case.samples[0] if case.noisy else 1
    if case.blurred:
        scene.iwis.max_samples = BLURRED_PASSES * IWIS_BATCH
    scene.iwis.stop_rule = "FIXED"
    layers = render_iwis(scene, folder)
    return next(v for k, v in layers.items() if k.endswith("Combined"))


def _render_cycles(scene, seed, folder, case):
    scene.cycles.seed = seed
    samples = case.samples[1] if case.noisy else 1
    if case.blurred:
        samples = BLURRED_PASSES
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("ignore")
        return render_cycles(scene, folder, (), samples, case.filter_width)["Combined"]


def _noise_of_mean(renders) -> np.ndarray:
    """The square error of the mean of renders with other seeds, of each number; of one, none."""
    if len(renders) == 1:
        return np.zeros_like(renders[0])
    return renders.var(0, ddof=1) / len(renders)


def _compared(ours, theirs, case, warnings) -> Result:
    if not case.with_alpha:  # that has no noise, and would hide some of the colors'
        ours, theirs = ours[..., :3], theirs[..., :3]
    noise = sum(_noise_of_mean(renders) for renders in (ours, theirs))
    a, b = ours.mean(0), theirs.mean(0)
    scale = max(float(np.abs(b).mean()), 1e-6)
    far = np.abs(a - b).max(-1) > 0.1 * scale + 5.0 * np.sqrt(noise.mean())
    # Texture edges and silhouettes between two pixels: a few whole pixels, not a tone.
    inner = ~far if far.mean() <= EDGES else np.ones_like(far)
    squared = max(float(((a - b) ** 2 - noise)[inner].mean()), 0.0)
    bias = float(a[inner].mean() - b[inner].mean()) / scale
    return Result(
        np.sqrt(squared) / scale, bias, float(far.mean()), warnings, a[..., :3], b[..., :3]
    )

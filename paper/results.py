"""All figures of one run, computed in order."""

from __future__ import annotations

import dataclasses
import time

import numpy as np

from .figure1 import Figure1, figure1
from .figure2 import Figure2, figure2
from .figure3 import ShownPixel, figure3
from .figure4 import Rendered, Tables, Truth, compare_tables, figure4, find_truth
from .figure5 import Figure5, figure5
from .inputs import Inputs, make_scene
from .metrics import light_of
from .plan import Plan
from .runs import Run

# Of which pair figures 1, 2, 3 and 5 and the tables are: the paper does not say.
MAIN = 0


@dataclasses.dataclass(frozen=True, eq=False)
class Results:
    """What the report is written from. seconds: of all."""

    inputs: Inputs
    plan: Plan
    truth: Truth
    maps: Figure1
    maps_of_tables: Figure1
    warping: Figure2
    pixels: list[ShownPixel]
    rendered: list[Rendered]
    tables: list[Tables]
    curves: Figure5
    seconds: float


def compute(inputs: Inputs, plan: Plan, threads=0, cache_dir="", tell=lambda text: None) -> Results:
    """Everything; tell: called with a line of text now and then."""
    begin = time.perf_counter()

    def make_run(scene, coefficients=0.05):
        return Run(scene, threads, cache_dir, coefficients, tell)

    rendered, main, truth = [], None, None
    for k, pair in enumerate(inputs.pairs):
        tell(f"figure 4: {pair.material}, {pair.probe}")
        run = make_run(make_scene(inputs, pair, plan.size))
        own = find_truth(run, plan.truth)
        rendered.append(figure4(run, pair, own))
        if k == MAIN:
            main, truth = run, own
    tell("figures 1, 2 and 3")
    lit = truth.lit & (light_of(truth.limited.rgb) > 0.0)
    maps = figure1(main, truth.rgb, lit, plan.map_samples)
    of_tables = figure1(main, truth.limited.rgb, lit, plan.map_samples)
    visibility, picture = truth.limited.visibility, rendered[MAIN].picture
    pixels = figure3(main, picture, visibility)
    warping = figure2(main, _row_of(main, pixels[1].pixel), plan.warped)
    tell("figure 5")
    curves = figure5(main, truth, plan)
    tell("tables of several sizes")
    tables = compare_tables(inputs, inputs.pairs[MAIN], truth, plan, make_run)
    seconds = time.perf_counter() - begin
    figures = truth, maps, of_tables, warping, pixels, rendered, tables, curves
    return Results(inputs, plan, *figures, seconds)


def _row_of(run: Run, pixel: tuple[int, int]) -> int:
    """The row of run.seen() of a pixel (column, row)."""
    wanted = pixel[1] * run.scene.camera.width + pixel[0]
    return int(np.flatnonzero(run.seen().points.pixel == wanted)[0])

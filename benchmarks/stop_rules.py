"""The stop rules at equal mean counts: error, worst pixels and bias, on the scenes of the suite.

    python benchmarks/stop_rules.py [SCENE ...] [--out FILE.json] [--quick]

For each mean count the threshold of PERCEPTUAL, and of PAPER, is searched that gives it (within
1 %); max_samples is the same for all, besides a run of PAPER with its own MAX of 100. Figures are
means over independent seeds, relative to a fixed count of other seeds' samples. Wanted: MRE at most
.8 of the paper's rule and .85 of a fixed count, the 99th percentile at most .6 of the fixed
count's, and a bias in penumbrae (visibility .02 to .98) below .5 %.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
import scenes
from configurations import SCENES, base_settings
from metrics import luminance, measured_pixels
from run_cycles import quiet
from run_iwis import IwisRun, export_open_file

COUNTS = (16, 32, 64)
MOST = 512
PENUMBRA = (0.02, 0.98)
REFERENCE_SEED, REFERENCE_SAMPLES = 90001, 4096
SEEDS = (1, 2, 3)
WITHIN, STEPS = 0.01, 12


class Rule(NamedTuple):
    """name: in the table; settings: of every run; threshold: whether one is searched."""

    name: str
    settings: dict
    threshold: bool


RULES = (
    Rule("fixed", {"stop_rule": "FIXED"}, False),
    Rule("paper", {"stop_rule": "PAPER", "max_samples": MOST}, True),
    Rule("paper, MAX 100", {"stop_rule": "PAPER", "max_samples": 100}, True),
    Rule("perceptual", {"stop_rule": "PERCEPTUAL", "max_samples": MOST}, True),
)


class Row(NamedTuple):
    """Of one rule at one count; bias, noise: in penumbrae, of the sums, and its standard error."""

    scene: str
    rule: str
    threshold: float | None
    samples: float
    mre: float
    p99: float
    bias: float
    noise: float


class Truth(NamedTuple):
    """light: float (h, w); mask: pixels that are measured; penumbra: those that see a part."""

    light: np.ndarray
    mask: np.ndarray
    penumbra: np.ndarray


def truth(run: IwisRun, samples: int) -> Truth:
    """The converged picture."""
    film, _ = run.render(stop_rule="FIXED", max_samples=samples, batch_size=64, seed=REFERENCE_SEED)
    rgb, seen = film.layers["combined"][..., :3], film.layers["visibility"][..., 0]
    mask = measured_pixels(rgb, film.layers["depth"][..., 0] < 1e9)
    return Truth(luminance(rgb), mask, mask & (seen > PENUMBRA[0]) & (seen < PENUMBRA[1]))


def threshold_for(run: IwisRun, rule: Rule, count: int) -> float:
    """The threshold whose mean count is nearest to the wanted one."""
    low, high = 1e-3, 10.0
    for _ in range(STEPS):
        middle = math.sqrt(low * high)
        mean = run.render(error_threshold=middle, seed=SEEDS[0], **rule.settings)[1].samples_mean
        if abs(mean / count - 1.0) < WITHIN:
            return middle
        low, high = (middle, high) if mean > count else (low, middle)
    return middle


def measure(run: IwisRun, scene: str, rule: Rule, count: int, target: Truth) -> Row:
    """One row of the table."""
    settings = dict(rule.settings)
    if rule.threshold:
        settings["error_threshold"] = threshold_for(run, rule, count)
    else:
        settings["max_samples"] = count
    means, errors, lights = [], [], []
    wanted = target.light[target.mask]
    for seed in SEEDS:
        film, stats = run.render(seed=seed, **settings)
        light = luminance(film.layers["combined"])
        means.append(stats.samples_mean)
        errors.append(np.abs(light[target.mask] - wanted) / wanted)
        lights.append(light[target.penumbra])
    lit = target.light[target.penumbra]
    noise = np.sqrt(((np.mean(lights, axis=0) - lit) ** 2).sum()) / lit.sum()
    return Row(
        scene=scene,
        rule=rule.name,
        threshold=settings.get("error_threshold"),
        samples=float(np.mean(means)),
        mre=float(np.mean(errors)),
        p99=float(np.mean([np.quantile(error, 0.99) for error in errors])),
        bias=float(np.mean(lights, axis=0).sum() / lit.sum() - 1.0),
        noise=float(noise),
    )


def print_rows(rows: list[Row]) -> None:
    """The rows of one scene and count; the first is the fixed count's."""
    fixed = rows[0]
    for row in rows:
        threshold = "" if row.threshold is None else f"{row.threshold:.3g}"
        print(
            f"| {row.scene} | {row.rule} | {threshold} | {row.samples:.1f} | {row.mre:.4f} "
            f"| {row.mre / fixed.mre:.2f} | {row.p99:.3f} | {row.p99 / fixed.p99:.2f} "
            f"| {row.bias:+.2%} | {row.noise:.2%} |",
            flush=True,
        )


def open_scene(name: str, quick: bool) -> IwisRun:
    """Build a scene of scenes.py, or open a file, and export it."""
    with quiet():
        if name in SCENES:
            scenes.SCENES[name](**(SCENES[name].quick if quick else SCENES[name].full))
        else:
            bpy.ops.wm.open_mainfile(filepath=str(Path(name).resolve()), load_ui=False)
    return IwisRun(export_open_file(bpy.context.scene).scene, base_settings(threads=1))


def main() -> int:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(description="Compare the stop rules at equal counts.")
    parser.add_argument("scenes", nargs="*", default=list(SCENES), metavar="SCENE")
    parser.add_argument("--out", type=Path, default=scenes.FOLDER / "stop_rules.json")
    parser.add_argument("--quick", action="store_true", help="small pictures")
    options = parser.parse_args()
    kept = []
    print("| scene | rule | E | samples | MRE | /fixed | p99 | /fixed | bias | its noise |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in options.scenes:
        run = open_scene(name, options.quick)
        target = truth(run, REFERENCE_SAMPLES // (4 if options.quick else 1))
        for count in COUNTS:
            rows = [measure(run, Path(name).stem, rule, count, target) for rule in RULES]
            print_rows(rows)
            kept += [row._asdict() for row in rows]
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(kept, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())

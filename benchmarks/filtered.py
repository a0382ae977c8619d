"""CPU time to Cycles' error as users have both: several points a pixel, the default pixel filter.

    python benchmarks/filtered.py [FILE.blend ...] [--width 320] [--threads 2]

The suite compares at the pixels' centres, where only the light is sampled. Here what the points of
a pixel differ by (edges, textures, bumps, reflections) is part of the error, and often most of it.
Without files: those of sample_blends/. Cycles gives direct light only, and lets rays through as
many transparent surfaces as it can; the film is opaque. The error is that against IWIS at SEEDS
times MOST samples of other seeds. One Markdown table is printed; its last column: CPU seconds over
those that a fixed count of IWIS takes to the same MRE.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
from metrics import cost_at, cost_beyond, errors
from run_cycles import render_cycles, use_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

ROOT = Path(__file__).resolve().parent.parent
COUNTS, THRESHOLDS, CYCLES = (16, 32, 64, 128, 256), (0.1, 0.05), (16, 64, 256)
MOST, SEEDS, FIRST_SEED = 512, 4, 1000
FILTER_PX, PANES = 1.5, 1024
HEAD = """| scene | renderer | samples | CPU s | MRE | p99 | bias | times IWIS' |
|---|---|---|---|---|---|---|---|
"""


class Row(NamedTuple):
    """One render: its name, samples a pixel, CPU seconds and metrics.Errors."""

    name: str
    samples: float
    cpu: float
    errors: object


def open_file(path: Path, width: int, threads: int):
    """Open a file as it is compared; returns its scene."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    use_cycles(scene, threads)
    scene.cycles.filter_width, scene.cycles.transparent_max_bounces = FILTER_PX, PANES
    render = scene.render
    render.film_transparent = render.use_border = render.use_motion_blur = False
    render.resolution_y = max(round(render.resolution_y * width / render.resolution_x), 1)
    render.resolution_x, render.resolution_percentage = width, 100
    return scene


def measure(scene, threads: int) -> list[Row]:
    """IWIS and Cycles on the open file."""
    exported = export_open_file(scene)
    for warning in exported.warnings:
        sys.stderr.write(f"{warning}\n")
    base = RenderSettings(stop_rule="FIXED", threads=threads, filter_width=FILTER_PX)
    run = IwisRun(exported.scene, base)
    many = [run.render(max_samples=MOST, seed=FIRST_SEED + k)[0].layers for k in range(SEEDS)]
    reference = np.mean([layers["combined"][..., :3] for layers in many], axis=0)
    objects = many[0]["samples"][..., 0] > 0

    def rendered(name, **changes):
        before = time.process_time()
        layers = run.render(**changes)[0].layers
        cpu = time.process_time() - before
        found = errors(layers["combined"][..., :3], reference, objects)
        return Row(name, float(layers["samples"][objects].mean()), cpu, found)

    rows = [rendered("IWIS, fixed", max_samples=count) for count in COUNTS]
    for threshold in THRESHOLDS:
        changes = {"stop_rule": "PERCEPTUAL", "max_samples": 4096, "error_threshold": threshold}
        rows.append(rendered(f"IWIS, E = {threshold}", **changes))
    for count in CYCLES:
        timed = render_cycles(scene, count)
        rows.append(Row("Cycles", count, timed.cpu, errors(timed.rgb, reference, objects)))
    return rows


def table(scene: str, rows: list[Row]) -> str:
    """Lines of a Markdown table; of Cycles' rows, how much longer it takes than a fixed count."""
    fixed = [row for row in rows if row.name == "IWIS, fixed"]
    lines = []
    for row in rows:
        own, times = row.errors, _times(row, fixed) if row.name == "Cycles" else ""
        lines.append(
            f"| {scene} | {row.name} | {row.samples:.0f} | {row.cpu:.2f} | {own.mre:.4f} "
            f"| {own.p99:.3f} | {own.bias:+.2%} | {times} |\n"
        )
    return "".join(lines)


def _times(row: Row, fixed: list[Row]) -> str:
    """How many times as long a row took as others would to its error, as text."""
    curve = [other.cpu for other in fixed], [other.errors.mre for other in fixed]
    cost = cost_at(row.errors.mre, *curve)
    if cost:
        return f"{row.cpu / cost:.1f}"
    if row.errors.mre > max(curve[1]):
        return f"> {row.cpu / min(curve[0]):.1f}"
    cost = cost_beyond(row.errors.mre, *curve)
    return f"≈ {row.cpu / cost:.1f}" if cost else "-"


def main() -> None:
    """Print the table of all files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.blend")
    parser.add_argument("--width", type=int, default=320, help="of the pictures, in pixels")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    files = options.files or sorted((ROOT / "sample_blends").glob("*.blend"))
    sys.stdout.write(HEAD)
    for path in files:
        scene = open_file(path.resolve(), options.width, options.threads)
        sys.stdout.write(table(path.stem, measure(scene, options.threads)))
        sys.stdout.flush()


if __name__ == "__main__":
    main()

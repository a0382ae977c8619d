"""What denoising does to the error, beside Cycles and its own denoiser at equal samples.

    python benchmarks/denoised.py [FILE.blend ...] [--pixels 130000] [--threads 2] [--out FOLDER]

Without files: four of sample_blends/. Direct light only, the default pixel filter, a fixed count of
samples, an opaque film; both denoisers as they are set by default (albedo and normal, accurate
prefilter, high quality). The error is that against IWIS at SEEDS times MOST samples of other seeds.
One Markdown table of mean relative errors is printed; with --out, all pictures are kept.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from filtered import FILTER_PX, open_file
from metrics import errors
from run_cycles import render_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.denoised_render import render_denoised
from iwis.core.denoising.denoise import NOISY
from iwis.core.film import Film
from iwis.core.settings import DenoiseSettings, RenderSettings
from iwis.iwis_addon.denoiser import denoising

ROOT = Path(__file__).resolve().parent.parent
NAMES, COUNTS = ("product", "statue", "foliage", "interior"), (8, 16, 64)
MOST, SEEDS, FIRST_SEED = 512, 3, 1000
HEAD = """| scene | samples | IWIS: noisy | denoised | Cycles: noisy | denoised | denoiser, CPU s |
|---|---|---|---|---|---|---|
"""


def denoised(run: IwisRun, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Combined noisy and denoised, and the denoiser's CPU seconds."""
    film, on = Film(run.scene.camera.region), denoising(DenoiseSettings(denoise=True))
    stats = render_denoised(run.scene, run.settings(max_samples=count), on, False, film, run.cache)
    for warning in stats.warnings:
        sys.stderr.write(f"{warning}\n")
    layers = film.layers
    return layers[NOISY][..., :3], layers["combined"][..., :3], stats.cpu_seconds["denoising"]


def measure(scene, threads: int) -> tuple[list[str], dict[str, np.ndarray]]:
    """The table's rows without the scene's name, and all pictures by name."""
    exported = export_open_file(scene)
    base = RenderSettings(stop_rule="FIXED", threads=threads, filter_width=FILTER_PX)
    run = IwisRun(exported.scene, base)
    many = [run.render(max_samples=MOST, seed=FIRST_SEED + k)[0].layers for k in range(SEEDS)]
    reference = np.mean([layers["combined"][..., :3] for layers in many], axis=0)
    objects = many[0]["samples"][..., 0] > 0
    rows, pictures = [], {"reference": reference}
    for count in COUNTS:
        noisy, clean, cpu = denoised(run, count)
        own = {f"iwis-{count}-noisy": noisy, f"iwis-{count}": clean}
        for use in (False, True):
            scene.cycles.use_denoising = use
            own[f"cycles-{count}{'' if use else '-noisy'}"] = render_cycles(scene, count).rgb
        found = [errors(picture, reference, objects).mre for picture in own.values()]
        cells = " | ".join(f"{mre:.4f}" for mre in found)
        rows.append(f"{count} | {cells} | {cpu:.1f} |\n")
        pictures |= own
    return rows, pictures


def main() -> None:
    """Print the table of all files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.blend")
    parser.add_argument("--pixels", type=int, default=130_000, help="of each picture, about")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, help="folder of NAME.npz, all pictures of a scene")
    options = parser.parse_args()
    files = options.files or [ROOT / "sample_blends" / f"{name}.blend" for name in NAMES]
    sys.stdout.write(HEAD)
    for path in files:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()))
        render = bpy.context.scene.render
        width = round((options.pixels * render.resolution_x / render.resolution_y) ** 0.5)
        started = time.perf_counter()
        rows, pictures = measure(open_file(path.resolve(), width, options.threads), options.threads)
        sys.stdout.write("".join(f"| {path.stem} | {row}" for row in rows))
        sys.stdout.flush()
        sys.stderr.write(f"{path.stem}: {time.perf_counter() - started:.0f} s\n")
        if options.out:
            options.out.mkdir(parents=True, exist_ok=True)
            np.savez(options.out / f"{path.stem}.npz", **pictures)


if __name__ == "__main__":
    main()

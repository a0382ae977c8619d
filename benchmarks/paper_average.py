"""The paper's average: samples a pixel on the Buddha, 200x400, E = .1, MAX = 100.

    python benchmarks/paper_average.py --data FOLDER [--out FOLDER] [--only TEXT]

[Huang07] reports 25 to 30 samples a pixel over its pictures. FOLDER is the user's own, for the data
may not be passed on: mesh/happy_buddha.obj (y up) and env/grace.hdr, env/rnl.exr, env/uffizi.hdr.
Prints the mean over object pixels and over all, the mean of the head and of the feet with the hem
above them, and writes NAME.png: the picture, and its samples from black (0) to white (MAX). The
paper does not say how its probes are turned (--turn).
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
import scenes
from pictures import developed, heat_picture, save_png
from run_cycles import quiet
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

MESH = "mesh/happy_buddha.obj"
PROBES = ("env/grace.hdr", "env/rnl.exr", "env/uffizi.hdr")
SIZE, VIEW_DEG, MARGIN = (200, 400), 20.0, 1.02
# Parts of the figure, as fractions of its height from its middle below: (left, right, low, high).
HEAD, FEET = (-0.03, 0.1, 0.74, 0.9), (-0.3, 0.3, 0.15, 0.27)
SURFACES = {
    "diffuse": lambda: scenes.diffuse((0.7, 0.7, 0.7)),
    "glossy": lambda: scenes.principled((0.8, 0.55, 0.3), 0.3, 1.0),
}


class Average(NamedTuple):
    """Samples a pixel: mean over object pixels, over all, over head and feet; seconds of CPU."""

    objects: float
    everything: float
    head: float
    feet: float
    coverage: float
    sampling: float
    tables: float


def build(data: Path, probe: str, surface: str, turn_deg: float):
    """The Buddha, z up, filling the portrait picture; returns the open file's scene."""
    scene = scenes.new_scene("hall", turn_deg, SIZE)
    texture = next(n for n in scene.world.node_tree.nodes if n.type == "TEX_ENVIRONMENT")
    texture.image = bpy.data.images.load(str((data / probe).resolve()))
    with quiet():
        bpy.ops.wm.obj_import(filepath=str(data / MESH), forward_axis="NEGATIVE_Z", up_axis="Y")
    buddha = bpy.context.selected_objects[0]
    buddha.data.materials.clear()
    buddha.data.materials.append(SURFACES[surface]())
    buddha.data.shade_smooth()
    bpy.context.view_layer.update()
    vertices = np.empty((len(buddha.data.vertices), 3), np.float32)
    buddha.data.vertices.foreach_get("co", vertices.ravel())
    _frame(scene, vertices @ np.array(buddha.matrix_world)[:3, :3].T)
    return scene


def _frame(scene, vertices) -> None:
    """A camera along y whose picture the vertices fill."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = (low + high) / 2.0
    slope = math.tan(math.radians(VIEW_DEG) / 2.0) / MARGIN
    slopes = np.array([slope, slope * SIZE[1] / SIZE[0]])
    aside = np.abs(vertices - middle)[:, [0, 2]] / slopes
    distance = (aside.max(axis=1) + middle[1] - vertices[:, 1]).max()
    place = middle - np.array([0.0, distance, 0.0])
    scenes.add_camera(scene, tuple(place), tuple(middle), VIEW_DEG)


def _part(film, part) -> np.ndarray:
    """bool (h, w): object pixels within (left, right, low, high) of the figure."""
    position = film.layers["position"]
    hit = film.layers["depth"][..., 0] < 1e9
    low, high = position[hit].min(axis=0), position[hit].max(axis=0)
    height = high[2] - low[2]
    x = (position[..., 0] - (low[0] + high[0]) / 2.0) / height
    z = (position[..., 2] - low[2]) / height
    return hit & (part[0] < x) & (x < part[1]) & (part[2] < z) & (z < part[3])


def measure(scene, estimator: str, threads: int, path: Path) -> Average:
    """Average of the open file's picture; writes it to path."""
    settings = RenderSettings(
        estimator=estimator,
        stop_rule="PAPER",
        error_threshold=0.1,
        max_samples=100,
        pixel_filter="CENTER",
        threads=threads,
    )
    run = IwisRun(export_open_file(scene).scene, settings)
    run.render(max_samples=1, error_threshold=0.0)  # compiles the kernels, builds the tables
    film, stats = run.render()
    samples = film.layers["samples"][..., 0]
    hit = film.layers["depth"][..., 0] < 1e9
    rgb = film.layers["combined"][..., :3]
    white = float(np.quantile(rgb[hit], 0.98))
    save_png(path, developed(rgb, white), heat_picture(samples, 0.0, 100.0))
    return Average(
        objects=float(samples[hit].mean()),
        everything=float(samples.mean()),
        head=float(samples[_part(film, HEAD)].mean()),
        feet=float(samples[_part(film, FEET)].mean()),
        coverage=float(hit.mean()),
        sampling=stats.cpu_seconds["sampling"],
        tables=stats.cpu_seconds["tables"],
    )


def main() -> None:
    """Print a table, write it as paper_average.json."""
    parser = argparse.ArgumentParser(description="Samples a pixel as the paper counts them.")
    parser.add_argument("--data", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--out", type=Path, default=scenes.FOLDER / "paper", metavar="FOLDER")
    parser.add_argument("--only", default="", metavar="TEXT", help="pictures whose name has TEXT")
    parser.add_argument("--turn", type=float, default=0.0, metavar="DEG", help="of the probes")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    missing = [name for name in (MESH, *PROBES) if not (options.data / name).is_file()]
    if missing:
        parser.error(f"{options.data} has no {', '.join(missing)}")
    options.out.mkdir(parents=True, exist_ok=True)
    rows = {}
    print("| picture | object pixels | all pixels | head | feet | coverage | sampling CPU s |")
    print("|---|---|---|---|---|---|---|")
    for surface in SURFACES:
        for probe in PROBES:
            for estimator in ("PAPER", "UNBIASED"):
                name = f"{surface}_{Path(probe).stem}_{estimator.lower()}"
                if options.only not in name:
                    continue
                path = options.out / f"{name}.png"
                scene = build(options.data, probe, surface, options.turn)
                a = measure(scene, estimator, options.threads, path)
                rows[name] = a._asdict()
                means = " | ".join(f"{mean:.1f}" for mean in a[:4])
                print(f"| {name} | {means} | {a.coverage:.0%} | {a.sampling:.2f} |", flush=True)
    (options.out / "paper_average.json").write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()

"""Speed beside Cycles: CPU seconds to a mean relative error, both in one run, by turns.

    python benchmarks/versus_cycles.py [FILE.blend ...] [--reference FILE.exr] [--out FOLDER]

Both do the same work: direct light, one shading point at the centre of each pixel, the same threads
on the CPU, geometry kept between renders. CPU is user + system time: of Cycles' whole render call
(persistent data, after a first render), of IWIS' sampling; what IWIS needs before (export, light,
BVH, all once) and Cycles' first render are printed apart. Counts are doubled until the smallest
error is reached. Without files the diffuse and the glossy statue of scenes.py are built and used.

Without --reference Cycles renders one (--reference-spp) with other seeds, and keeps it beside the
.blend as NAME.reference.exr: its own noise is in both sides' errors alike.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
import scenes
from metrics import Errors, cost_at, errors, luminance, measured_pixels
from run_cycles import quiet, render_cycles, use_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.exr import read_exr_layers, write_exr_layers
from iwis.core.settings import RenderSettings

TARGETS = (0.10, 0.05)
SLOW_SECONDS = 200.0  # of CPU for one render: where doubling ends


class Row(NamedTuple):
    """One render. spp: mean over the object's pixels; cpu: seconds"""

    method: str
    setting: str
    spp: float
    cpu: float
    errors: Errors


def main() -> None:
    """Compare on each file; print tables, write them as OUT/NAME.md and NAME.json."""
    parser = argparse.ArgumentParser(description="Compare the speed of IWIS and Cycles.")
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.blend")
    parser.add_argument("--reference", type=Path, metavar="FILE.exr", help="for one FILE")
    parser.add_argument("--reference-spp", type=int, default=1024)
    parser.add_argument("--percent", type=int, default=0, help="resolution; else the file's")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--max-spp", type=int, default=512)
    parser.add_argument("--repeat", type=int, default=1, help="take the median of so many")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", dest="pairs")
    parser.add_argument("--out", type=Path, default=scenes.FOLDER, metavar="FOLDER")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    files = options.files or [
        scenes.save(name, options.out) for name in ("statue_diffuse", "statue_glossy")
    ]
    for path in files:
        print(compare_file(path, options), flush=True)


def compare_file(path: Path, options) -> str:
    """The report on one .blend, also written to options.out."""
    scene = _open(path, options)
    exported = export_open_file(scene)
    base = dict(pair.split("=", 1) for pair in options.pairs) | {"threads": str(options.threads)}
    run = IwisRun(exported.scene, RenderSettings.from_strings(base))
    film, first = run.render(max_samples=1)
    mask = film.layers["depth"][..., 0] < 1e9
    cycles_first = render_cycles(scene, 1)
    mask &= cycles_first.alpha > 0.5
    reference, noise = _reference(path, scene, mask, options)
    rows = _measure(scene, run, reference, mask, options)
    once = {f"IWIS {phase}": first.cpu_seconds[phase] for phase in ("tables", "bvh")}
    once = {"IWIS export": exported.stats.cpu_seconds["export"]} | once
    once["Cycles first render, 1 sample"] = cycles_first.cpu
    text = _report(path, exported, mask, noise, once, rows)
    (options.out / f"{path.stem}.md").write_text(text)
    data = {"once": once, "noise": noise, "rows": [_flat(row) for row in rows]}
    (options.out / f"{path.stem}.json").write_text(json.dumps(data, indent=1))
    return text


def _open(path, options):
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
    scene = bpy.context.scene
    if options.percent:
        scene.render.resolution_percentage = options.percent
    scene.render.use_border = False
    use_cycles(scene, options.threads)
    return scene


def _reference(path, scene, mask, options):
    """The converged picture and its own mean relative error, where it is known."""
    if options.reference is not None:
        return _read(options.reference, mask.shape), None
    kept = path.with_suffix(".reference.exr")
    if not kept.exists():
        halves = [
            render_cycles(scene, options.reference_spp // 2, seed=k).rgb for k in (1001, 2002)
        ]
        write_exr_layers(kept, {"A": halves[0], "B": halves[1]})
    halves = read_exr_layers(kept)
    a, b = (np.asarray(halves[name][..., :3], np.float64) for name in _order(halves))
    if a.shape[:2] != mask.shape:
        raise SystemExit(f"{kept}: of another size than the render: delete it, or give --reference")
    mean = (a + b) / 2.0
    used = measured_pixels(mean, mask)
    noise = np.abs(luminance(a) - luminance(b))[used] / 2.0 / luminance(mean)[used]
    return mean, float(noise.mean())


def _order(layers):
    names = sorted(layers)
    return names[0], names[-1]


def _read(path, shape):
    (name, *_) = read_exr_layers(path)
    pixels = read_exr_layers(path)[name]
    if pixels.shape[:2] != shape:
        raise SystemExit(
            f"{path}: is {pixels.shape[1]}x{pixels.shape[0]}, the render {shape[::-1]}"
        )
    return np.asarray(pixels[..., :3], np.float64)


def _measure(scene, run, reference, mask, options) -> list[Row]:
    """Every method at doubled counts or halved thresholds, by turns."""
    methods = {"Cycles": _cycles(scene, mask)}
    for rule in ("FIXED", "PAPER"):
        methods[f"IWIS {run.base.estimator}, {rule}"] = _iwis(run, rule, options.max_spp)
    rows, open_methods, step = [], dict(methods), 0
    while open_methods:
        for name, render in list(open_methods.items()):
            runs = [render(step, seed) for seed in range(options.repeat)]
            found = [errors(rgb, reference, mask) for rgb, *_ in runs]
            middle = int(np.argsort([e.mre for e in found])[len(found) // 2])
            cpu = float(np.median([cpu for _, _, _, cpu in runs]))
            rows.append(Row(name, runs[0][1], runs[0][2], cpu, found[middle]))
            reached = found[middle].mre < min(TARGETS)
            count = 8 * 2**step
            if reached or count >= options.max_spp or cpu > SLOW_SECONDS:
                del open_methods[name]
        step += 1
    return sorted(rows, key=lambda row: (list(methods).index(row.method), row.cpu))


def _cycles(scene, mask):
    def render(step, seed):
        count = 8 * 2**step
        timed = render_cycles(scene, count, seed=7 + 13 * seed + count)
        return timed.rgb, f"{count} spp", float(count), timed.cpu

    return render


def _iwis(run, rule, most):
    def render(step, seed):
        count, threshold = 8 * 2**step, 0.4 / 2**step
        changes = {"stop_rule": rule, "seed": seed}
        if rule == "FIXED":
            changes["max_samples"], text = count, f"{count} spp"
        else:
            changes |= {"error_threshold": threshold, "max_samples": most}
            text = f"E = {threshold:g}"
        film, stats = run.render(**changes)
        rgb = film.layers["combined"][..., :3]
        return rgb, text, stats.samples_mean, stats.cpu_seconds["sampling"]

    return render


def costs(rows: list[Row]) -> dict[str, list[float | None]]:
    """Method -> CPU seconds to each of TARGETS."""
    found = {}
    for method in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == method]
        cpu, mre = [row.cpu for row in mine], [row.errors.mre for row in mine]
        found[method] = [cost_at(target, cpu, mre) for target in TARGETS]
    return found


def _report(path, exported, mask, noise, once, rows) -> str:
    lines = [f"## {path.name}", ""]
    own = "unknown" if noise is None else f"{noise:.2%}"
    lines.append(
        f"{mask.shape[1]}x{mask.shape[0]}, {mask.mean():.0%} object pixels, "
        f"{len(exported.scene.mesh.triangles)} triangles; noise of the reference {own}."
    )
    lines.append("Once, CPU s: " + ", ".join(f"{k} {v:.2f}" for k, v in once.items()) + ".")
    lines += ["", "| method | setting | spp | CPU s | MRE | relMSE | bias | p99 |"]
    lines.append("|---|---|---|---|---|---|---|---|")
    for row in rows:
        e = row.errors
        lines.append(
            f"| {row.method} | {row.setting} | {row.spp:.1f} | {row.cpu:.2f} | {e.mre:.4f} "
            f"| {e.relmse:.5f} | {e.bias:+.2%} | {e.p99:.3f} |"
        )
    names = " | ".join(f"CPU s to MRE {t:g} | Cycles / it" for t in TARGETS)
    lines += ["", f"| method | {names} |", "|---|" + "---|---|" * len(TARGETS)]
    found = costs(rows)
    for method, seconds in found.items():
        cells = []
        for mine, theirs in zip(seconds, found["Cycles"], strict=True):
            cells.append("-" if mine is None else f"{mine:.2f}")
            cells.append("-" if None in (mine, theirs) else f"{theirs / mine:.1f}")
        lines.append(f"| {method} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _flat(row: Row) -> dict:
    return row._asdict() | {"errors": row.errors._asdict()}


if __name__ == "__main__":
    main()

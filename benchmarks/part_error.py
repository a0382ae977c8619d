"""Part "error": error against CPU seconds of every configuration, by turns, on one scene."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from agreement import edge_pixels
from configurations import CONFIGURATIONS, EDGE_RADIUS_PX, TARGETS, Effort
from converged import Converged, converge, kept, key_of
from machine import commit, load
from methods import Renderers, make_method, reference_method
from metrics import (
    Errors,
    errors,
    luminance,
    measured_pixels,
    relative_difference,
    without_noise,
)
from run_core import CoreRun
from run_mitsuba import MitsubaRun

from iwis.core.scene import DIFFUSE

# A step of so much more work that leaves so much of an error, if that is small: it is a bias.
WORK, STALLED, SMALL = 1.5, 0.92, 0.5
PENUMBRA = (0.1, 0.9)  # part of the samples that see the light
SEED_STEP = 1009


class Bench(NamedTuple):
    """One scene to measure on.

    name: of the scene; scene: open in bpy; run: run_iwis.IwisRun of its export
    folder, pictures: of results, of JPEGs; mitsuba: Python that has it, or None
    renew: make the references anew
    """

    name: str
    scene: object
    run: object
    effort: Effort
    threads: int
    folder: Path
    pictures: Path
    mitsuba: Path | None
    renew: bool

    def kept_reference(self, renderer: str, renderers: Renderers, mask) -> Converged:
        """The converged picture by a renderer, made now or earlier."""
        path = (
            self.folder
            / "references"
            / f"{self.name}-{renderer}-{key_of(self.run.scene, self.effort)}.npz"
        )

        def make():
            render = reference_method(renderer, renderers)
            seconds = self.effort.reference_seconds[renderer]
            return converge(render, mask, self.effort, seconds, commit())

        return kept(path, make, self.renew)

    def masks(self) -> tuple[np.ndarray, np.ndarray]:
        """bool (h, w): pixels that show an object; those of them with an edge at their centre."""
        film, _ = self.run.render(stop_rule="FIXED", max_samples=1)
        hit = film.layers["depth"][..., 0] < 1e9
        return hit, hit & edge_pixels(self.run, EDGE_RADIUS_PX)

    def penumbra(self) -> np.ndarray:
        """bool (h, w): pixels that see a part of the light, by PENUMBRA."""
        film, _ = self.run.render(stop_rule="FIXED", max_samples=self.effort.thread_samples)
        low, high = PENUMBRA
        seen = film.layers["visibility"][..., 0]
        return (low < seen) & (seen < high)


def measure(bench: Bench) -> dict:
    """All points of all curves, for JSON."""
    with _mitsuba(bench) as mitsuba:
        core = CoreRun(bench.run.scene, bench.run.cache, bench.threads)
        renderers = Renderers(bench.scene, bench.run, core, mitsuba)
        hit, edges = bench.masks()
        mask, penumbra = hit & ~edges, bench.penumbra()
        reference = bench.kept_reference("iwis", renderers, mask)
        found = {
            "width": hit.shape[1],
            "height": hit.shape[0],
            "triangles": len(bench.run.scene.mesh.triangles),
            "object_pixels": int(hit.sum()),
            "edge_pixels": int(edges.sum()),
            "measured_pixels": int(measured_pixels(reference.mean, mask).sum()),
            "reference": _told(reference),
            "penumbra_pixels": int((penumbra & mask).sum()),
            "load": load(),
        }
        references = {"mitsuba": reference}
        if mitsuba is not None:
            found["mitsuba_version"] = mitsuba.version
            if (bench.run.scene.materials.model != DIFFUSE).any():
                own = references["mitsuba"] = bench.kept_reference("mitsuba", renderers, mask)
                used = measured_pixels(reference.mean, mask)
                difference = relative_difference(own.mean, reference.mean, used)[used]
                found["mitsuba_reference"] = _told(own) | {
                    "difference": float(np.abs(difference).mean())
                }
        found["points"] = _curves(bench, renderers, reference, references, mask, penumbra)
    return found


@contextlib.contextmanager
def _mitsuba(bench):
    """The MitsubaRun of a scene; None where there is no Mitsuba, or none that works."""
    with contextlib.ExitStack() as stack:
        run = None
        if bench.mitsuba is not None:
            try:
                run = MitsubaRun(bench.mitsuba, bench.run.scene, bench.threads)
                stack.enter_context(run)
                run.render(4, 0, emitter=1, bsdf=1)  # an LLVM too old ends it here
            except OSError as error:
                print(f"going on without Mitsuba: {error}", file=sys.stderr, flush=True)
                run = None
        yield run


def _told(reference: Converged) -> dict:
    return {key: value for key, value in reference._asdict().items() if key != "mean"}


def _curves(bench, renderers, reference, references, mask, penumbra) -> list[dict]:
    """Points of every configuration, step by step; all configurations take turns."""
    made = {c.name: make_method(c, renderers) for c in CONFIGURATIONS}
    methods = {name: method for name, method in made.items() if method is not None}
    going = [c for c in CONFIGURATIONS if c.name in methods]
    for c in going:  # compiles kernels, builds tables, loads the scene into Cycles
        methods[c.name](c.value(0), 1)
    points, step, start = [], 0, perf_counter()
    while going:
        shots = {c.name: [] for c in going}
        for repeat in range(bench.effort.repeats):
            for c in going:
                mine = shots[c.name]
                if not mine or mine[0].cpu < bench.effort.short_seconds:
                    seed = SEED_STEP * (repeat + 1) + 17 * step
                    mine.append(methods[c.name](c.value(step), seed))
        for c in list(going):
            wanted = references.get(c.renderer, reference)
            points.append(_point(c, step, shots[c.name], wanted, mask, penumbra))
            if _ended(points, c, bench.effort, wanted.noise):
                going.remove(c)
        print(
            f"{bench.name}: step {step}, {len(going)} go on, {perf_counter() - start:.0f} s",
            flush=True,
        )
        step += 1
    return points


def _point(configuration, step, shots, reference, mask, penumbra) -> dict:
    found = [errors(shot.rgb, reference.mean, mask) for shot in shots]
    medians = Errors(*(float(np.median(column)) for column in zip(*found, strict=True)))
    return {
        "configuration": configuration.name,
        "value": configuration.value(step),
        "samples": shots[0].samples,
        "cpu": float(np.median([shot.cpu for shot in shots])),
        "wall": float(np.median([shot.wall for shot in shots])),
        "cpu_of_each": [shot.cpu for shot in shots],
        "penumbra_bias": _penumbra_bias(shots, reference, mask & penumbra),
        **medians._asdict(),
    }


def _penumbra_bias(shots, reference, mask) -> float:
    """Signed relative difference of the sums over half-lit pixels, of all repeats together."""
    wanted = luminance(reference.mean)[mask].sum()
    found = [luminance(shot.rgb)[mask].sum() for shot in shots]
    return float(np.mean(found) / wanted - 1.0) if wanted else 0.0


def _ended(points, configuration, effort, noise) -> bool:
    """Whether a curve needs, or may have, no further point."""
    mine = [p for p in points if p["configuration"] == configuration.name]
    last = mine[-1]
    enough = without_noise(last["mre"], noise) < max(0.95 * min(TARGETS), 1.2 * noise)
    before = mine[-2] if len(mine) > 2 else None
    worked = before is not None and last["samples"] > WORK * before["samples"]
    stalled = worked and SMALL > last["mre"] > STALLED * before["mre"]
    return enough or stalled or 2.0 * last["cpu"] > effort.render_seconds[configuration.renderer]

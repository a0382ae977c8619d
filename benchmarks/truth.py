"""Mode UNBIASED against Cycles: the diffuse statue, and a sweep of the Principled BSDF.

    python benchmarks/truth.py [--quick] [--only TEXT] [--out FOLDER]

Each side renders independent pictures of 1024 samples a pixel at pixel centres. Wanted: a signed
difference within .2 %, a mean absolute one within 1.3 times what the noise of both explains, and a
difference picture without a pattern: look at the PNGs (IWIS, Cycles, difference).
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scenes
from agreement import Agreement, compare, edge_pixels
from pictures import developed, difference_picture, save_png
from run_cycles import render_cycles, use_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

SIGNED_LIMIT, RATIO_LIMIT = 2e-3, 1.3
GAIN = 20.0  # of the difference picture: 5 % is full colour
COLOR = (0.8, 0.3, 0.1)


class Case(NamedTuple):
    """A scene to render; detail: of the statue; size: pixels; samples: a picture."""

    name: str
    surface: object
    detail: float
    size: tuple[int, int]
    samples: int = 1024
    pictures: int = 2


class Verdict(NamedTuple):
    """What came of a case.

    edges: object pixels left out, on an edge; worst: 99.9 % quantile of the difference
    coverage_differs: pixels, not on edges, that only one of the two finds empty
    """

    agreement: Agreement
    edges: int
    worst: float
    coverage_differs: int

    @property
    def good(self) -> bool:
        return abs(self.agreement.signed) <= SIGNED_LIMIT and self.agreement.ratio <= RATIO_LIMIT


def cases(quick: bool) -> list[Case]:
    """The diffuse statue, and metallic 0, 1 x roughness .3, .5, .8 x both distributions."""
    detail, size = (0.3, (48, 96)) if quick else (1.0, (80, 160))
    found = [Case("diffuse", lambda: scenes.diffuse(scenes.STONE), detail, size)]
    size = (32, 64) if quick else (48, 96)
    for distribution in ("GGX", "MULTI_GGX"):
        for metallic in (0.0, 1.0):
            for roughness in (0.3, 0.5, 0.8):

                def surface(r=roughness, m=metallic, d=distribution):
                    return scenes.principled(COLOR, r, m, d)

                name = f"{distribution.lower()}_metallic{metallic:.0f}_roughness{roughness}"
                found.append(Case(name, surface, 0.3, size))
    return found


def judge(case: Case, folder: Path | None = None, threads: int = 2) -> Verdict:
    """Build, render with both, compare; writes folder/NAME.png if there is a folder."""
    scene = scenes.statue(case.surface, detail=case.detail, size=case.size)
    return judge_open_file(scene, case, folder, threads)


def judge_open_file(scene, case: Case, folder: Path | None, threads: int) -> Verdict:
    """As judge(), for the scene that is open in bpy."""
    use_cycles(scene, threads)
    settings = RenderSettings(
        estimator="UNBIASED",
        stop_rule="FIXED",
        max_samples=case.samples,
        pixel_filter="CENTER",
        threads=threads,
    )
    run = IwisRun(export_open_file(scene).scene, settings)
    films = [run.render(seed=k)[0] for k in range(case.pictures)]
    timed = [render_cycles(scene, case.samples, seed=100 + k) for k in range(case.pictures)]
    hit = films[0].layers["depth"][..., 0] < 1e9
    covered = timed[0].alpha > 0.5
    edges = edge_pixels(run)
    mine, theirs = [f.layers["combined"][..., :3] for f in films], [t.rgb for t in timed]
    agreement, difference = compare(mine, theirs, hit & covered & ~edges)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        white = float(np.quantile(np.mean(theirs, axis=0)[covered], 0.98))
        panels = [developed(np.mean(rgb, axis=0), white) for rgb in (mine, theirs)]
        zoom = max(1, 480 // case.size[1])
        save_png(
            folder / f"{case.name}.png", *panels, difference_picture(difference, GAIN), zoom=zoom
        )
    worst = float(np.quantile(np.abs(difference[difference != 0.0]), 0.999))
    return Verdict(
        agreement, int((edges & hit).sum()), worst, int(((hit != covered) & ~edges).sum())
    )


def main() -> int:
    """Print a table; 1 if a case is not good."""
    parser = argparse.ArgumentParser(description="Compare mode UNBIASED with Cycles.")
    parser.add_argument("--quick", action="store_true", help="smaller pictures")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose name has TEXT")
    parser.add_argument("--out", type=Path, default=scenes.FOLDER / "truth", metavar="FOLDER")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    rows = []
    print("| case | pixels | edges | signed | mean abs | noise | ratio | 99.9 % | |")
    print("|---|---|---|---|---|---|---|---|---|")
    for case in cases(options.quick):
        if options.only not in case.name:
            continue
        verdict = judge(case, options.out, options.threads)
        a = verdict.agreement
        rows.append({"case": case.name, **a._asdict(), "ratio": a.ratio, "good": verdict.good})
        print(
            f"| {case.name} | {a.pixels} | {verdict.edges} | {a.signed:+.3%} "
            f"| {a.mean_absolute:.3%} | {a.noise:.3%} | {a.ratio:.2f} | {verdict.worst:.1%} "
            f"| {'good' if verdict.good else 'BAD'} |",
            flush=True,
        )
    (options.out / "truth.json").write_text(json.dumps(rows, indent=1))
    return 0 if all(row["good"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())

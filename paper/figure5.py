"""Figure 5: error against samples, the paper's method beside others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .figure4 import Truth
from .metrics import light_of, mre, rms
from .plan import Plan
from .runs import ADAPTIVE, METHODS, Picture, Run

IIS = {"IIS100": 100, "IIS200": 200}
OURS = "IWIS, rule PERCEPTUAL"
OURS_PAPER = "paper's samples, rule PERCEPTUAL"
_BISECTIONS = 6


class Point(NamedTuple):
    """mean: samples a pixel of the object; MRE and root mean square of e_i against the truth, and
    MRE against the reference that the tables limit
    """

    mean: float
    mre: float
    rms: float
    from_limited: float


class Crop(NamedTuple):
    """A part of the figure. rows: of the picture, from below; pictures: float64 (h, w, 3) by method
    errors: MRE by method against the table-limited reference
    """

    name: str
    samples: int
    means: dict[str, float]
    pictures: dict[str, np.ndarray]
    errors: dict[str, float]


class Figure5(NamedTuple):
    """curves: points by method, in order of their samples."""

    curves: dict[str, list[Point]]
    crops: list[Crop]


def figure5(run: Run, truth: Truth, plan: Plan) -> Figure5:
    """All curves, and crops of head and feet."""
    shown = run.shown()

    def point(picture: Picture) -> Point:
        lit, limited = truth.lit, truth.limited.rgb
        solid = lit & (light_of(limited) > 0.0)
        return Point(
            float(picture.samples[shown].mean()),
            mre(picture.rgb, truth.rgb, lit),
            rms(picture.rgb, truth.rgb, lit),
            mre(picture.rgb, limited, solid),
        )

    curves = {name: [] for name in (*METHODS, *IIS, ADAPTIVE, OURS_PAPER, OURS)}
    for count in plan.counts:
        for method in METHODS:
            curves[method].append(point(run.sampled(method, count)))
    for threshold in plan.thresholds:
        for name, most in IIS.items():
            curves[name].append(point(run.picture(error_threshold=threshold, max_samples=most)))
        if threshold == 0.0:
            continue
        curves[ADAPTIVE].append(point(run.sampled(ADAPTIVE, max(IIS.values()), threshold)))
        rule = {"stop_rule": "PERCEPTUAL", "error_threshold": threshold, "max_samples": 400}
        curves[OURS_PAPER].append(point(run.picture(**rule)))
        curves[OURS].append(point(run.picture(estimator="UNBIASED", **rule)))
    for points in curves.values():
        points.sort(key=lambda one: one.mean)
    return Figure5(curves, _crops(run, truth, plan, shown))


def at_samples(points: list[Point], mean: float, what: str = "mre") -> float:
    """A curve at that many samples, between its points (log-log); nan outside."""
    x = np.log([p.mean for p in points])
    y = np.log([getattr(p, what) for p in points])
    if not x[0] <= np.log(mean) <= x[-1]:
        return float("nan")
    return float(np.exp(np.interp(np.log(mean), x, y)))


def with_mean(run: Run, shown, mean: float, most: int) -> Picture:
    """A picture of the paper's rule whose E is such that its pixels have about that mean."""
    low, high = 0.01, 2.0
    for _ in range(_BISECTIONS):
        threshold = float(np.sqrt(low * high))
        picture = run.picture(error_threshold=threshold, max_samples=most)
        if picture.samples[shown].mean() > mean:
            low = threshold
        else:
            high = threshold
    return picture


def part_rows(shown: np.ndarray) -> dict[str, slice]:
    """The rows of the head (upper 22 % of the figure) and of the feet (lower 22 %)."""
    rows = np.flatnonzero(shown.any(axis=1))
    low, high = int(rows[0]), int(rows[-1]) + 1
    part = max((high - low) * 22 // 100, 1)
    return {"head": slice(high - part, high), "feet": slice(low, low + part)}


def _crops(run, truth, plan, shown) -> list[Crop]:
    crops = []
    for count in plan.crops:
        pictures = {"WIS": run.sampled("WIS", count), "IIS100": with_mean(run, shown, count, 100)}
        for name, rows in part_rows(shown).items():
            lit = truth.lit[rows] & (light_of(truth.limited.rgb[rows]) > 0.0)
            errors = {
                method: mre(picture.rgb[rows], truth.limited.rgb[rows], lit)
                for method, picture in pictures.items()
            }
            means = {m: float(p.samples[rows][shown[rows]].mean()) for m, p in pictures.items()}
            shots = {m: p.rgb[rows] for m, p in pictures.items()}
            crops.append(
                Crop(name, count, means, {"reference": truth.limited.rgb[rows], **shots}, errors)
            )
    return crops

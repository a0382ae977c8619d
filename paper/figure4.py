"""Figure 4: the figure in three materials and three probes, and how far off each picture is.

Two references tell two errors apart: the true one (mode UNBIASED, the full BRDF and probe), and the
one that the tables limit (mode PAPER with many samples), which the paper's sampling converges to.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .inputs import Inputs, Pair, make_scene
from .metrics import light_of, lit_pixels, mre
from .plan import Plan
from .runs import Picture, Run

E, MAX, ROUND = 0.1, 100, 8


class Truth(NamedTuple):
    """rgb: float64 (h, w, 3), true; limited: by the tables; lit: bool (h, w), of metrics.py"""

    rgb: np.ndarray
    limited: Picture
    lit: np.ndarray


class Rendered(NamedTuple):
    """A pair's picture. mean: samples a pixel of the object; at_most: share of pixels at MAX
    everywhere: mean samples of all pixels, the background's 0 among them
    seconds, cpu_seconds: warm tables
    from_true, from_limited: MRE; limited_from_true: MRE of the tables alone
    bias: of the mean light, against the truth
    """

    pair: Pair
    picture: Picture
    mean: float
    everywhere: float
    at_most: float
    from_true: float
    from_limited: float
    limited_from_true: float
    bias: float
    notes: tuple[str, ...]


def find_truth(run: Run, samples: int) -> Truth:
    """Both references of a run, of that many samples a pixel."""
    shown = run.shown()
    true = run.picture(estimator="UNBIASED", stop_rule="FIXED", max_samples=samples)
    limited = run.picture(stop_rule="FIXED", max_samples=samples)
    return Truth(true.rgb, limited, lit_pixels(true.rgb, shown))


def figure4(run: Run, pair: Pair, truth: Truth) -> Rendered:
    """One of the three pictures."""
    shown = run.shown()
    run.picture(error_threshold=E, max_samples=MAX)  # warms up what is compiled and kept
    picture = run.picture(error_threshold=E, max_samples=MAX)
    lit, limited = truth.lit, truth.limited.rgb
    return Rendered(
        pair,
        picture,
        float(picture.samples[shown].mean()),
        float(picture.samples.mean()),
        float((picture.samples[shown] >= MAX).mean()),
        mre(picture.rgb, truth.rgb, lit),
        mre(picture.rgb, limited, lit & (light_of(limited) > 0.0)),
        mre(limited, truth.rgb, lit),
        float(light_of(picture.rgb)[lit].sum() / light_of(truth.rgb)[lit].sum() - 1.0),
        tuple(run.notes),
    )


def rays_from_scratch(samples: np.ndarray, batch: int) -> np.ndarray:
    """Shadow rays of pixels whose every round of `batch` points traced all points before it again.

    samples: int (...), what each pixel took, the last round perhaps in part
    """
    rounds = -(-samples.astype(np.int64) // batch)
    return np.where(rounds > 0, batch * rounds * (rounds - 1) // 2 + samples, 0)


class Tables(NamedTuple):
    """Errors with a share of the tables' coefficients; seconds: of building them, 0 = were kept."""

    coefficients: float
    from_true: float
    from_limited: float
    limited_from_true: float
    unoccluded: float  # MRE of I_s alone, no sampling in it
    notes: tuple[str, ...]


def compare_tables(inputs: Inputs, pair: Pair, truth: Truth, plan: Plan, make_run) -> list[Tables]:
    """One pair with several shares of coefficients; make_run(scene, coefficients) -> Run."""
    scene = make_scene(inputs, pair, plan.size)
    full = None
    rows = []
    for share in sorted(plan.coefficients, reverse=True):
        run = make_run(scene, share)
        limited = run.picture(stop_rule="FIXED", max_samples=plan.truth)
        picture = run.picture(error_threshold=E, max_samples=MAX)
        full = limited.unoccluded if full is None else full
        lit = truth.lit & (light_of(limited.rgb) > 0.0)
        rows.append(
            Tables(
                share,
                mre(picture.rgb, truth.rgb, truth.lit),
                mre(picture.rgb, limited.rgb, lit),
                mre(limited.rgb, truth.rgb, truth.lit),
                mre(limited.unoccluded, full, truth.lit),
                tuple(run.notes),
            )
        )
    return rows[::-1]

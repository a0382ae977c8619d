"""The Light Falloff node, and what light comes to that depends on how far it goes.

As in Cycles (svm/light_path.h): light falls off with the square of the distance by itself, so
Linear multiplies by the distance and Constant by its square. What is infinitely far shines as if
there were no such node, which is what Cycles renders (measured).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..data.lamps import FALLOFF_STEPS, NEAREST, falloff_knots
from ..data.program import Op

LIGHT_FALLOFF, LIGHT_PATH = "ShaderNodeLightFalloff", "ShaderNodeLightPath"
INFINITELY_FAR = np.finfo(np.float32).max
# Powers of two, metres, at which light is looked at; a nearest one to 1 m is what it is told for.
_POWERS = np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 6, -6, 9])
_SAME = 1e-3  # of the brightest place: what may differ and still be one falloff
_BRIGHT = 4  # places that a falloff is measured at, for each channel


class Falloff(NamedTuple):
    """How light that leaves some places changes with the distance that it goes.

    table: float32 (FALLOFF_ROWS, 3), of Lamps.falloffs: factor of what it is at distance, metres
    color: float32 (3,), the mean of all places there; even: whether all of them are the same there
    whole: whether the table is right for all places
    """

    table: np.ndarray
    distance: float
    color: np.ndarray
    even: bool
    whole: bool


def light_falloff(context, settings, inputs):
    """Strength as it falls off. settings: outputs"""
    far = np.asarray(context.ray_length, np.float64)
    strength, smooth = inputs["Strength"], inputs["Smooth"]
    finite = far < INFINITELY_FAR
    squared = np.where(finite, far * far, 1.0)
    own = np.where(finite & (smooth > 0.0), squared / np.maximum(smooth + squared, 1e-300), 1.0)
    factors = {"Quadratic": 1.0, "Linear": np.where(finite, far, 1.0), "Constant": squared}
    return {
        name: (strength * own * factors[name]).astype(np.float32) for name in settings["outputs"]
    }


def asks_for_distance(ops: list[Op]) -> bool:
    """Whether what some operations give depends on how far a ray goes."""
    return any(
        op.kind == LIGHT_FALLOFF
        or (op.kind == LIGHT_PATH and "Ray Length" in op.settings["outputs"])
        for op in ops
    )


def falloff_of(light: Callable[[np.ndarray, np.ndarray], np.ndarray], n: int) -> Falloff:
    """The falloff of light from places 0 ... n - 1.

    light(place int (k,), distance float32 (k,)): radiance, float32 (k, 3)
    """
    distances = np.ldexp(1.0, _POWERS).astype(np.float32)
    given = np.repeat(np.arange(n), len(distances)), np.tile(distances, n)
    seen = light(*given).astype(np.float64).reshape(n, -1, 3)
    lit = seen.sum(axis=0) > 0.0
    first = int(np.argmax(lit.sum(axis=1)))  # the nearest to 1 m in which most channels shine
    at = seen[:, first]
    bright = np.unique(np.argsort(-at, axis=0, kind="stable")[:_BRIGHT])
    every = falloff_knots()
    given = np.repeat(bright, len(every)), np.tile(every, len(bright))
    sums = light(*given).astype(np.float64).reshape(len(bright), -1, 3).sum(axis=0)
    base = at[bright].sum(axis=0)
    table = np.divide(sums, base, out=np.zeros_like(sums), where=base > 0.0)
    expected = at[:, None] * table[(_POWERS - NEAREST) * FALLOFF_STEPS]
    most = _SAME * np.maximum(seen.max(axis=(0, 2)), 1e-30)[:, None]
    return Falloff(
        table=table.astype(np.float32),
        distance=float(distances[first]),
        color=at.mean(axis=0).astype(np.float32),
        even=bool((np.ptp(at, axis=0) <= _SAME * max(at.max(), 1e-30)).all()),
        whole=bool((np.abs(seen - expected) <= most).all()),
    )


FUNCTIONS = {LIGHT_FALLOFF: light_falloff}

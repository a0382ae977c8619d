"""How much is computed: the paper's size, or a small one that shows the machinery at work."""

from __future__ import annotations

from typing import NamedTuple


class Plan(NamedTuple):
    """size: (width, height) of the Buddha; truth: samples of a reference
    counts: of the methods of fixed counts; thresholds: E of the incremental ones, figure 5; 0: MAX
    coefficients: shares of the tables' coefficients that are compared; crops: mean samples
    map_samples: of figure 1; warped: n of figure 2
    """

    size: tuple[int, int]
    truth: int
    counts: tuple[int, ...]
    thresholds: tuple[float, ...]
    coefficients: tuple[float, ...]
    crops: tuple[int, ...]
    map_samples: int
    warped: int


FULL = Plan(
    size=(200, 400),
    truth=512,
    counts=(8, 12, 16, 20, 30, 40, 60, 80, 100, 150, 200),
    thresholds=(0.6, 0.4, 0.3, 0.2, 0.15, 0.12, 0.1, 0.08, 0.06, 0.04, 0.02, 0.0),
    coefficients=(0.02, 0.05, 0.1, 1.0),
    crops=(20, 30),
    map_samples=30,
    warped=16,
)
SMALL = FULL._replace(
    size=(25, 50),
    truth=64,
    counts=(8, 30),
    thresholds=(0.3, 0.1),
    coefficients=(0.02, 0.05),
    crops=(20,),
)

"""Figure 3: three pixels, from almost unoccluded to occluded, with the samples that were taken."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.embree.accel import start_shadow_ray
from .figure2 import Warp
from .runs import Picture, Run

WANTED = (0.97, 0.6, 0.15)  # K / N of the pixels to show


class ShownPixel(NamedTuple):
    """pixel: (column, row), row 0 below; warped: float64 (N, 2); seen: bool (N,)
    density: of the product, as Figure2.density; true_visibility: of the reference
    """

    pixel: tuple[int, int]
    warped: np.ndarray
    seen: np.ndarray
    density: np.ndarray
    true_visibility: float


def figure3(run: Run, picture: Picture, visibility: np.ndarray) -> list[ShownPixel]:
    """picture: of the paper's rule; visibility: float64 (h, w), of a reference of mode PAPER."""
    points = run.seen().points
    width = run.scene.camera.width
    row, column = np.divmod(points.pixel, width)
    taken = picture.samples[row, column]
    true = np.where(taken > 0, visibility[row, column], np.inf)
    return [_shown(run, int(np.argmin(np.abs(true - v))), picture, visibility) for v in WANTED]


def _shown(run, k, picture, visibility) -> ShownPixel:
    seen = run.seen().at(slice(k, k + 1))
    row, column = divmod(int(seen.points.pixel[0]), run.scene.camera.width)
    points = run.pixel_points(seen, int(picture.samples[row, column]))
    warp, accel = Warp(run, seen), run.job().accel
    directions = warp.directions(points).astype(np.float32)
    origins = np.zeros_like(directions)
    offset = np.float32(accel.offset)
    above = [
        start_shadow_ray(seen.points, 0, *direction, False, offset, origins, i)
        for i, direction in enumerate(directions)
    ]
    free = ~np.asarray(accel.occluded(origins, directions), bool)
    value = float(visibility[row, column])
    return ShownPixel((column, row), warp.warped(points), above & free, warp.density(), value)

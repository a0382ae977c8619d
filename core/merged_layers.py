"""The closures of shading points together again: what a pixel shows."""

from __future__ import annotations

import numpy as np

from .incremental import PixelSums, new_sums
from .tile_job import ClosureLayer, SeenPoints

_LIGHT = ("diffuse", "glossy", "unoccluded")
_COLORS = ("diffuse", "glossy_color")


def merge_layers(layers: list[ClosureLayer], sums: list[PixelSums]) -> tuple[SeenPoints, PixelSums]:
    """All points, with the light and the colours of all their closures.

    Sums are as if all samples of a point had been of one kind; the error is that of the sum, for
    errors that have nothing to do with each other.
    """
    first = layers[0].seen
    first = first._replace(points=first.points.facing_viewer())
    if len(layers) == 1:
        return first, sums[0]
    n = len(first.rows)
    whole, mean, variance, wrong = new_sums(n), np.zeros(n), np.zeros(n), np.zeros(n)
    colors = {name: np.zeros((n, 3), np.float32) for name in _COLORS}
    for (seen, of), own in zip(layers, sums, strict=True):
        count = np.maximum(own.count, 1)
        for name in _LIGHT:
            getattr(whole, name)[of] += getattr(own, name) / count[:, None]
        for name in _COLORS:
            colors[name][of] += getattr(seen.lobes, name)
        whole.count[of] += own.count
        whole.visible[of] += own.visible
        light = own.seen / count
        spread = np.maximum(own.seen_squared - own.seen * light, 0.0)
        mean[of] += light
        variance[of] += spread / (count * np.maximum(count - 1, 1))
        wrong[of] += (np.where(np.isfinite(own.error), own.error, 0.0) * light) ** 2
    count = np.maximum(whole.count, 1)
    for name in _LIGHT:
        getattr(whole, name)[:] *= count[:, None]
    whole.seen[:] = mean * count
    whole.seen_squared[:] = (variance * (count - 1) + mean**2) * count
    whole.error[:] = np.divide(np.sqrt(wrong), mean, out=np.zeros(n), where=mean > 0.0)
    return first._replace(lobes=first.lobes._replace(**colors)), whole

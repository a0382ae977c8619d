"""The closures of shading points together again: what a pixel shows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.sheen import diffuse_color
from ..data.rows import row_means
from ..sampling.incremental import PixelSums, new_sums
from ..sampling.neighbours import hue_spread, reflected_chroma
from ..scene import Scene
from .seen_points import ClosureLayer, SeenPoints


class _Merged(NamedTuple):
    """Of n points; mean, variance, wrong, hue: float64 (n,), of the light, its square's error, what
    the errors are of it, squared, and of color; diffuse, glossy_color: float32 (n, 3)."""

    sums: PixelSums
    mean: np.ndarray
    variance: np.ndarray
    wrong: np.ndarray
    hue: np.ndarray
    diffuse: np.ndarray
    glossy_color: np.ndarray


@kernel
def _add_layer(of, lobes, own, merged):
    """Add the means of a closure's sums. of: int64 (m,), rows of its points"""
    whole = merged.sums
    for k in range(len(of)):
        p, count = of[k], max(own.count[k], 1)
        inverse = 1.0 / count
        for a in range(3):
            whole.diffuse[p, a] += own.diffuse[k, a] * inverse
            whole.glossy[p, a] += own.glossy[k, a] * inverse
            whole.unoccluded[p, a] += own.unoccluded[k, a] * inverse
            merged.diffuse[p, a] += diffuse_color(lobes, k, a)
            merged.glossy_color[p, a] += lobes.glossy_color[k, a]
        whole.count[p] += own.count[k]
        whole.visible[p] += own.visible[k]
        light = own.seen[k] * inverse
        spread = max(own.seen_squared[k] - own.seen[k] * light, 0.0)
        merged.mean[p] += light
        merged.variance[p] += spread * inverse / max(count - 1, 1)
        merged.hue[p] += hue_spread(own, k, count) * inverse / max(count - 1, 1)
        error = own.error[k] * light if np.isfinite(own.error[k]) else 0.0
        merged.wrong[p] += error * error


@kernel
def _close(merged):
    """Make sums of all samples of the means."""
    whole = merged.sums
    for p in range(len(whole.count)):
        count, mean = max(whole.count[p], 1), merged.mean[p]
        for a in range(3):
            whole.diffuse[p, a] *= count
            whole.glossy[p, a] *= count
            whole.unoccluded[p, a] *= count
        whole.seen[p] = mean * count
        whole.seen_squared[p] = (merged.variance[p] * (count - 1) + mean * mean) * count
        whole.hue[p] = merged.hue[p] * (count - 1) * count + reflected_chroma(whole, p) / count
        whole.error[p] = np.sqrt(merged.wrong[p]) / mean if mean > 0.0 else 0.0


def turns_normals(scene: Scene) -> bool:
    """Whether a material of a scene has bumps or normal maps."""
    programs = () if scene.shaders is None else scene.shaders.programs
    own = (p.closures for p in programs if p is not None)
    return any(closure.normal is not None for closures in own for closure in closures)


def shown_normals(layers: list[ClosureLayer]) -> np.ndarray:
    """float32 (n, 3), what the pass Normal shows of all points: as in Cycles the mean of the
    normals of their closures, by their weights; of what has none the surface's own."""
    own = layers[0].seen.points.facing_viewer().normal
    total = np.zeros_like(own)
    for layer in layers:
        if layer.media is not None or layer.color is not None:
            continue  # light from under the surface, which leaves it elsewhere
        lobes, base = layer.seen.lobes, own[layer.of]
        matte, gloss = row_means(lobes.diffuse), row_means(lobes.weight.sum(axis=1))
        normal = matte[:, None] * lobes.normal + gloss[:, None] * lobes.glossy_normal
        # That of a translucent closure is on the side that the light comes from.
        behind = np.einsum("ij,ij->i", normal, base) < 0.0
        total[layer.of] += np.where(behind[:, None], -normal, normal)
    length = np.linalg.norm(total, axis=1)[:, None]
    return np.where(length > 0.0, total / np.maximum(length, np.float32(1e-20)), own)


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
    numbers = (np.zeros(n) for _ in range(4))
    colors = (np.zeros((n, 3), np.float32) for _ in range(2))
    merged = _Merged(new_sums(n), *numbers, *colors)
    for layer, own in zip(layers, sums, strict=True):
        lobes = layer.seen.lobes
        if layer.color is not None:
            lobes = lobes._replace(diffuse=layer.color)
        _add_layer(layer.of, lobes, own, merged)
    _close(merged)
    found = {"diffuse": merged.diffuse, "glossy_color": merged.glossy_color}
    found["rough"] = np.zeros((n, 4), np.float32)  # of no closure alone
    return first._replace(lobes=first.lobes._replace(**found)), merged.sums

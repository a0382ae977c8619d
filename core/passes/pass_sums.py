"""What is known of the pixels of a tile after some passes, and the error of it.

A pass adds one shading point to a pixel. The error is that of the pixel's luminance and color: the
spread of its passes, which knows of edges, pooled with what the samples inside the passes say of
it, so that four passes that agree by chance are not taken for certain. Points and samples are
low-discrepancy sequences: their mean converges faster than independent numbers
(docs/decisions/0009-pixel-filter.md has the measured exponent).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import Lobes
from ..bsdf.luminance import luminance
from ..bsdf.sheen import diffuse_color
from ..sampling.incremental import PixelSums
from ..sampling.neighbours import hue_spread, reflected_chroma

# The squared error of a mean of P passes falls as P^-1.3.
_CONVERGENCE = 1.3
# What is known from the samples inside the passes counts as that many passes.
_PRIOR_PASSES = 2.0
# Variance of a pixel's passes over its squared mean: of light that two of five have it is 1.5.
_SELDOM = 1.5


class PassSums(NamedTuple):
    """Sums over the passes of each pixel; 148 bytes a pixel.

    passes, hits: int32 (n,), rays taken, and those that saw an object
    opaque: float32 (n,), of the other rays, those that the film does not let through: of a film
        with a world all that see it; else those outside a panorama's image circle, as in Cycles,
        and what panes have taken
    count, visible: int32 (n,), shadow rays, and those that reached the light
    diffuse, glossy, unoccluded, emission, environment: float32 (n, 3), light
    diffuse_color, glossy_color, normal: float32 (n, 3)
    error: float32 (n,), estimated relative error of the pixel's light
    light, light_squared: float64 (n,), of the luminance of the passes
    hue: float64 (n,), of luminance.chroma of what objects reflect in the passes
    noise: float32 (n,), of the squared standard error of a pass's mean, by its own samples
    """

    passes: np.ndarray
    hits: np.ndarray
    opaque: np.ndarray
    count: np.ndarray
    visible: np.ndarray
    diffuse: np.ndarray
    glossy: np.ndarray
    unoccluded: np.ndarray
    emission: np.ndarray
    environment: np.ndarray
    diffuse_color: np.ndarray
    glossy_color: np.ndarray
    normal: np.ndarray
    error: np.ndarray
    light: np.ndarray
    light_squared: np.ndarray
    hue: np.ndarray
    noise: np.ndarray


def new_pass_sums(n: int) -> PassSums:
    """Zero sums for n pixels."""
    return PassSums(
        *(np.zeros(n, np.int32) for _ in range(2)),
        np.zeros(n, np.float32),
        *(np.zeros(n, np.int32) for _ in range(2)),
        *(np.zeros((n, 3), np.float32) for _ in range(8)),
        np.full(n, np.inf, np.float32),
        *(np.zeros(n) for _ in range(3)),
        np.zeros(n, np.float32),
    )


@kernel(forceinline=True)
def _add_light(state, p, light):
    state.light[p] += light
    state.light_squared[p] += light * light


@kernel
def _add_seen(pixel, normal, lobes, sums, state):
    for k in range(len(pixel)):
        p, count = pixel[k], sums.count[k]
        inverse = 1.0 / max(count, 1)
        state.hits[p] += 1
        state.count[p] += count
        state.visible[p] += sums.visible[k]
        for a in range(3):
            state.diffuse[p, a] += sums.diffuse[k, a] * inverse
            state.glossy[p, a] += sums.glossy[k, a] * inverse
            state.unoccluded[p, a] += sums.unoccluded[k, a] * inverse
            state.emission[p, a] += lobes.emission[k, a]
            state.diffuse_color[p, a] += diffuse_color(lobes, k, a)
            state.glossy_color[p, a] += lobes.glossy_color[k, a]
            state.normal[p, a] += normal[k, a]
        own = luminance(lobes.emission[k, 0], lobes.emission[k, 1], lobes.emission[k, 2])
        seen = sums.seen[k]
        _add_light(state, p, seen * inverse + np.float64(own))
        spread = max(sums.seen_squared[k] - seen * seen * inverse, 0.0)
        spread += hue_spread(sums, k, max(count, 1))
        state.hue[p] += reflected_chroma(sums, k) * inverse * inverse
        state.noise[p] += spread * inverse / max(count - 1, 1)


def add_seen(pixel, normal, lobes: Lobes, sums: PixelSums, state: PassSums) -> None:
    """Add a pass of the pixels that saw an object.

    pixel: int32 (n,), rows of state; normal: float32 (n, 3), sums: of the pass's shading points
    """
    _add_seen(pixel, normal, lobes, sums, state)


@kernel
def add_background(pixel, radiance, in_picture, state):
    """Add a pass of the pixels that saw the world.

    pixel: int32 (n,), rows of state; radiance: float32 (n, 3)
    in_picture: whether Combined shows the world
    """
    for k in range(len(pixel)):
        p = pixel[k]
        for a in range(3):
            state.environment[p, a] += radiance[k, a]
        if in_picture:
            light = luminance(radiance[k, 0], radiance[k, 1], radiance[k, 2])
            _add_light(state, p, np.float64(light))


@kernel
def add_glow(pixel, radiance, state):
    """Add the light of lamps that the rays of pixels, int32 (n,), see; radiance: float32 (n, 3)."""
    for k in range(len(pixel)):
        p = pixel[k]
        light = luminance(radiance[k, 0], radiance[k, 1], radiance[k, 2])
        if light > 0.0:
            _add_light(state, p, np.float64(light))
            for a in range(3):
                state.emission[p, a] += radiance[k, a]


@kernel(forceinline=True)
def _pass_variance(state, p):
    """Variance of the light of a pass, by the spread of those there are and their own noise."""
    passes, light = np.float64(state.passes[p]), state.light[p]
    spread = max(state.light_squared[p] - light * light / passes, 0.0)
    spread += hue_spread(state, p, max(state.hits[p], 1))
    prior = _PRIOR_PASSES * np.float64(state.noise[p]) / passes
    return (spread + prior) / (passes - 1.0 + _PRIOR_PASSES)


@kernel(forceinline=True)
def mean_variance(state, p):
    """Squared standard error of the mean light of pixel p's passes."""
    return _pass_variance(state, p) / np.float64(state.passes[p]) ** _CONVERGENCE


@kernel(forceinline=True)
def _light_error(state, p):
    passes, light = np.float64(state.passes[p]), state.light[p]
    if light <= 0.0:
        return np.inf if state.count[p] > 0 else 0.0
    return np.sqrt(mean_variance(state, p)) * passes / light


@kernel
def fill_spreads(pixel, samples, floor, with_alpha, state, spread):
    """Write r: the relative standard deviation of a pixel's samples, edges and all.

    As stop_rule.py means it, for passes of ``samples`` samples: sqrt(samples) times that of a pass.
    Half a sample more counts as seen. pixel: int32 (n,); floor: of the dark, a visibility; spread:
    float32 (n,)
    """
    for i in range(len(pixel)):
        p = pixel[i]
        passes, light = np.float64(state.passes[p]), state.light[p]
        whole = luminance(state.unoccluded[p, 0], state.unoccluded[p, 1], state.unoccluded[p, 2])
        unseen = 0.5 * np.float64(whole) / (state.count[p] + 1.0)
        mean = light + unseen + floor * np.float64(whole)
        squared = _pass_variance(state, p) * samples + unseen * whole / (passes * passes)
        spread[i] = np.sqrt(squared) * passes / mean if mean > 0.0 else 0.0
        if with_alpha:
            share = state.hits[p] / passes
            spread[i] = max(np.float64(spread[i]), np.sqrt(share * (1.0 - share) * samples))


def cell_spreads(cell: np.ndarray, n_cells: int, passes, light, spread) -> np.ndarray:
    """r of the cells, float32 (n_cells,): what their pixels say together; 0 for one without any.

    Four passes that miss a bright spot out of focus would end a pixel, and four that hit it would
    not: dark holes. So a blurred pixel asks all of its cell, and its own luck hardly counts. The
    larger of: the pixels' mean variance over the square of their mean light; their mean r^2.
    cell: int (n,); passes, light, spread: of n pixels, as PassSums and fill_spreads have them
    """
    mean = light / np.maximum(passes, 1)
    squared = np.float64(spread) ** 2
    count = np.maximum(np.bincount(cell, minlength=n_cells), 1)
    variance = np.bincount(cell, squared * mean**2, n_cells) / count
    whole = np.bincount(cell, mean, n_cells) / count
    pooled = np.divide(variance, whole**2, out=np.zeros(n_cells), where=whole > 0.0)
    return np.sqrt(np.maximum(pooled, np.bincount(cell, squared, n_cells) / count)).astype(
        np.float32
    )


def seldom_spreads(cell: np.ndarray, n_cells: int, samples: int, passes, light, spread):
    """r of the cells whose light comes seldom, float32 (n_cells,); 0 of others.

    Glints, flecks of sun between leaves, bulbs, stars, holes before a bright sky are smaller than
    pixels: few passes see one. A pixel that no pass has shown its glint looks done, and one that
    has seen it does not: beads of metal came out an eighth too dark, stars two fifths. So where two
    of five passes of a cell's pixels have its light, or fewer, all ask for what it says together.
    samples: of a pass; the others: of n pixels, as of cell_spreads
    """
    light = light / np.maximum(passes, 1)
    squared = light**2
    spread_of_light = np.bincount(cell, np.float64(spread) ** 2 * squared, n_cells)
    seldom = spread_of_light > _SELDOM * samples * np.bincount(cell, squared, n_cells)
    count = np.maximum(np.bincount(cell, minlength=n_cells), 1)
    whole = np.bincount(cell, light, n_cells) / count
    pooled = np.zeros(n_cells)
    np.divide(spread_of_light / count, whole**2, out=pooled, where=seldom & (whole > 0.0))
    return np.sqrt(pooled).astype(np.float32)


@kernel
def close_passes(pixel, counts, with_alpha, state):
    """Count so many more passes of each pixel, int32 (n,), and update their errors.

    with_alpha: whether the share of the world is seen as alpha; its error then counts too
    """
    for k in range(len(pixel)):
        p = pixel[k]
        state.passes[p] += counts[k]
        error = _light_error(state, p)
        if with_alpha:
            passes = np.float64(state.passes[p])
            share = state.hits[p] / passes
            alpha = np.sqrt(share * (1.0 - share) / passes**_CONVERGENCE)
            error = max(error, alpha)
        state.error[p] = error

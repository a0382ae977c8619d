"""Glossy lobes that are wider along one tangent than across it: brushed metal, records, hair.

Facets have slopes of width alpha_x along the tangent and alpha_y across it [Heitz14, section 5.3].
Lobes.alpha is the greater one, and the tangent its axis. The value is that of a round lobe of that
width, which covers the stretched one, times a factor; the cells of the product know both widths
(lobe_cells.py).
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..scene import BECKMANN
from .microfacet import (
    FOUR,
    INV_PI,
    MIN_ALPHA,
    ONE,
    ZERO,
    beckmann_d,
    beckmann_lambda,
    cross,
    dot_xyz,
    ggx_d,
    ggx_lambda,
    half_vector,
)

_TINY = np.float32(1e-12)


@kernel(forceinline=True)
def _facet(at, wi_x, wi_y, wi_z):
    """h along the tangent, across it and along the normal, and wo . h."""
    hx, hy, hz, cos_h = half_vector(at.wo, wi_x, wi_y, wi_z)
    side = cross(at.glossy_normal, at.tangent)
    x, y = dot_xyz(at.tangent, hx, hy, hz), dot_xyz(side, hx, hy, hz)
    return x, y, dot_xyz(at.glossy_normal, hx, hy, hz), cos_h


@kernel(forceinline=True)
def _density(at, x, y, z):
    """D of a facet's normal, sr^-1."""
    a, b = x / at.alpha, y / at.narrow
    slopes, area = a * a + b * b, at.alpha * at.narrow
    z2 = z * z
    if at.gaussian:
        if z2 <= _TINY:
            return ZERO
        return math.exp(-slopes / z2) * INV_PI / (area * z2 * z2)
    t = slopes + z2
    return INV_PI / (area * t * t)


@kernel(forceinline=True)
def _width2(normal, tangent, wide, narrow, x, y, z):
    """Square of the width of the slopes towards a direction."""
    side = cross(normal, tangent)
    along, across = dot_xyz(tangent, x, y, z), dot_xyz(side, x, y, z)
    along, across = along * along, across * across
    whole = along + across
    if whole < _TINY:
        return wide * narrow
    return (wide * wide * along + narrow * narrow * across) / whole


@kernel(forceinline=True)
def stretched(at, wi_x, wi_y, wi_z, value):
    """eval_lobes_at's value, of a round lobe of width at.alpha, with its gloss stretched."""
    dr, dg, db, gr, gg, gb = value
    cos_i = dot_xyz(at.glossy_normal, wi_x, wi_y, wi_z)
    if gr + gg + gb <= ZERO or cos_i <= ZERO:
        return value
    x, y, z, _ = _facet(at, wi_x, wi_y, wi_z)
    wide2, sin2 = at.alpha * at.alpha, min(x * x + y * y, ONE)
    width2 = _width2(at.glossy_normal, at.tangent, at.alpha, at.narrow, wi_x, wi_y, wi_z)
    if at.gaussian:
        round_d = beckmann_d(wide2, sin2)
        hidden, round_hidden = beckmann_lambda(width2, cos_i), beckmann_lambda(wide2, cos_i)
    else:
        round_d = ggx_d(wide2, sin2)
        hidden, round_hidden = ggx_lambda(width2, cos_i), ggx_lambda(wide2, cos_i)
    if round_d <= ZERO:
        return dr, dg, db, ZERO, ZERO, ZERO
    gain = _density(at, x, y, z) * (at.seen + round_hidden) / (round_d * (at.seen + hidden))
    return dr, dg, db, gr * gain, gg * gain, gb * gain


@kernel(forceinline=True)
def pdf_stretched(at, wi_x, wi_y, wi_z):
    """The density of wo mirrored by a facet of sample_ggx_visible_normal (GGX), or of any."""
    x, y, z, cos_h = _facet(at, wi_x, wi_y, wi_z)
    if at.gaussian:
        return _density(at, x, y, z) * abs(z) / (FOUR * cos_h)
    if z > ZERO:
        return _density(at, x, y, z) / (FOUR * at.cos_o * at.seen)
    return ZERO


def mean_roughness(roughness: np.ndarray, grain: np.ndarray) -> np.ndarray:
    """float32 (n,): of the round facets that hide as much of each other, by both widths' mean.

    As in Cycles, what a surface reflects in all is read off for these. A width ends at 1: the
    rougher a surface is, the less is it stretched. grain: of stretch_lobes
    """
    alpha = np.clip(roughness, ZERO, ONE) ** 2
    ratio = np.sqrt(grain[:, 0] ** 2 + grain[:, 1] ** 2 + grain[:, 2] ** 2)
    ratio = np.where(ratio > ZERO, ratio, ONE)
    wide, narrow = (np.clip(x, MIN_ALPHA, ONE) for x in (alpha * ratio, alpha / ratio))
    return np.float32(np.where(ratio == ONE, roughness, (wide * narrow) ** 0.25))


@kernel
def stretch_lobes(lobes, roughness, grain):
    """Stretch the gloss of points.

    lobes: Lobes of round gloss of mean_roughness, written to; roughness: float32 (n,), their own
    grain: float32 (n, 3), along the tangent, as long as the root of alpha_x / alpha_y; 0 = round
    """
    for p in range(len(grain)):
        g, n = grain[p], lobes.glossy_normal[p]
        ratio = math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
        normal = (n[0], n[1], n[2])
        side = cross(normal, (g[0], g[1], g[2]))
        length = math.sqrt(dot_xyz(side, side[0], side[1], side[2]))
        if ratio <= ZERO or length <= np.float32(1e-6) * ratio or lobes.cos_o[p] <= ZERO:
            continue
        side = (side[0] / length, side[1] / length, side[2] / length)
        alpha = min(max(roughness[p], ZERO), ONE)
        alpha *= alpha
        wide = min(max(alpha * ratio, MIN_ALPHA), ONE)
        narrow = min(max(alpha / ratio, MIN_ALPHA), ONE)
        if wide == narrow:
            continue
        tangent = cross(side, normal)
        if wide < narrow:
            wide, narrow, tangent = narrow, wide, side
        lobes.alpha[p], lobes.narrow[p] = wide, narrow
        for c in range(3):
            lobes.tangent[p, c] = tangent[c]
        wo = lobes.wo[p]
        width2 = _width2(normal, tangent, wide, narrow, wo[0], wo[1], wo[2])
        lobes.seen[p] = ONE
        if lobes.distribution[p] == BECKMANN:
            lobes.seen[p] += beckmann_lambda(width2, lobes.cos_o[p])
        else:
            lobes.seen[p] += ggx_lambda(width2, lobes.cos_o[p])

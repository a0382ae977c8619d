"""A measured BRDF made ready to render: its table, and the lobes that samples follow.

Samples of mode UNBIASED go where light times *some* BRDF is, weighted by the true one. For a
measured BRDF that is a Lambert lobe and a GGX lobe, fitted anew for each of FIT_ANGLES outgoing
cosines: of both their sum m, the one is taken whose samples have the least variance under even
light, 1 + CoV^2 = int m int f^2 / m / (int f)^2, f the table's luminance times cosine. So the
products of product_build.py know a few numbers a point and never read a table.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from .._jit import kernel
from ..scene import (
    FIT_ALBEDO,
    FIT_ALPHA,
    FIT_ANGLES,
    FIT_COLUMNS,
    FIT_DIFFUSE,
    FIT_WEIGHT,
    MOST_MEASURED,
    NO_MEASURED,
    MeasuredBrdfs,
)
from ..unit_square.sphere_map import fill_hemisphere_grid
from ..wavelets.table_cache import load_arrays, save_arrays, table_key
from .luminance import luminance
from .merl import eval_merl, read_merl
from .microfacet import ggx_d, ggx_lambda

_GRID = 128  # squared: the directions that integrals are taken over
_ALPHAS = np.geomspace(0.01, 1.0, 25).astype(np.float32)
_SHARES = np.linspace(0.02, 0.98, 25).astype(np.float32)  # of the Lambert lobe
_LOWEST_COSINE = 0.01  # stands for 0, where nothing is defined


def read_measured(path, folder: Path) -> MeasuredBrdfs:
    """One BRDF of a MERL file; its fit is kept in ``folder`` by the file's hash.

    Raises OSError and ValueError with the path and what is wrong.
    """
    values, digest = read_merl(path)
    key = table_key("fit", digest)
    stored = load_arrays(folder, key, ["fit"])
    if stored is None:
        stored = [fit_lobes(values)]
        save_arrays(folder, key, {"fit": stored[0]})  # fitted again in a second if that failed
    return MeasuredBrdfs(values[None], stored[0][None], (digest,))


def join_measured(brdfs: list[MeasuredBrdfs]) -> MeasuredBrdfs:
    """All rows, in order."""
    if len(brdfs) > MOST_MEASURED:
        raise ValueError(f"{len(brdfs)} measured BRDFs in one scene: {MOST_MEASURED} at the most")
    if len(brdfs) < 2:
        return brdfs[0] if brdfs else NO_MEASURED
    values, fits, keys = zip(*brdfs, strict=True)
    return MeasuredBrdfs(np.concatenate(values), np.concatenate(fits), sum(keys, ()))


def fit_lobes(values: np.ndarray) -> np.ndarray:
    """float32 (FIT_ANGLES, FIT_COLUMNS): albedo and fitted lobes of a table, in .5 s."""
    directions = np.empty((_GRID * _GRID, 3), np.float32)
    fill_hemisphere_grid(_GRID, directions)
    fit = np.zeros((FIT_ANGLES, FIT_COLUMNS), np.float32)
    value, lobe = (np.empty(len(directions), np.float32) for _ in range(2))
    for k, cosine in enumerate(np.linspace(0.0, 1.0, FIT_ANGLES)):
        cos_o = np.float32(max(cosine, _LOWEST_COSINE))
        floor = np.empty((3, len(directions)), np.float32)
        _integrate(values[None], cos_o, directions, value, floor, fit[k])
        _fit(value, cos_o, directions, lobe, fit[k])
        _color(floor, fit[k])
    return fit


@kernel
def _integrate(tables, cos_o, directions, value, floor, fit):
    """Write luminance x cosine of each direction, the BRDF itself and the albedo."""
    zero = np.float32(0.0)
    up = (zero, zero, np.float32(1.0))
    wo = (np.sqrt(np.float32(1.0) - cos_o * cos_o), zero, cos_o)
    cell = np.float32(2.0 * math.pi / len(directions))
    for n in range(len(directions)):
        x, y, z = directions[n, 0], directions[n, 1], directions[n, 2]
        rgb = eval_merl(tables, 0, up, wo, (x, y, z))
        value[n] = luminance(rgb[0], rgb[1], rgb[2]) * z
        for c in range(3):
            floor[c, n] = rgb[c]
            fit[FIT_ALBEDO + c] += rgb[c] * z * cell


@kernel
def _fill_lobe(alpha, cos_o, directions, lobe):
    """The GGX lobe x cosine of each direction, its Fresnel factor 1; returns the sum."""
    one = np.float32(1.0)
    x, alpha2, total = np.sqrt(one - cos_o * cos_o), alpha * alpha, np.float32(0.0)
    seen = one + ggx_lambda(alpha2, cos_o)
    for n in range(len(directions)):
        hx, hy = directions[n, 0] + x, directions[n, 1]
        hz = directions[n, 2] + cos_o
        sin2 = (hx * hx + hy * hy) / (hx * hx + hy * hy + hz * hz)
        hidden = ggx_lambda(alpha2, max(directions[n, 2], np.float32(1e-4)))
        lobe[n] = ggx_d(alpha2, sin2) / (np.float32(4.0) * cos_o * (seen + hidden))
        total += lobe[n]
    return total


@kernel
def _fit(value, cos_o, directions, lobe, fit):
    """Write width, weight and Lambert part (its luminance, in the first column) of the best fit."""
    n_all, zero = len(value), np.float32(0.0)
    all_value, all_cosine = zero, zero
    for n in range(n_all):
        all_value += value[n]
        all_cosine += directions[n, 2]
    best = np.float32(np.inf)
    for alpha in _ALPHAS:
        all_lobe = _fill_lobe(alpha, cos_o, directions, lobe)
        for share in _SHARES:
            a, b = share / all_cosine, (np.float32(1.0) - share) / all_lobe
            spread = zero
            for n in range(n_all):
                spread += value[n] * value[n] / (a * directions[n, 2] + b * lobe[n])
            if spread < best:
                best = spread
                fit[FIT_ALPHA], fit[FIT_DIFFUSE] = alpha, np.float32(math.pi) * a * all_value
                fit[FIT_WEIGHT] = b * all_value


def _color(floor: np.ndarray, fit: np.ndarray) -> None:
    """Give the Lambert part the colour that the BRDF has in most directions."""
    middle = np.median(floor, axis=1)
    light = luminance(*middle)
    color = middle / light if light > 0.0 else np.ones(3, np.float32)
    albedo = fit[FIT_ALBEDO : FIT_ALBEDO + 3]
    fit[FIT_DIFFUSE : FIT_DIFFUSE + 3] = np.minimum(color * fit[FIT_DIFFUSE], albedo)

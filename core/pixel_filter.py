"""Which point of the picture a shading point of a pixel stands for.

Filter importance sampling: points are drawn in proportion to the filter, so that all have the same
weight and none counts for another pixel (docs/decisions/0009-pixel-filter.md). The filters are
Cycles': BOX is one pixel wide whatever the width; BLACKMAN_HARRIS reaches ``width`` pixels to
either side.

A pixel's points are the first two dimensions of Sobol's sequence, scrambled and shuffled by
hashes [Burley20]: the shuffle keeps them apart from the points that light is sampled with.
"""

from __future__ import annotations

import functools

import numpy as np

from ._jit import kernel
from .halton import hash_pixel
from .sequence import scramble

_BITS = 4294967296.0
# Hashes 1 and 2 scramble the points of light.
_ORDER_SALT, _X_SALT, _Y_SALT = 3, 4, 5
# What unit_points are for: each has its own shuffle and scrambles.
FILTER, LENS, TIME = 0, 1000, 2000
_CDF_NODES, _GUIDES = 4097, 1024


@kernel(forceinline=True)
def _second_dimension(index):
    """Sobol's second dimension, bits in reverse order, as sequence.sobol_points has it."""
    u = np.uint32
    bits, column = u(0), u(1)
    while index > u(0):
        if index & u(1):
            bits = u(bits ^ column)
        column = u(column ^ u(column << u(1)))
        index = u(index >> u(1))
    return bits


@kernel
def _fill_points(columns, rows, reversed_number, seed, salt, out):
    u = np.uint32
    for k in range(len(columns)):
        x, y = columns[k], rows[k]
        index = scramble(reversed_number, u(hash_pixel(x, y, seed, salt + _ORDER_SALT) * _BITS))
        first = scramble(index, u(hash_pixel(x, y, seed, salt + _X_SALT) * _BITS))
        second = scramble(
            _second_dimension(index), u(hash_pixel(x, y, seed, salt + _Y_SALT) * _BITS)
        )
        out[k, 0] = np.float64(first) / _BITS
        out[k, 1] = np.float64(second) / _BITS


def unit_points(columns, rows, number: int, seed: int, salt: int = FILTER) -> np.ndarray:
    """float64 (n, 2) in [0, 1): point ``number`` of each pixel. columns, rows: int64 (n,)

    salt: FILTER, LENS or TIME
    """
    out = np.empty((len(columns), 2))
    reversed_number = np.uint32(int(f"{number:032b}"[::-1], 2))
    _fill_points(columns, rows, reversed_number, seed, salt, out)
    return out


@functools.cache
def _blackman_harris() -> tuple[np.ndarray, np.ndarray]:
    """The window's integral at _CDF_NODES places from -1 to 1, float64 from 0 to 1; and for each of
    _GUIDES equal parts of 0 ... 1 the last node below it, int64."""
    v = np.pi * (np.linspace(-1.0, 1.0, _CDF_NODES) + 1.0)
    sines = -0.48829 * np.sin(v) + 0.07064 * np.sin(2.0 * v) - 0.01168 / 3.0 * np.sin(3.0 * v)
    cdf = (0.35875 * v + sines) / (0.35875 * 2.0 * np.pi)
    cdf[0], cdf[-1] = 0.0, 1.0
    guides = np.searchsorted(cdf, np.arange(_GUIDES) / _GUIDES, side="right") - 1
    return cdf, guides


@kernel
def _fill_offsets(points, width, cdf, guides, out):
    step = 2.0 / (len(cdf) - 1)
    for k in range(len(points)):
        for a in range(2):
            u = points[k, a]
            node = guides[int(u * len(guides))]
            while cdf[node + 1] <= u:
                node += 1
            part = (u - cdf[node]) / (cdf[node + 1] - cdf[node])
            out[k, a] = width * ((node + part) * step - 1.0)


def filter_offsets(kind: str, width: float, points: np.ndarray) -> np.ndarray:
    """Where the filter puts points of the unit square: float64 (n, 2), pixels from the centre.

    kind: one of settings.PIXEL_FILTERS; width: settings.filter_width; points: [0, 1)
    """
    if kind == "CENTER":
        return np.zeros_like(points)
    if kind == "BOX":
        return points - 0.5
    out = np.empty_like(points)
    _fill_offsets(points, width, *_blackman_harris(), out)
    return out

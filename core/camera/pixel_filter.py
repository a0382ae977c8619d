"""Which point of the picture a shading point of a pixel stands for.

Filter importance sampling: points are drawn in proportion to the filter, so that all have the same
weight and none counts for another pixel (docs/decisions/0009-pixel-filter.md). The filters are
Cycles': BOX is one pixel wide whatever the width; BLACKMAN_HARRIS reaches ``width`` pixels to
either side; GAUSSIAN has a standard deviation of a quarter of it, and ends at six of these.

A pixel's points are the first two dimensions of Sobol's sequence, scrambled and shuffled by
hashes [Burley20]: the shuffle keeps them apart from the points that light is sampled with.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from .._jit import kernel
from ..unit_square.halton import hash_pixel
from ..unit_square.sequence import scramble

_BITS = 4294967296.0
# Hashes 1 and 2 scramble the points of light.
# What unit_points are for: each has three salts of its own; those from LAMPS on are the lamps'.
FILTER, LENS, TIME, LAYERS, LAMPS = 3, 6, 9, 12, 15
WALKS = 1 << 20  # so far above that no lamp's are there
_CDF_NODES, _GUIDES = 4097, 4096
# How far filters reach to either side, in widths; GAUSSIAN in standard deviations.
_REACH, _SIGMAS = {"BLACKMAN_HARRIS": 1.0, "GAUSSIAN": 1.5}, 6.0


@kernel(forceinline=True)
def _second_dimension(index):
    """Sobol's second dimension, bits in reverse order, as sequence.sobol_points has it.

    Bit j is the parity of those bits i of the index whose number has all digits of j's: a
    butterfly, a digit of the numbers after another.
    """
    u = np.uint32
    bits = u(index)
    bits = u(bits ^ u(u(bits >> u(1)) & u(0x55555555)))
    bits = u(bits ^ u(u(bits >> u(2)) & u(0x33333333)))
    bits = u(bits ^ u(u(bits >> u(4)) & u(0x0F0F0F0F)))
    bits = u(bits ^ u(u(bits >> u(8)) & u(0x00FF00FF)))
    return u(bits ^ u(bits >> u(16)))


@kernel(forceinline=True)
def _reversed(number):
    """The 32 bits of a number from the last to the first."""
    u = np.uint32
    bits = u(number)
    bits = u(u(bits << u(16)) | u(bits >> u(16)))
    bits = u(u((bits & u(0x00FF00FF)) << u(8)) | u((bits >> u(8)) & u(0x00FF00FF)))
    bits = u(u((bits & u(0x0F0F0F0F)) << u(4)) | u((bits >> u(4)) & u(0x0F0F0F0F)))
    bits = u(u((bits & u(0x33333333)) << u(2)) | u((bits >> u(2)) & u(0x33333333)))
    return u(u((bits & u(0x55555555)) << u(1)) | u((bits >> u(1)) & u(0x55555555)))


@kernel(forceinline=True)
def _hashes(x, y, seed, salt):
    """What shuffles a pixel's sequence and scrambles its two dimensions, uint32."""
    u = np.uint32
    shuffle = u(hash_pixel(x, y, seed, salt) * _BITS)
    first = u(hash_pixel(x, y, seed, salt + 1) * _BITS)
    return shuffle, first, u(hash_pixel(x, y, seed, salt + 2) * _BITS)


@kernel(forceinline=True)
def _point(number, hashes):
    index = scramble(_reversed(number), hashes[0])
    first, second = scramble(index, hashes[1]), scramble(_second_dimension(index), hashes[2])
    return np.float64(first) / _BITS, np.float64(second) / _BITS


@kernel(forceinline=True)
def point_of_pixel(place, salt):
    """(x, y), float64 in [0, 1): a point of a pixel's sequence number ``salt``, one of many.

    place: (column, row, number, seed); three salts from this one on are in use
    """
    x, y, number, seed = place
    return _point(number, _hashes(x, y, seed, salt))


@kernel
def _fill_points(columns, rows, number, seed, salt, out):
    """Points of a pixel that follow each other share its hashes."""
    hashes = _hashes(columns[0], rows[0], seed, salt)
    for k in range(len(columns)):
        if k > 0 and (columns[k] != columns[k - 1] or rows[k] != rows[k - 1]):
            hashes = _hashes(columns[k], rows[k], seed, salt)
        out[k, 0], out[k, 1] = _point(number[k], hashes)


def unit_points(columns, rows, number, seed: int, salt: int = FILTER) -> np.ndarray:
    """float64 (n, 2) in [0, 1): point ``number`` of each pixel. columns, rows: int64 (n,)

    number: int, or int (n,), each pixel's own

    salt: what they are for, FILTER or another of these
    """
    out = np.empty((len(columns), 2))
    number = np.ascontiguousarray(np.broadcast_to(number, len(columns)), np.int64)
    if len(out):
        _fill_points(columns, rows, number, seed, salt, out)
    return out


@functools.cache
def _integral(kind: str) -> tuple[float, np.ndarray, np.ndarray]:
    """How far a filter reaches, in its widths; its integral at _CDF_NODES places over that, float64
    from 0 to 1; and for each of _GUIDES equal parts of 0 ... 1 the last node below it, int16."""
    cdf = _blackman_harris() if kind == "BLACKMAN_HARRIS" else _gaussian()
    cdf[0], cdf[-1] = 0.0, 1.0
    guides = np.searchsorted(cdf, np.arange(_GUIDES) / _GUIDES, side="right") - 1
    return _REACH[kind], cdf, guides.astype(np.int16)


def _gaussian() -> np.ndarray:
    places = np.linspace(-_SIGMAS, _SIGMAS, _CDF_NODES) / math.sqrt(2.0)
    cdf = np.array([0.5 * math.erfc(-x) for x in places])
    return (cdf - cdf[0]) / (cdf[-1] - cdf[0])


def _blackman_harris() -> np.ndarray:
    v = np.pi * (np.linspace(-1.0, 1.0, _CDF_NODES) + 1.0)
    sines = -0.48829 * np.sin(v) + 0.07064 * np.sin(2.0 * v) - 0.01168 / 3.0 * np.sin(3.0 * v)
    return (0.35875 * v + sines) / (0.35875 * 2.0 * np.pi)


@kernel
def _fill_offsets(points, width, cdf, guides, out):
    step = 2.0 / (len(cdf) - 1)
    for k in range(len(points)):
        for a in range(2):
            u = points[k, a]
            node = np.int64(guides[int(u * len(guides))])
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
    reach, *integral = _integral(kind)
    _fill_offsets(points, reach * width, *integral, out)
    return out

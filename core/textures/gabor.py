"""Gabor noise in two and three dimensions, as Blender has it: a kernel of core/nodes/noise.py.

Sums of waves under a bell, at random points of the cells of a grid [Lagae09], as many in each cell
[Tavernier19]; as complex numbers, so that the wave's phase and amplitude can be told [Tricard19].
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .perlin import number_of_3, number_of_4

IMPULSES = 8  # of a cell
_ZERO, _HALF, _ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
_PI = np.float32(np.pi)
# The sum over six of its standard deviations is about -1 to 1: of so many impulses whose signs are
# random, times the integral of a squared wave under its bell.
_SPREAD_2 = np.float32(6.0 * math.sqrt(IMPULSES * 0.5 * 0.25))
_SPREAD_3 = np.float32(6.0 * math.sqrt(IMPULSES * 0.5 / (4.0 * math.sqrt(2.0))))


@kernel(forceinline=True)
def _way(x):
    """The square of the way from a place to a cell that begins at 0 and ends at 1."""
    outside = max(-x, x - _ONE, _ZERO)
    return outside * outside


@kernel(forceinline=True)
def _wave(distance2, turns, sign):
    """(cosine, sine) under the bell, which ends at a distance of 1."""
    bell = np.exp(-_PI * distance2) * (_HALF + _HALF * np.cos(_PI * distance2)) * sign
    angle = np.float32(2.0) * _PI * turns
    return bell * np.cos(angle), bell * np.sin(angle)


@kernel
def gabor_2d(x, y, frequency, isotropy, angle, scratch, out):
    """Write (cosine, sine) of n points' sums, float32 (2, n).

    x, y: float32 (n,), in cells; frequency: waves a cell; isotropy: 0 to 1, how far orientations
    are random; angle: radians, of what is not; scratch: float32 (4, IMPULSES)
    """
    for n in range(len(x)):
        real = imaginary = _ZERO
        for q in range(9):
            cx = np.float32(np.floor(x[n]) + np.float32(q % 3 - 1))
            cy = np.float32(np.floor(y[n]) + np.float32(q // 3 - 1))
            px, py = x[n] - cx, y[n] - cy
            if _way(px) + _way(py) >= _ONE:
                continue
            for k in range(IMPULSES):  # a loop without branches: eight hashes at once
                place = np.float32(3 * k + 1)
                dx, dy = px - number_of_3(cx, cy, place), py - number_of_3(place, cx, cy)
                scratch[0, k], scratch[1, k], scratch[3, k] = dx, dy, dx * dx + dy * dy
            for k in range(IMPULSES):
                if scratch[3, k] >= _ONE:
                    continue
                first = np.float32(3 * k)
                turned = (number_of_3(cx, cy, first) - _HALF) * _PI * isotropy[n] + angle[n]
                heads = number_of_3(cx, cy, np.float32(3 * k + 2)) < _HALF
                along = scratch[0, k] * np.cos(turned) + scratch[1, k] * np.sin(turned)
                c, s = _wave(scratch[3, k], frequency[n] * along, -_ONE if heads else _ONE)
                real += c
                imaginary += s
        out[0, n], out[1, n] = real / _SPREAD_2, imaginary / _SPREAD_2


@kernel(forceinline=True)
def _turned(polar, azimuth, isotropy, cx, cy, cz, first):
    """The direction of a wave in space."""
    polar = polar + number_of_4(cx, cy, cz, first) * _PI * isotropy
    azimuth = azimuth + number_of_4(cz, cx, first, cy) * _PI * isotropy
    across = np.sin(polar)
    return across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)


@kernel
def gabor_3d(p, frequency, isotropy, direction, scratch, out):
    """Write (cosine, sine) of n points' sums, float32 (2, n).

    p: float32 (3, n), in cells; direction: float32 (3, n), unit; the rest as for gabor_2d
    """
    for n in range(p.shape[1]):
        x, y, z = p[0, n], p[1, n], p[2, n]
        ux, uy, uz = direction[0, n], direction[1, n], direction[2, n]
        flat = np.sqrt(ux * ux + uy * uy)
        polar = np.arccos(min(max(uz, -_ONE), _ONE))
        azimuth = np.arccos(min(max(ux / flat, -_ONE), _ONE)) if flat > _ZERO else _ZERO
        azimuth = -azimuth if uy < _ZERO else azimuth
        real = imaginary = _ZERO
        for q in range(27):
            cx = np.float32(np.floor(x) + np.float32(q % 3 - 1))
            cy = np.float32(np.floor(y) + np.float32(q // 3 % 3 - 1))
            cz = np.float32(np.floor(z) + np.float32(q // 9 - 1))
            px, py, pz = x - cx, y - cy, z - cz
            if _way(px) + _way(py) + _way(pz) >= _ONE:
                continue
            for k in range(IMPULSES):
                place = np.float32(3 * k + 1)
                dx = px - number_of_4(cx, cy, cz, place)
                dy = py - number_of_4(cz, cx, place, cy)
                dz = pz - number_of_4(place, cz, cy, cx)
                scratch[0, k], scratch[1, k], scratch[2, k] = dx, dy, dz
                scratch[3, k] = dx * dx + dy * dy + dz * dz
            for k in range(IMPULSES):
                if scratch[3, k] >= _ONE:
                    continue
                tx, ty, tz = ux, uy, uz
                if isotropy[n] != _ZERO:
                    first = np.float32(3 * k)
                    tx, ty, tz = _turned(polar, azimuth, isotropy[n], cx, cy, cz, first)
                heads = number_of_4(cx, cy, cz, np.float32(3 * k + 2)) < _HALF
                along = scratch[0, k] * tx + scratch[1, k] * ty + scratch[2, k] * tz
                c, s = _wave(scratch[3, k], frequency[n] * along, -_ONE if heads else _ONE)
                real += c
                imaginary += s
        out[0, n], out[1, n] = real / _SPREAD_3, imaginary / _SPREAD_3

"""What the eye sees of light that interferes, by the difference of its ways: S of
thin_film_tables.py.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .microfacet import TWO, ZERO
from .thin_film_tables import GAUSSIANS, STEPS_PER_NM, TABLE_POINTS, sensitivities

_SEEN = sensitivities()
_STEPS, _LAST = np.float32(STEPS_PER_NM), np.float32(TABLE_POINTS - 1)
_THREE, _RADIANS_PER_NM = np.float32(3.0), np.float32(2e-9 * math.pi)


@kernel(forceinline=True)
def _bell(phase, height, place, width):
    """One of the Gaussians that [Belcour17] has in place of the observer's curves."""
    return (
        np.float32(height)
        * math.cos(np.float32(place) * phase)
        * math.exp(-np.float32(width) * phase * phase)
    )


@kernel(forceinline=True)
def _bells(way):
    """S by these Gaussians, red, green and blue of Linear Rec.709; its imaginary part is not asked:
    they are for dielectrics alone, whose q is real."""
    phase = _RADIANS_PER_NM * way
    x = _bell(phase, 0.8465900, 1.6810e6, 4.3278e9) + _bell(phase, 0.1538680, 2.2399e6, 4.5282e9)
    y = _bell(phase, 1.0002219, 1.7953e6, 9.3046e9)
    z = _bell(phase, 1.0011225, 2.2084e6, 6.6121e9)
    x, z = np.float32(0.95047) * x, np.float32(1.08883) * z
    return (
        np.float32(3.2404542) * x - np.float32(1.5371385) * y - np.float32(0.4985314) * z,
        np.float32(-0.9692660) * x + np.float32(1.8760108) * y + np.float32(0.0415560) * z,
        np.float32(0.0556434) * x - np.float32(0.2040259) * y + np.float32(1.0572252) * z,
        ZERO,
        ZERO,
        ZERO,
    )


@kernel
def _seen(space, way):
    """S of a difference of ways, nm: real parts of red, green and blue, then imaginary ones."""
    if space == GAUSSIANS:
        return _bells(way)
    place = min(way * _STEPS, _LAST)
    i = min(int(place), TABLE_POINTS - 2)
    t = place - np.float32(i)
    a, b = _SEEN[space, i], _SEEN[space, i + 1]
    return (
        a[0] + t * (b[0] - a[0]),
        a[1] + t * (b[1] - a[1]),
        a[2] + t * (b[2] - a[2]),
        a[3] + t * (b[3] - a[3]),
        a[4] + t * (b[4] - a[4]),
        a[5] + t * (b[5] - a[5]),
    )


@kernel(forceinline=True)
def seen_orders(space, way):
    """S of once, twice and three times a difference of ways, nm: of each the real parts of red,
    green and blue, then the imaginary ones. space: of thin_film_tables."""
    return _seen(space, way), _seen(space, TWO * way), _seen(space, _THREE * way)

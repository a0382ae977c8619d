"""Cubic interpolation of a world's image, as a finer image that is interpolated linearly.

Cycles' Cubic, and Smart, is the uniform cubic B-spline over texels. Sampled finely enough, straight
lines between its values are the same curve: what is left is an eighth of the step, squared, times
its bend. The wider an image, the less of it a picture sees: from 4096 texels on they keep their
number, and lose what the spline blurs.
"""

from __future__ import annotations

import numpy as np

from .color_spaces import srgb_decode, srgb_encode

_MOST, _WIDE = 8, 4096  # texels in place of one, along each side; of the new image at the most


def finer(width: int) -> int:
    """How many texels take the place of one of an image so wide, along each side."""
    factor = _MOST
    while factor > 1 and factor * width > _WIDE:
        factor //= 2
    return factor


def _weights(t: float):
    """Of the four texels about a place, t of the way from the second to the third."""
    u = 1.0 - t
    return u**3 / 6, (4 - 3 * t * t * (2 - t)) / 6, (4 - 3 * u * u * (2 - u)) / 6, t**3 / 6


def _along(texels: np.ndarray, factor: int, axis: int) -> np.ndarray:
    """The spline along one axis, on which the image repeats, at the middles of finer texels."""
    shape = list(texels.shape)
    shape.insert(axis + 1, factor)
    out = np.empty(shape, np.float32)
    for part in range(factor):
        place = (part + 0.5) / factor - 0.5  # from the middle of a texel
        first = -1 if place >= 0.0 else -2
        total = np.zeros_like(texels)
        for k, weight in enumerate(_weights(place % 1.0)):
            total += np.float32(weight) * np.roll(texels, -(first + k), axis)
        out[(slice(None),) * (axis + 1) + (part,)] = total
    shape = list(texels.shape)
    shape[axis] *= factor
    return out.reshape(shape)


def smooth_texels(radiance: np.ndarray, encoded: bool) -> np.ndarray:
    """float32 (h, w, 3) between whose texels straight lines follow the spline.

    radiance: float32 (h, w, 3), linear; encoded: whether interpolation is in the sRGB encoding
    """
    factor = finer(radiance.shape[1])
    texels = np.float32(srgb_encode(radiance)) if encoded else radiance
    for axis in (0, 1):
        texels = _along(texels, factor, axis)
    if encoded:
        texels = srgb_decode(np.maximum(texels, np.float32(0.0)))  # what rounding leaves below
    return np.ascontiguousarray(texels)

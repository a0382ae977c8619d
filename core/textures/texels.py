"""An image looked up at places: the kernel of core/nodes/images.py."""

from __future__ import annotations

import numpy as np

from .._jit import kernel

# By the names that nodes have for them.
INTERPOLATIONS = {"Closest": 0, "Linear": 1, "Cubic": 2, "Smart": 2}
EXTENSIONS = {"REPEAT": 0, "MIRROR": 1, "EXTEND": 2, "CLIP": 3}
_CLOSEST, _CUBIC = INTERPOLATIONS["Closest"], INTERPOLATIONS["Cubic"]
_REPEAT, _MIRROR, _CLIP = EXTENSIONS["REPEAT"], EXTENSIONS["MIRROR"], EXTENSIONS["CLIP"]
_BIG = 1e8  # beyond, a float has no place inside a texel
_ONE, _HALF, _TWO_THIRDS = np.float32(1.0), np.float32(0.5), np.float32(2.0 / 3.0)
_SIXTH = np.float32(1.0 / 6.0)


@kernel(forceinline=True)
def _place(coordinate, size):
    """In texels, 0 for what is no number; so far as a float can tell."""
    x = np.float64(coordinate) * size
    return min(max(x, -_BIG), _BIG) if x == x else 0.0


@kernel(forceinline=True)
def _inside(i, size, extension):
    """The row or column that stands for one that may be outside; -1: black and clear."""
    if 0 <= i < size:
        return i
    if extension == _REPEAT:
        return i % size
    if extension == _MIRROR:
        i %= 2 * size
        return min(i, 2 * size - 1 - i)
    if extension == _CLIP:
        return np.int64(-1)
    return min(max(i, 0), size - 1)


@kernel(forceinline=True)
def _weight(k, t, cubic):
    """Of texel k of those about a place, t of the way from one to the next.

    Cubic: by the uniform cubic B-spline.
    """
    if not cubic:
        return t if k == 1 else _ONE - t
    if k == 0:
        return t * (t * (t * -_SIXTH + _HALF) - _HALF) + _SIXTH
    if k == 1:
        return t * t * (t * _HALF - _ONE) + _TWO_THIRDS
    if k == 2:
        return t * (t * (t * -_HALF + _HALF) + _HALF) + _SIXTH
    return t * t * t * _SIXTH


@kernel
def look_up(image, u, v, interpolation, extension, scale, out):
    """Write scale * RGBA, float32 (n, 4), at places in units of the image.

    image: float32 or uint8 (h, w, 4), row 0 at v = 0; u, v: float32 (n,); interpolation, extension:
        values of INTERPOLATIONS and EXTENSIONS; scale: float32
    """
    height, width = image.shape[0], image.shape[1]
    closest, cubic = interpolation == _CLOSEST, interpolation == _CUBIC
    aside, reach = (1, 4) if cubic else (0, 1 if closest else 2)
    for n in range(len(u)):
        x, y = _place(u[n], width), _place(v[n], height)
        if not closest:
            x, y = x - 0.5, y - 0.5
        left, low = np.int64(np.floor(x)), np.int64(np.floor(y))
        tx, ty = np.float32(x - left), np.float32(y - low)
        if closest:
            tx = ty = np.float32(0.0)
        for c in range(4):
            out[n, c] = 0.0
        for j in range(reach):
            row = _inside(low + (j - aside), height, extension)
            weight_y = scale * _weight(j, ty, cubic)
            for i in range(reach):
                column = _inside(left + (i - aside), width, extension)
                if row < 0 or column < 0:
                    continue
                weight = weight_y * _weight(i, tx, cubic)
                for c in range(4):
                    out[n, c] += weight * np.float32(image[row, column, c])

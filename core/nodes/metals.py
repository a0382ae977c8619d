"""A metal by its complex index of refraction: the F82 curve [Kutz21] that is nearest to its own."""

from __future__ import annotations

import numpy as np

_ANGLES = 64
# Middles of parts of 0 ... 1, and what of an F82 curve is there: all light, base color, edge.
_COSINES = (np.arange(_ANGLES) + 0.5) / _ANGLES
_BENT, _DIP = (1.0 - _COSINES) ** 5, _COSINES * (1.0 - _COSINES) ** 6
# Least squares over the cosine: base color and edge of a curve less _BENT, (2, _ANGLES).
_ROOTS = np.sqrt(_COSINES)
_FIT = np.linalg.pinv(np.stack([1.0 - _BENT, -_DIP], -1) * _ROOTS[:, None]) * _ROOTS
_EDGE = (6.0 / 7.0) ** 6 / 7.0, (6.0 / 7.0) ** 5  # _DIP and _BENT where the tint is told
_MOST_POINTS = 1 << 14


def reflectance(cosine, n, k):
    """Fresnel's, of light that is not polarised, by a metal of index n + ik in vacuum."""
    sine2 = 1.0 - cosine**2
    t = n**2 - k**2 - sine2
    length = np.sqrt(t**2 + 4.0 * n**2 * k**2)
    across = np.sqrt(np.maximum(2.0 * (length + t), 0.0)) * cosine
    s = (length + cosine**2 - across) / (length + cosine**2 + across)
    up, side = length * cosine**2 + sine2**2, across * sine2
    return 0.5 * s * (1.0 + (up - side) / (up + side))


def approximated(cosine, n, k):
    """The same as Cycles before Blender 5: n^2 + k^2 large beside the sine [Pharr10, 8.2.1].

    Too bright by .1 to 1 % of metals' light, by more where they hardly absorb.
    """
    whole, across = n**2 + k**2, 2.0 * n * cosine
    along = whole * cosine**2
    p = (along - across + 1.0) / (along + across + 1.0)
    s = (whole - across + cosine**2) / (whole + across + cosine**2)
    return 0.5 * (p + s)


def conductor(context, settings, inputs):
    """Base color and edge tint of the curve that is nearest in the mean square over the cosine:
    within 2 % for metals, their light within .1 %.

    settings: approximated, whether to that curve, and not to Fresnel's
    """
    of = approximated if settings.get("approximated") else reflectance
    n, k = np.broadcast_arrays(*(np.atleast_2d(inputs[name]) for name in ("IOR", "Extinction")))
    parts = (slice(i, i + _MOST_POINTS) for i in _starts(len(n)))
    found = [_nearest(of, n[part], k[part]) for part in parts]
    base, tint = (np.concatenate(parts) for parts in zip(*found, strict=True))
    if np.ndim(inputs["IOR"]) == np.ndim(inputs["Extinction"]) == 1:
        base, tint = base[0], tint[0]
    return {"Base Color": base, "Edge Tint": tint}


def _starts(n):
    return range(0, max(n, 1), _MOST_POINTS)


def _nearest(of, n, k):
    """(base color, edge tint), float32 (m, 3) each."""
    n, k = (np.maximum(value, 0.0).astype(np.float64)[:, None] for value in (n, k))
    curve = of(_COSINES[:, None], n, k) - _BENT[:, None]
    base, edge = np.einsum("ra,mac->rmc", _FIT, curve)
    base = np.clip(base, 0.0, 1.0)
    tint = 1.0 - edge * _EDGE[0] / (base + (1.0 - base) * _EDGE[1])
    return base.astype(np.float32), np.clip(tint, 0.0, 1.0).astype(np.float32)


FUNCTIONS = {"conductor": conductor}

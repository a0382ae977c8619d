"""A place on an area lamp that a point sees, its density, and whether a direction meets the lamp.

Rectangles by their solid angle [Urena13]; where that has no digits left, by their area. Ellipses by
their area; where they look large, by the rectangle around them, less its corners: then no place
weighs more than another. Where a narrow spread lets a point see a part of the lamp only, by the
rectangle around this part. float64: a small solid angle is a difference of numbers close to pi.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..data.lamps import ELLIPSE, ROUND_BEAM

_TWO_PI = 2.0 * math.pi
# Solid angles, sr, below which a rectangle and above which an ellipse is sampled the other way.
_SMALL, _LARGE = 1e-4, 0.5
# How an area is sampled from a point.
_NOT_SEEN, _BY_ANGLE, _BY_RECTANGLE, _BY_ELLIPSE = range(4)
_NO_ANGLES = (0.0, 0.0, 0.0, 0.0)
# What sampling and meeting a lamp give where there is no light: see lamp_shapes.sample_lamp.
NO_LIGHT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel(forceinline=True)
def _along(vectors, i, x, y, z):
    return vectors[i, 0] * x + vectors[i, 1] * y + vectors[i, 2] * z


@kernel(forceinline=True)
def _spread_factor(lamps, i, cosine):
    """What an area shines at an angle from its axis, of what it does along it."""
    tangent = np.float64(lamps.spread[i, 0])
    if tangent == np.inf:
        return 1.0
    own = math.sqrt(max(1.0 - cosine * cosine, 0.0)) / max(cosine, 1e-12)
    return max(tangent - own, 0.0) * np.float64(lamps.spread[i, 1])


@kernel(forceinline=True)
def _is_slanted(lamps, i):
    """Whether an area's axis is not across its plane."""
    a, f = lamps.axis, lamps.forward
    return a[i, 0] != f[i, 0] or a[i, 1] != f[i, 1] or a[i, 2] != f[i, 2]


@kernel(forceinline=True)
def _window(lamps, i, u, v, height):
    """The part (u0, v0, u1, v1) of an area that its spread lets a point see; may be empty.

    u, v: of the foot of the point on the area's plane, from its centre; height: over the plane
    """
    half_u, half_v = 0.5 * np.float64(lamps.size[i, 0]), 0.5 * np.float64(lamps.size[i, 1])
    reach = np.float64(lamps.spread[i, 0]) * height
    if _is_slanted(lamps, i):  # the spread is not round the plane's normal: all of it may be seen
        reach = np.inf
    return (
        max(u - reach, -half_u),
        max(v - reach, -half_v),
        min(u + reach, half_u),
        min(v + reach, half_v),
    )


@kernel(forceinline=True)
def _edge(a, b, c, height):
    """Cosines that [Urena13] needs of one side of a rectangle."""
    n = a * (b - c)
    return n / math.sqrt(max(height * height * (b - c) * (b - c) + n * n, 1e-300))


@kernel(forceinline=True)
def _acos(x):
    return math.acos(min(max(x, -1.0), 1.0))


@kernel(forceinline=True)
def _solid_angle(u0, v0, u1, v1, height):
    """(solid angle of a rectangle, and k, b0, b1 of [Urena13]); origin: the foot of the point."""
    n0, n1 = _edge(v0, u0, u1, height), _edge(u1, v1, v0, height)
    n2, n3 = _edge(v1, u1, u0, height), _edge(u0, v0, v1, height)
    g0, g1, g2, g3 = _acos(-n0 * n1), _acos(-n1 * n2), _acos(-n2 * n3), _acos(-n3 * n0)
    k = _TWO_PI - g2 - g3
    return max(g0 + g1 - k, 0.0), k, n0, n2


@kernel(forceinline=True)
def _on_rectangle(u0, v0, u1, v1, height, angles, a, b):
    """A point of a rectangle, uniform in solid angle [Urena13]: (u, v) from the point's foot."""
    angle, k, b0, b1 = angles
    au = a * angle + k
    fu = (math.cos(au) * b0 - b1) / math.sin(au)
    cu = math.copysign(1.0 / math.sqrt(fu * fu + b0 * b0), fu)
    cu = min(max(cu, -1.0), 1.0)
    u = min(max(cu * height / math.sqrt(max(1.0 - cu * cu, 1e-14)), u0), u1)
    d2 = u * u + height * height
    h0, h1 = v0 / math.sqrt(d2 + v0 * v0), v1 / math.sqrt(d2 + v1 * v1)
    h = h0 + b * (h1 - h0)
    v = h * math.sqrt(d2) / math.sqrt(max(1.0 - h * h, 1e-14))
    return u, min(max(v, v0), v1)


@kernel(forceinline=True)
def _plan_area(lamps, i, u, v, height):
    """(How an area is sampled from a point, window from the foot, sr or m2, _solid_angle)."""
    u0, v0, u1, v1 = _window(lamps, i, u, v, height)
    window = u0 - u, v0 - v, u1 - u, v1 - v
    if u0 >= u1 or v0 >= v1:
        return _NOT_SEEN, window, 1.0, _NO_ANGLES
    area = (u1 - u0) * (v1 - v0)
    x, y = 0.5 * (window[0] + window[2]), 0.5 * (window[1] + window[3])
    squared = x * x + y * y + height * height
    looks = area * height / (squared * math.sqrt(squared))
    whole = 0.25 * math.pi * np.float64(lamps.size[i, 0]) * np.float64(lamps.size[i, 1])
    as_ellipse = lamps.kind[i] == ELLIPSE and area > whole
    if looks > (_LARGE if as_ellipse else _SMALL):
        angles = _solid_angle(window[0], window[1], window[2], window[3], height)
        return _BY_ANGLE, window, max(angles[0], 1e-12), angles
    if as_ellipse:
        return _BY_ELLIPSE, window, whole, _NO_ANGLES
    return _BY_RECTANGLE, window, area, _NO_ANGLES


@kernel(forceinline=True)
def _is_outside(lamps, i, u, v):
    """Whether the place (u, v) of the plane, from the lamp's centre, is not on the lamp."""
    x, y = 2.0 * u / np.float64(lamps.size[i, 0]), 2.0 * v / np.float64(lamps.size[i, 1])
    kind = lamps.kind[i]
    if kind == ELLIPSE or kind == ROUND_BEAM:
        return x * x + y * y > 1.0
    return max(abs(x), abs(y)) > 1.0


@kernel(forceinline=True)
def _foot(lamps, i, px, py, pz):
    """Of a point in an area's frame: (u, v) from its centre; height over its plane, 0 where it does
    not shine; 1, or -1 where an area that is slanted shines from its other side."""
    x = px - np.float64(lamps.position[i, 0])
    y = py - np.float64(lamps.position[i, 1])
    z = pz - np.float64(lamps.position[i, 2])
    u, v = _along(lamps.right, i, x, y, z), _along(lamps.up, i, x, y, z)
    height = _along(lamps.forward, i, x, y, z)
    if not _is_slanted(lamps, i):
        return u, v, max(height, 0.0), 1.0
    shines = _along(lamps.axis, i, x, y, z) > 0.0
    return u, v, abs(height) if shines else 0.0, -1.0 if height < 0.0 else 1.0


@kernel(forceinline=True)
def _area_pdf(plan, measure, height, far):
    """Density per solid angle of a place at distance ``far``."""
    return 1.0 / measure if plan == _BY_ANGLE else far * far * far / (height * measure)


@kernel
def sample_area(lamps, i, px, py, pz, a, b):
    """sample_lamp of a RECTANGLE or an ELLIPSE."""
    u, v, height, side = _foot(lamps, i, px, py, pz)
    if height <= 0.0:
        return NO_LIGHT
    plan, (u0, v0, u1, v1), measure, angles = _plan_area(lamps, i, u, v, height)
    if plan == _NOT_SEEN:
        return NO_LIGHT
    if plan == _BY_ANGLE:
        x, y = _on_rectangle(u0, v0, u1, v1, height, angles, a, b)
    elif plan == _BY_RECTANGLE:
        x, y = u0 + a * (u1 - u0), v0 + b * (v1 - v0)
    else:
        radius, phi = 0.5 * math.sqrt(a), _TWO_PI * b
        x = radius * math.cos(phi) * np.float64(lamps.size[i, 0]) - u
        y = radius * math.sin(phi) * np.float64(lamps.size[i, 1]) - v
    if lamps.kind[i] == ELLIPSE and _is_outside(lamps, i, u + x, v + y):
        return NO_LIGHT
    far = math.sqrt(x * x + y * y + height * height)
    s, r, t, f = 1.0 / far, lamps.right, lamps.up, lamps.forward
    z = side * height
    dx = s * (x * r[i, 0] + y * t[i, 0] - z * f[i, 0])
    dy = s * (x * r[i, 1] + y * t[i, 1] - z * f[i, 1])
    dz = s * (x * r[i, 2] + y * t[i, 2] - z * f[i, 2])
    factor = _spread_factor(lamps, i, -_along(lamps.axis, i, dx, dy, dz))
    return dx, dy, dz, far, factor, _area_pdf(plan, measure, height, far)


@kernel
def meet_area(lamps, i, px, py, pz, dx, dy, dz):
    """meet_lamp of a RECTANGLE or an ELLIPSE."""
    u, v, height, side = _foot(lamps, i, px, py, pz)
    cosine = -side * _along(lamps.forward, i, dx, dy, dz)
    if height <= 0.0 or cosine <= 1e-9:
        return 0.0, 0.0, 0.0
    far = height / cosine
    x, y = far * _along(lamps.right, i, dx, dy, dz), far * _along(lamps.up, i, dx, dy, dz)
    factor = _spread_factor(lamps, i, -_along(lamps.axis, i, dx, dy, dz))
    if factor <= 0.0 or _is_outside(lamps, i, u + x, v + y):
        return 0.0, 0.0, 0.0
    plan, _, measure, _ = _plan_area(lamps, i, u, v, height)
    if plan == _NOT_SEEN:
        return 0.0, 0.0, 0.0
    return far, factor, _area_pdf(plan, measure, height, far)


@kernel
def sample_beam(lamps, i, px, py, pz):
    """sample_lamp of a BEAM or a ROUND_BEAM."""
    u, v, height, _ = _foot(lamps, i, px, py, pz)
    if height <= 0.0 or _is_outside(lamps, i, u, v):
        return NO_LIGHT
    f = lamps.forward
    return -np.float64(f[i, 0]), -np.float64(f[i, 1]), -np.float64(f[i, 2]), height, 1.0, 1.0

"""Thin films on gloss: light that both sides of a layer reflect interferes [Belcour17].

With r12 and r23 the amplitudes that a film's upper and its lower side reflect, of one polarisation,
T = 1 - r12^2, and x = 2 n cos d, the difference of the ways through a film of index n, d thick:

    R = r12^2 + C + 2 (C - T) sum_m Re(S(m x) q^m),   C = T^2 |r23|^2 / (1 - r12^2 |r23|^2)

q = -r12 r23, and m = 1, 2, 3. S is the eye's (thin_film_seen.py). Under a film a metal of artists'
colors reflects both polarisations alike, by the F82 curve [Kutz21] that it has in a medium of the
film's index; its phases are those of a conductor of the same colors [Gulbrandsen14]. All that was
measured in Cycles' pictures: docs/decisions/0047-thin-films.md.

Of a point with a film Lobes.tint has the thickness, nm, the index, and as one number the table and
whether f0 and edge of its metal are index and extinction of a conductor; else edge is what the
metal reflects at the cosine 1/7. In Cycles of Blender 4 metals have no films: theirs is as ever.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from .lobes import CONDUCTOR, CONDUCTOR_LOBE, DIELECTRIC, DIELECTRIC_LOBE
from .microfacet import (
    F82_FACTOR,
    F82_SCHLICK,
    HALF,
    ONE,
    TWO,
    ZERO,
    f82_curve,
    schlick_weight,
)
from .thin_film_seen import seen_orders
from .thin_film_tables import GAUSSIANS

INDEXED = 8  # bit of Lobes.tint[2]: the metal is given by its indices
# nm below which a film's index goes to that of air; in Cycles of Blender 4 more.
_FADES, _FADED_IN_4 = np.float32(1.0), np.float32(30.0)
_MOST_F0, _TINY, _LEAST_F0 = np.float32(0.999), np.float32(1e-20), np.float32(1e-5)
_THREE = np.float32(3.0)


@kernel(forceinline=True)
def _index(film, space):
    """That of a film, faded out where it is very thin."""
    fades = _FADED_IN_4 if space == GAUSSIANS else _FADES
    if film[0] >= fades:
        return film[1]
    t = film[0] / fades
    return ONE + (film[1] - ONE) * t * t * (_THREE - TWO * t)


@kernel(forceinline=True)
def _upper_side(index, cosine, inside):
    """r12 of both polarisations; inside: index times the cosine in the film."""
    along = index * index * cosine
    return (cosine - inside) / (cosine + inside), (along - inside) / (along + inside)


@kernel(forceinline=True)
def _interfered(r12, share, q_real, q_imaginary, orders, c):
    """R of channel c for one polarisation; share: |r23|^2."""
    above = r12 * r12
    passed = ONE - above
    both = passed * passed * share / max(ONE - above * share, _TINY)
    first, second, third = orders
    x, y = q_real, q_imaginary
    total = first[c] * x - first[3 + c] * y
    x2, y2 = x * x - y * y, TWO * x * y
    total += second[c] * x2 - second[3 + c] * y2
    x3, y3 = x2 * x - y2 * y, x2 * y + y2 * x
    total += third[c] * x3 - third[3 + c] * y3
    return above + both + TWO * (both - passed) * total


@kernel
def dielectric_film(film, fresnel, f0, cosine):
    """What a dielectric under a film reflects: (r, g, b), each at least 0.

    film: of Lobes.tint; fresnel, f0: its rows of Lobes, f0 scales the curve; cosine: wo . h
    """
    space = int(film[2]) & (INDEXED - 1)
    c = min(max(cosine, ZERO), ONE)
    index, less = _index(film, space), c * c - ONE
    inside2, below2 = index * index + less, fresnel[0] + c * c
    if inside2 <= ZERO or below2 <= ZERO:  # all of it, at either side
        return ONE, ONE, ONE
    inside, below = math.sqrt(inside2), math.sqrt(below2)
    s12, p12 = _upper_side(index, c, inside)
    s23 = (inside - below) / (inside + below)
    a, b = (fresnel[0] + ONE) * inside, index * index * below
    p23 = (a - b) / (a + b)
    orders = seen_orders(space, TWO * film[0] * inside)
    return (
        _scaled(_of_dielectric(s12, p12, s23, p23, orders, 0), f0[0], fresnel),
        _scaled(_of_dielectric(s12, p12, s23, p23, orders, 1), f0[1], fresnel),
        _scaled(_of_dielectric(s12, p12, s23, p23, orders, 2), f0[2], fresnel),
    )


@kernel(forceinline=True)
def _of_dielectric(s12, p12, s23, p23, orders, c):
    s = _interfered(s12, s23 * s23, -s12 * s23, ZERO, orders, c)
    p = _interfered(p12, p23 * p23, -p12 * p23, ZERO, orders, c)
    return min(max(HALF * (s + p), ZERO), ONE)


@kernel(forceinline=True)
def _scaled(reflectance, f0, fresnel):
    """As far as it is below 1, in proportion to what is wanted along the normal."""
    if fresnel[1] <= _LEAST_F0:
        return reflectance
    share = min((ONE - reflectance) * fresnel[2], ONE)
    return reflectance * (ONE + (f0 / fresnel[1] - ONE) * share)


@kernel(forceinline=True)
def _lower_side(n, k, index, cosine, inside):
    """r23 of both polarisations, of a metal of index n + ik: real and imaginary parts."""
    real, twice = n * n - k * k, TWO * n * k
    a = real - ONE + cosine * cosine
    length = math.sqrt(a * a + twice * twice)
    if a >= ZERO:
        x = math.sqrt(HALF * (length + a))
        y = HALF * twice / max(x, _TINY)
    else:
        y = math.sqrt(HALF * (length - a))
        x = HALF * twice / max(y, _TINY)
    over = ONE / max((inside + x) * (inside + x) + y * y, _TINY)
    s_real, s_imaginary = (inside * inside - x * x - y * y) * over, -TWO * inside * y * over
    a, b, u, v = real * inside, twice * inside, index * index * x, index * index * y
    over = ONE / max((a + u) * (a + u) + (b + v) * (b + v), _TINY)
    p_real = (a * a - u * u + b * b - v * v) * over
    return s_real, s_imaginary, p_real, TWO * (b * u - a * v) * over


@kernel(forceinline=True)
def conductor_reflectance(n, k, cosine):
    """Of a metal of index n + ik in air: Fresnel's."""
    a, b, c, d = _lower_side(n, k, ONE, cosine, cosine)
    return HALF * (a * a + b * b + c * c + d * d)


@kernel(forceinline=True)
def _as_conductor(f0, edge):
    """Index and extinction of a metal by its colors [Gulbrandsen14]."""
    r = min(f0, _MOST_F0)
    root = math.sqrt(r)
    n = edge * (ONE - r) / (ONE + r) + (ONE - edge) * (ONE + root) / (ONE - root)
    k2 = (r * (n + ONE) * (n + ONE) - (n - ONE) * (n - ONE)) / (ONE - r)
    return n, math.sqrt(max(k2, ZERO))


@kernel(forceinline=True)
def _f82_below(n, k, edge, index, cosine):
    """The curve of a metal in a medium of an index, which goes through ``edge`` as in air."""
    less, more = n - index, n + index
    f0 = (less * less + k * k) / (more * more + k * k)
    bend = (f0 + (ONE - f0) * F82_SCHLICK - edge) * F82_FACTOR
    s = schlick_weight(cosine)
    return f82_curve(f0, bend, s, cosine * s * (ONE - cosine))


@kernel
def _of_metal(is_indexed, first, second, index, cosine, inside, upper, orders, c):
    """R of channel c; first, second: index and extinction, or the two colors; upper: r12."""
    n, k, share = first, second, ZERO
    if not is_indexed:
        n, k = _as_conductor(first, second)
        share = _f82_below(n, k, second, index, inside / index)
    s_real, s_imaginary, p_real, p_imaginary = _lower_side(n, k, index, cosine, inside)
    s2, p2 = (
        s_real * s_real + s_imaginary * s_imaginary,
        p_real * p_real + p_imaginary * p_imaginary,
    )
    s_share, p_share, s12, p12 = s2, p2, -upper[0], -upper[1]
    if not is_indexed:
        s_share = p_share = share
        s12 *= math.sqrt(share / max(s2, _TINY))
        p12 *= math.sqrt(share / max(p2, _TINY))
    s = _interfered(upper[0], s_share, s12 * s_real, s12 * s_imaginary, orders, c)
    p = _interfered(upper[1], p_share, p12 * p_real, p12 * p_imaginary, orders, c)
    return min(max(HALF * (s + p), ZERO), ONE)


@kernel
def metal_film(film, first, second, cosine):
    """What a metal under a film reflects: (r, g, b); first, second: its rows of f0 and edge."""
    code = int(film[2])
    space, c = code & (INDEXED - 1), min(max(cosine, ZERO), ONE)
    if space == GAUSSIANS:
        s = schlick_weight(c)
        t = c * s * (ONE - c)
        return (
            f82_curve(first[0], second[0], s, t),
            f82_curve(first[1], second[1], s, t),
            f82_curve(first[2], second[2], s, t),
        )
    index = _index(film, space)
    inside2 = index * index - ONE + c * c
    if inside2 <= ZERO:
        return ONE, ONE, ONE
    inside = math.sqrt(inside2)
    upper, orders = _upper_side(index, c, inside), seen_orders(space, TWO * film[0] * inside)
    own = code & INDEXED, index, c, inside, upper, orders
    return (
        _channel(own, first[0], second[0], 0),
        _channel(own, first[1], second[1], 1),
        _channel(own, first[2], second[2], 2),
    )


@kernel(forceinline=True)
def _channel(own, first, second, c):
    is_indexed, index, cosine, inside, upper, orders = own
    return _of_metal(is_indexed != 0, first, second, index, cosine, inside, upper, orders, c)


@kernel
def film_color(kind, film, dielectric, conductor, cosine):
    """What the facets of a point with a film reflect: (r, g, b).

    dielectric: its weight, f0 and fresnel; conductor: its weight, f0 and edge; of Lobes
    """
    r = g = b = ZERO
    if kind & DIELECTRIC_LOBE:
        w = dielectric[0]
        x, y, z = dielectric_film(film, dielectric[2], dielectric[1], cosine)
        r, g, b = w[0] * x, w[1] * y, w[2] * z
    if kind & CONDUCTOR_LOBE:
        w = conductor[0]
        x, y, z = metal_film(film, conductor[1], conductor[2], cosine)
        r, g, b = r + w[0] * x, g + w[1] * y, b + w[2] * z
    return r, g, b


@kernel(forceinline=True)
def triple(a, p):
    """Row p as a tuple."""
    return a[p, 0], a[p, 1], a[p, 2]


@kernel
def film_color_of(lobes, p, cosine):
    """film_color of row p of Lobes."""
    weight, f0 = lobes.weight[p], lobes.f0[p]
    dielectric = triple(weight, DIELECTRIC), triple(f0, DIELECTRIC), triple(lobes.fresnel, p)
    conductor = triple(weight, CONDUCTOR), triple(f0, CONDUCTOR), triple(lobes.edge, p)
    return film_color(lobes.kind[p], triple(lobes.tint, p), dielectric, conductor, cosine)

"""Light x hair at cells of the sphere, for the product, as lobe_cells.py has the other lobes.

The lobes' curves are replaced by others of about their shape, without exponentials and angles,
which compile to vector instructions: what a sample brings is worked out by the lobes themselves,
and the density only has to be about as theirs, and nowhere far below.

    exp(-t)                of M          (1 + t / 8)^-8
    I0(x) exp(-x)          of M          (1 + 2 pi x)^-1/2, of all parts the same
    1 / cosh^2(x / 2 s)    of N          (1 + (1 - cos x) / 8 s^2)^-4
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.hair import ALL_ROUND, LAMPS_ALONE, LOGISTIC, chiang_at
from ..bsdf.hair_frame import frame_at
from ..bsdf.lambert_kinds import CHIANG, HAIR_REFLECTION
from ..bsdf.lobes_at import lobes_at
from ..bsdf.luminance import luminance
from ..bsdf.microfacet import HALF, ONE, PI, QUARTER, TWO, ZERO
from ..unit_square.sphere_map import CELL_REACH

# What a cell has at least of the mean, and of its light where the horizon goes through it.
_LEAST, _CORNER = np.float32(0.03), np.float32(0.05)
# Of the samples, those that follow the lobes: at least, and half where v is this.
_FOLLOWS, _NARROW = np.float32(0.05), np.float32(0.012)
_REACH = np.float32(CELL_REACH)
_EIGHTH, _TWO_PI, _TINY = np.float32(0.125), np.float32(2.0 * math.pi), np.float32(1e-20)


class Bell(NamedTuple):
    """One of a strand's parts. tilt: sine and cosine of its angle; turn: its cosine and sine, round
    the strand; along: factor of 1 - cos along it; amount: of its light
    """

    tilt: tuple
    turn: tuple
    along: np.float32
    amount: np.float32


@kernel(forceinline=True)
def _bell(hair, k, color, at):
    """Part k of Chiang's model: R, TT, TRT."""
    sine, cosine = hair.tilts[k]
    amount = luminance(color[0] * at.diffuse[0], color[1] * at.diffuse[1], color[2] * at.diffuse[2])
    turn = hair.turns[k]
    return Bell(
        (sine, cosine),
        (math.cos(turn), math.sin(turn)),
        _EIGHTH / hair.widths[k],
        amount * hair.gains[k] * hair.gain * QUARTER / hair.scale,
    )


@kernel(forceinline=True)
def _tilted(bell, frame, sin_i, cos_i):
    """The factor along the strand that is to be raised to the 8th power."""
    s, c = bell.tilt
    sine, cosine = sin_i * c + cos_i * s, abs(cos_i * c - sin_i * s)
    return ONE + (ONE + sine * frame.sin_o - cosine * frame.cos_o) * bell.along


@kernel(forceinline=True)
def _turned(bell, u, v, by):
    """That round it, to the 4th. u, v: cosine and sine of the angle from the viewer's; by: of the
    lobe's width"""
    return ONE + (ONE - (u * bell.turn[0] + v * bell.turn[1])) * by


@kernel(forceinline=True)
def _power4(x):
    x *= x
    return x * x


@kernel(forceinline=True)
def _even_slow(hair, k):
    """I0(x) exp(-x) of part k where wi goes along the strand as wo does, over that of R."""
    x = hair.frame.cos_o * hair.frame.cos_o * _TWO_PI
    return np.sqrt((ONE + x / hair.widths[0]) / (ONE + x / hair.widths[k]))


@kernel
def _fill_chiang(at, cells, spread2, values):
    """BSDF x cosine, about, at cells, of both of a strand's sides."""
    hair = chiang_at(at, spread2)
    frame = hair.frame
    along, toward, across = frame.along, frame.toward, frame.across
    r, tt = _bell(hair, 0, (hair.r, hair.r, hair.r), at), _bell(hair, 1, hair.tt, at)
    trt, rest = _bell(hair, 2, hair.trt, at), _bell(hair, 2, hair.rest, at)
    of_tt, of_trt = tt.amount * _even_slow(hair, 1), trt.amount * _even_slow(hair, 2)
    of_rest = rest.amount * _even_slow(hair, 2) * TWO * hair.scale / (PI * hair.gain)
    slow = _TWO_PI * frame.cos_o / hair.widths[0]
    # Seen from the strand's ends a cell is wide round the axis.
    narrow = LOGISTIC * hair.scale * hair.scale / spread2
    x, y, z = cells.x, cells.y, cells.z
    for k in range(len(values)):
        sin_i = along[0] * x[k] + along[1] * y[k] + along[2] * z[k]
        cos_i = np.sqrt(max(ONE - sin_i * sin_i, _TINY))
        inverse = ONE / cos_i
        u = (toward[0] * x[k] + toward[1] * y[k] + toward[2] * z[k]) * inverse
        v = (across[0] * x[k] + across[1] * y[k] + across[2] * z[k]) * inverse
        wide = ONE + (inverse * inverse - ONE) / narrow
        by = _EIGHTH / (hair.scale * hair.scale * wide)
        a, b = _tilted(r, frame, sin_i, cos_i), _tilted(tt, frame, sin_i, cos_i)
        c, d = _tilted(trt, frame, sin_i, cos_i), _power4(_turned(trt, u, v, by))
        a = _power4(a * a * _turned(r, u, v, by))
        b = _power4(b * b * _turned(tt, u, v, by))
        found = r.amount / a + of_tt / b + (of_trt + of_rest * d) / (_power4(c * c) * d)
        values[k] = found / np.sqrt((ONE + slow * cos_i) * wide)


@kernel
def _fill_bells(at, cells, radius, spread2, values):
    """The same of the Hair BSDF."""
    frame = frame_at(at.tangent, at.wo)
    along, toward = frame.along, frame.toward
    white = luminance(at.diffuse[0], at.diffuse[1], at.diffuse[2])
    mirrors = at.rough[3] == HAIR_REFLECTION
    twice = TWO * at.rough[2]
    s, c = math.sin(twice), math.cos(twice)
    sin_o, cos_o = frame.sin_o * c - frame.cos_o * s, frame.cos_o * c + frame.sin_o * s
    width2 = at.rough[0] * at.rough[0] + spread2
    round2 = at.rough[1] * at.rough[1] + spread2
    side, by = (ONE, QUARTER / round2) if mirrors else (-ONE, TWO / round2)
    x, y, z = cells.x, cells.y, cells.z
    for k in range(len(values)):
        sin_i = along[0] * x[k] + along[1] * y[k] + along[2] * z[k]
        cos_i = np.sqrt(max(ONE - sin_i * sin_i, _TINY))
        u = side * (toward[0] * x[k] + toward[1] * y[k] + toward[2] * z[k])
        half2 = HALF * (ONE + sin_i * sin_o - cos_i * cos_o)
        found = cos_i * (width2 + half2) * (ONE + by * (ONE - u / cos_i))
        values[k] = white / found if u > -radius else ZERO


@kernel
def _shade_side(normal, cells, radius, values):
    """Take from the cells what is below a normal."""
    x, y, z = cells.x, cells.y, cells.z
    for k in range(len(values)):
        cosine = normal[0] * x[k] + normal[1] * y[k] + normal[2] * z[k]
        above = min(max(HALF + HALF * cosine / radius, _CORNER), ONE)
        values[k] *= above if cosine > -_REACH * radius else ZERO


@kernel
def fill_hair(lobes, p, cells, radius, values):
    """Write the base's cells of the product of row p, which is hair: float32 (n,), values.

    cells: ProductCells; radius: of a disc of a cell's solid angle
    Returns the part of the samples that is to follow the lobes.
    """
    at, follow, spread2 = lobes_at(lobes, p), _FOLLOWS, QUARTER * radius * radius
    if at.fresnel[2] == LAMPS_ALONE:
        values[:] = ZERO
        return follow
    if at.rough[3] == CHIANG:
        _fill_chiang(at, cells, spread2, values)
        follow = max(follow, _NARROW / (_NARROW + at.rough[0]))
    else:
        _fill_bells(at, cells, radius, spread2, values)
    total = ZERO
    for k in range(len(values)):
        total += values[k]
    least = _LEAST * total / np.float32(len(values))
    for k in range(len(values)):
        values[k] = max(values[k], least) * cells.light[k]
    if at.fresnel[2] != ALL_ROUND:
        _shade_side(at.normal, cells, radius, values)
    return follow

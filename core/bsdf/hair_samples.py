"""Directions by the lobes of a strand: exact samples of R, TT, TRT and the rest [Chiang16, dEon13].

A part is taken by its luminance, then the angle along the strand by M, for which two numbers are
needed, and the one round it by N. M is tilted on wo's side here, where samples of it fill the
sphere; light is tilted on wi's (hair.py), which differs by little. The Hair BSDF, whose bells end
where Cycles' samples do, has directions of all the sphere alike.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .hair import SERIES_TERMS, Chiang, chiang_at, part_round
from .hair_frame import angles_of, cosine_of
from .lambert_kinds import CHIANG
from .luminance import luminance
from .microfacet import HALF, INV_PI, ONE, PI, TWO, ZERO

_TINY = np.float32(1e-20)
# Up to here ten terms are I0 to 1e-5, and so are three terms of its asymptote beyond. What samples
# weigh must know it better than Cycles' own, which lacks up to 2 % (hair.py).
_SERIES = np.float32(6.0)
_FIRST, _SECOND, _THIRD = (np.float32(x) for x in (1 / 8, 9 / 128, 225 / 3072))
_UNIT, _BITS, _EIGHT = np.float32(2.0**-24), np.float32(2.0**24), np.uint32(8)
_BELOW_ONE = np.float32(1.0 - 2.0**-24)


class Shares(NamedTuple):
    """Of a strand's samples, those of R, TT, TRT, and with a sum of 1 the rest; tilted: sines and
    cosines of wo's angle, as R, TT, TRT and the rest are tilted."""

    parts: tuple
    tilted: tuple


@kernel(forceinline=True)
def _tilted_back(hair, k):
    sine, cosine = hair.tilts[k]
    frame = hair.frame
    return frame.sin_o * cosine + frame.cos_o * sine, abs(frame.cos_o * cosine - frame.sin_o * sine)


@kernel
def shares_of(at, hair: Chiang):
    """The Shares of a point. at: LobesAt"""
    white = luminance(at.diffuse[0], at.diffuse[1], at.diffuse[2])
    r = hair.r * white
    d = at.diffuse
    tt = luminance(hair.tt[0] * d[0], hair.tt[1] * d[1], hair.tt[2] * d[2])
    trt = luminance(hair.trt[0] * d[0], hair.trt[1] * d[1], hair.trt[2] * d[2])
    rest = luminance(hair.rest[0] * d[0], hair.rest[1] * d[1], hair.rest[2] * d[2])
    inverse = ONE / max(r + tt + trt + rest, _TINY)
    tilted = _tilted_back(hair, 0), _tilted_back(hair, 1), _tilted_back(hair, 2)
    own = hair.frame.sin_o, hair.frame.cos_o
    return Shares((r * inverse, tt * inverse, trt * inverse), (*tilted, own))


@kernel(forceinline=True)
def _pdf_along(sin_i, cos_i, sin_o, cos_o, v, gain):
    """M, whose integral is 1."""
    both = cos_i * cos_o
    x = both / v
    if x > _SERIES:
        y = ONE / x
        rest = ONE + y * (_FIRST + y * (_SECOND + y * _THIRD))
        return gain * rest * math.exp((both - sin_i * sin_o - ONE) / v) / math.sqrt(TWO * PI * x)
    x2, series = x * x, ZERO
    for k in range(len(SERIES_TERMS)):
        series = series * x2 + SERIES_TERMS[len(SERIES_TERMS) - 1 - k]
    return gain * series * math.exp(-(sin_i * sin_o + ONE) / v)


@kernel
def pdf_strand(hair, shares, wi_x, wi_y, wi_z):
    """The density of sample_strand of Chiang's model, sr^-1."""
    sin_i, phi = angles_of(hair.frame, wi_x, wi_y, wi_z)
    cos_i, pdf, left = cosine_of(sin_i), ZERO, ONE
    for k in range(3):
        sin_o, cos_o = shares.tilted[k]
        along = _pdf_along(sin_i, cos_i, sin_o, cos_o, hair.widths[k], hair.gains[k])
        pdf += shares.parts[k] * along * part_round(hair, k, phi)
        left -= shares.parts[k]
    sin_o, cos_o = shares.tilted[3]
    along = _pdf_along(sin_i, cos_i, sin_o, cos_o, hair.widths[2], hair.gains[2])
    return pdf + max(left, ZERO) * along * HALF * INV_PI


@kernel(forceinline=True)
def _mixed(bits, shift, factor):
    """One round of a hash. (numba makes 64 bits of a product of 32.)"""
    return np.uint32((bits ^ (bits >> np.uint32(shift))) * np.uint32(factor))


@kernel(forceinline=True)
def _more(u1, u2):
    """Two more numbers in [0, 1) of two others: a hash of their bits."""
    a, b = np.uint32(u1 * _BITS), np.uint32(u2 * _BITS)
    a = _mixed(np.uint32(a * np.uint32(0x9E3779B1) + b), 15, 0x85EBCA6B)
    a = _mixed(np.uint32(a ^ b), 13, 0xC2B2AE35)
    b = _mixed(_mixed(a, 16, 0x27D4EB2F), 15, 0x85EBCA6B)
    return np.float32(np.int32(a >> _EIGHT)) * _UNIT, np.float32(np.int32(b >> _EIGHT)) * _UNIT


@kernel
def sample_strand(at, u1, u2):
    """A direction by the lobes of a strand: (x, y, z). at: LobesAt; u1, u2: float32 in [0, 1)"""
    if at.rough[3] != CHIANG:
        z, phi = ONE - TWO * u1, TWO * PI * u2
        r = cosine_of(z)
        return r * math.cos(phi), r * math.sin(phi), z
    hair = chiang_at(at, ZERO)
    shares = shares_of(at, hair)
    which, turn = _more(u1, u2)
    k = 0
    while k < 3 and which >= shares.parts[k]:
        which -= shares.parts[k]
        k += 1
    sin_o, cos_o = shares.tilted[k]
    v = hair.widths[min(k, 2)]
    cosine = ONE + v * math.log(max(u1 + (ONE - u1) * math.exp(-TWO / v), _TINY))
    sin_i = -cosine * sin_o + cosine_of(cosine) * math.cos(TWO * PI * u2) * cos_o
    sin_i = min(max(sin_i, -ONE), ONE)
    if k == 3:
        phi = TWO * PI * turn
    else:
        low = ONE / (ONE + math.exp(PI / hair.scale))
        x = min(max(low + turn * (ONE - TWO * low), _TINY), _BELOW_ONE)
        phi = hair.turns[k] - hair.scale * math.log(ONE / x - ONE)
    frame, cos_i = hair.frame, cosine_of(sin_i)
    x, y = cos_i * math.cos(phi), cos_i * math.sin(phi)
    along, toward, across = frame.along, frame.toward, frame.across
    return (
        along[0] * sin_i + toward[0] * x + across[0] * y,
        along[1] * sin_i + toward[1] * x + across[1] * y,
        along[2] * sin_i + toward[2] * x + across[2] * y,
    )

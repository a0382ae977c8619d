"""Light at a strand of hair: all round it, of what it mirrors and of what goes through it.

CHIANG, Cycles' Principled Hair [Chiang16, after dEon11]: at a place h across the strand light is
mirrored (R), goes through (TT), is mirrored inside once (TRT) or more often. Each of these goes
along the strand by M, round the axis by N:

    f cos_i = sum of A_p(h, theta_o) M(theta_i + tilt_p, theta_o, v_p) N(phi - turn_p(h), s)

HAIR_REFLECTION and HAIR_TRANSMISSION, the Hair BSDF: products of two bell curves [Marschner03].
A strand is the two sides of its surface, each a layer of shading points of its own: a side has the
light from its own half of the sphere. Where rays start beyond the strand, one point has the world's
light from all round. As in Cycles all of it counts as glossy.

Where a point's numbers are (hair_setup.py): Lobes.rough[3] says which model, edge has what the
strand absorbs over its radius, tangent its direction, diffuse the factor of all;

    CHIANG  rough: v, v of R, s; fresnel: index of refraction, tilt in radians
    others  rough: width along, width round, offset
    all     f0[0]: radius, reach, slope (round_points.Circles), the first two in metres; radius 0:
            on a mesh; fresnel[2]: side: 1 or -1, ALL_ROUND or LAMPS_ALONE

TRANSLUCENT_ROUND, a Translucent BSDF on a strand or a point, is here for its rays alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .hair_frame import Frame, angles_of, cosine_of, eval_bells, frame_at
from .lambert_kinds import CHIANG, TRANSLUCENT_ROUND
from .microfacet import (
    FOUR,
    HALF,
    INV_PI,
    ONE,
    PI,
    QUARTER,
    TWO,
    ZERO,
    dot_xyz,
)

# In the place of a side, of strands that rays start beyond: the front has the world's light from
# all round, and what is behind has that of lamps alone.
ALL_ROUND, LAMPS_ALONE = np.float32(2.0), np.float32(-2.0)
_TINY = np.float32(1e-12)
_LEAST_COSINE = np.float32(1e-3)
_ACROSS2 = np.float32(1e-3)  # rays nearer to the axis leave the strand as these do, and no later
# Of a logistic distribution of scale s: variance / s^2.
LOGISTIC = np.float32(math.pi**2 / 3.0)
# Cycles' I0: ten terms of its series up to here (2 % too little at the end), then its asymptote.
_SERIES = np.float32(12.0)
SERIES_TERMS = tuple(np.float32(1.0 / (4.0**k * math.factorial(k) ** 2)) for k in range(10))


class Chiang(NamedTuple):
    """A point's numbers, the same for all wi.

    frame: Frame; tilts: sines and cosines of what R, TT and TRT are tilted by
    r, tt, trt, rest: how much of the light each of them is, the last three as triples
    turns: of R, TT, TRT, radians; widths, gains: v of R, TT, TRT and the factor of M for it
    scale, gain: s, and the factor of N
    """

    frame: Frame
    tilts: tuple
    r: np.float32
    tt: tuple
    trt: tuple
    rest: tuple
    turns: tuple
    widths: tuple
    gains: tuple
    scale: np.float32
    gain: np.float32


@kernel(forceinline=True)
def _reflectance(cosine, eta):
    """Fresnel's, of light that is not polarised."""
    g2 = eta * eta - ONE + cosine * cosine
    if g2 <= ZERO:
        return ONE
    g = math.sqrt(g2)
    a = (g - cosine) / (g + cosine)
    b = (cosine * (g + cosine) - ONE) / (cosine * (g - cosine) + ONE)
    return HALF * a * a * (ONE + b * b)


@kernel(forceinline=True)
def _parts(f, t):
    """TT, TRT and the rest of one channel; f: mirrored at the surface, t: left of a way through."""
    tt = (ONE - f) * (ONE - f) * t
    trt = tt * t * f
    return tt, trt, trt * t * f / max(ONE - t * f, _TINY)


@kernel(forceinline=True)
def _along_gain(v):
    """What makes M's integral 1."""
    return ONE / (v * (ONE - math.exp(-TWO / v)))


@kernel(forceinline=True)
def side_of(at):
    """1 where a point's normal is that of the side that the viewer sees, else -1."""
    return ONE if at.fresnel[2] > ZERO else -ONE


@kernel
def chiang_at(at, spread2):
    """A point's numbers. at: LobesAt; spread2: variance of wi in each direction, radians squared"""
    frame = frame_at(at.tangent, at.wo)
    eta, tilt = at.fresnel[0], at.fresnel[1]
    side = side_of(at)
    across = frame.across
    # The place on the strand: the sine of the angle between its normal and the viewer.
    h = -side * dot_xyz(at.normal, across[0], across[1], across[2])
    h = min(max(h, -ONE), ONE)
    sin_gt = h * frame.cos_o / math.sqrt(max(eta * eta - frame.sin_o * frame.sin_o, _TINY))
    sin_gt = min(max(sin_gt, -ONE), ONE)
    go, gt = math.asin(h), math.asin(sin_gt)
    way = TWO * cosine_of(sin_gt) / max(cosine_of(frame.sin_o / eta), _LEAST_COSINE)
    f = _reflectance(frame.cos_o * cosine_of(h), eta)
    red = _parts(f, math.exp(-at.edge[0] * way))
    green = _parts(f, math.exp(-at.edge[1] * way))
    blue = _parts(f, math.exp(-at.edge[2] * way))
    v = (at.rough[1] + spread2, QUARTER * at.rough[0] + spread2, FOUR * at.rough[0] + spread2)
    s = math.sqrt(at.rough[2] * at.rough[2] + spread2 / LOGISTIC)
    return Chiang(
        frame,
        _tilts(tilt),
        f,
        (red[0], green[0], blue[0]),
        (red[1], green[1], blue[1]),
        (red[2], green[2], blue[2]),
        (-TWO * go, TWO * gt - TWO * go + PI, FOUR * gt - TWO * go + TWO * PI),
        v,
        (_along_gain(v[0]), _along_gain(v[1]), _along_gain(v[2])),
        s,
        ONE / (ONE - TWO / (ONE + math.exp(PI / s))),
    )


@kernel(forceinline=True)
def _tilts(tilt):
    """Scales of the cuticle tilt R by twice, TT by once, TRT by four times their angle."""
    twice, less, most = TWO * tilt, -tilt, -FOUR * tilt
    return (
        (math.sin(twice), math.cos(twice)),
        (math.sin(less), math.cos(less)),
        (math.sin(most), math.cos(most)),
    )


@kernel(forceinline=True)
def _along(sin_i, cos_i, sin_o, cos_o, v, gain):
    """M: sr^-1 round the axis. The signs are such that the mirrored angle is -theta_o."""
    both = cos_i * cos_o
    x = both / v
    if x > _SERIES:
        spread = math.exp((both - sin_i * sin_o - ONE) / v + QUARTER * QUARTER / x)
        return gain * spread / math.sqrt(TWO * PI * x)
    x2, series = x * x, ZERO
    for k in range(len(SERIES_TERMS)):
        series = series * x2 + SERIES_TERMS[len(SERIES_TERMS) - 1 - k]
    return gain * series * math.exp(-(sin_i * sin_o + ONE) / v)


@kernel(forceinline=True)
def _round(phi, turn, s, gain):
    """N: a logistic distribution, cut at half a turn to both sides."""
    x = phi - turn
    x -= TWO * PI * np.float32(math.floor((x + PI) / (TWO * PI)))
    e = math.exp(-abs(x) / s)
    return gain * e / (s * (ONE + e) * (ONE + e))


@kernel(forceinline=True)
def part_along(hair, k, sin_i, cos_i):
    """M of R, TT, TRT, k = 0, 1, 2."""
    (s, c), frame = hair.tilts[k], hair.frame
    tilted = sin_i * c + cos_i * s, abs(cos_i * c - sin_i * s)
    return _along(*tilted, frame.sin_o, frame.cos_o, hair.widths[k], hair.gains[k])


@kernel(forceinline=True)
def part_round(hair, k, phi):
    """N of these."""
    return _round(phi, hair.turns[k], hair.scale, hair.gain)


@kernel(forceinline=True)
def rest_along(hair, sin_i, cos_i):
    """M N of what is mirrored inside more often: the same all round, and not tilted."""
    own = hair.frame.sin_o, hair.frame.cos_o, hair.widths[2], hair.gains[2]
    return _along(sin_i, cos_i, *own) * HALF * INV_PI


@kernel
def eval_chiang(hair, wi_x, wi_y, wi_z):
    """BSDF x cosine from wi, sr^-1: (r, g, b), without the factor of all."""
    sin_i, phi = angles_of(hair.frame, wi_x, wi_y, wi_z)
    cos_i = cosine_of(sin_i)
    r = hair.r * part_along(hair, 0, sin_i, cos_i) * part_round(hair, 0, phi)
    tt = part_along(hair, 1, sin_i, cos_i) * part_round(hair, 1, phi)
    trt = part_along(hair, 2, sin_i, cos_i) * part_round(hair, 2, phi)
    rest = rest_along(hair, sin_i, cos_i)
    return (
        r + tt * hair.tt[0] + trt * hair.trt[0] + rest * hair.rest[0],
        r + tt * hair.tt[1] + trt * hair.trt[1] + rest * hair.rest[1],
        r + tt * hair.tt[2] + trt * hair.trt[2] + rest * hair.rest[2],
    )


@kernel
def eval_strand(at, hair, wi_x, wi_y, wi_z):
    """brdf.eval_at of a point of hair, but of ALL_ROUND from all sides.

    hair: of chiang_at, where it is that
    """
    cosine = dot_xyz(at.normal, wi_x, wi_y, wi_z)
    if cosine <= ZERO and at.fresnel[2] != ALL_ROUND:
        return ZERO, ZERO, ZERO, ZERO, ZERO, ZERO
    if at.rough[3] == TRANSLUCENT_ROUND:
        scale = cosine * INV_PI
        r, g, b = at.diffuse[0] * scale, at.diffuse[1] * scale, at.diffuse[2] * scale
        return r, g, b, ZERO, ZERO, ZERO
    if at.rough[3] == CHIANG:
        r, g, b = eval_chiang(hair, wi_x, wi_y, wi_z)
    else:
        r = g = b = eval_bells(at, wi_x, wi_y, wi_z)
    return ZERO, ZERO, ZERO, r * at.diffuse[0], g * at.diffuse[1], b * at.diffuse[2]


@kernel
def eval_hair(at, wi_x, wi_y, wi_z):
    """The same of one direction alone, on the point's side."""
    if dot_xyz(at.normal, wi_x, wi_y, wi_z) <= ZERO:
        return ZERO, ZERO, ZERO, ZERO, ZERO, ZERO
    return eval_strand(at, chiang_at(at, ZERO), wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def ray_start(at, position, wi_x, wi_y, wi_z):
    """Where a ray from a strand's place starts, outside of the strand: (x, y, z), world space.

    position: a triple, the point's
    """
    radius, reach, slope = at.dielectric_f0
    side = side_of(at)
    way = reach - side * radius  # of the point from its place on the strand, along its own normal
    nx, ny, nz = at.normal
    along = dot_xyz(at.tangent, wi_x, wi_y, wi_z)
    wider = slope * along
    # |radius n + t wi| across the strand = reach + t wider
    a = max(ONE - along * along - wider * wider, _ACROSS2)
    b = side * radius * (nx * wi_x + ny * wi_y + nz * wi_z) - reach * wider
    t = (math.sqrt(b * b + a * (reach * reach - radius * radius)) - b) / a
    return (
        position[0] - way * nx + t * wi_x,
        position[1] - way * ny + t * wi_y,
        position[2] - way * nz + t * wi_z,
    )

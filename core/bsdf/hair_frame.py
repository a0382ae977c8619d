"""A strand of hair at a shading point: its frame, and the Hair BSDF, which needs no more.

That is a product of two bell curves, along the strand and round it [Marschner03]. As in Cycles its
samples are not quite as its values: light from where only the samples fall, or only the values are
above 0, counts there by the weights of multiple importance sampling, and here not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .lambert_kinds import HAIR_REFLECTION
from .microfacet import HALF, ONE, PI, QUARTER, TWO, ZERO, basis, cross, dot_xyz

_TINY = np.float32(1e-12)
_LEAST_COSINE = np.float32(1e-3)  # what goes along the strand is left out


class Frame(NamedTuple):
    """A strand as seen: unit triples along it, towards the viewer at right angles to it, and across
    both; sine and cosine of the angle between wo and the plane at right angles."""

    along: tuple
    toward: tuple
    across: tuple
    sin_o: np.float32
    cos_o: np.float32


@kernel(forceinline=True)
def cosine_of(sine):
    return math.sqrt(max(ONE - sine * sine, ZERO))


@kernel(forceinline=True)
def frame_at(tangent, wo):
    """The Frame of a strand along ``tangent``, unit triples."""
    sin_o = min(max(dot_xyz(tangent, wo[0], wo[1], wo[2]), -ONE), ONE)
    x, y, z = wo[0] - sin_o * tangent[0], wo[1] - sin_o * tangent[1], wo[2] - sin_o * tangent[2]
    length2 = x * x + y * y + z * z
    if length2 > _TINY:
        scale = ONE / math.sqrt(length2)
        toward = (x * scale, y * scale, z * scale)
    else:
        toward, _ = basis(tangent)
    return Frame(tangent, toward, cross(tangent, toward), sin_o, cosine_of(sin_o))


@kernel(forceinline=True)
def angles_of(frame, wi_x, wi_y, wi_z):
    """Sine of wi's angle to the plane across the strand, and its angle round it from wo's."""
    along, toward, across = frame.along, frame.toward, frame.across
    x, y = dot_xyz(toward, wi_x, wi_y, wi_z), dot_xyz(across, wi_x, wi_y, wi_z)
    return min(max(dot_xyz(along, wi_x, wi_y, wi_z), -ONE), ONE), math.atan2(y, x)


@kernel(forceinline=True)
def bell_along(at, frame, sin_i, cos_i):
    """The Hair BSDF's curve along the strand."""
    if cos_i < _LEAST_COSINE:
        return ZERO
    width, offset = at.rough[0], at.rough[2]
    half, theta_o = QUARTER * PI, HALF * math.asin(frame.sin_o)
    high = math.atan((theta_o + half - offset) / width)
    low = math.atan((theta_o - half - offset) / width)
    t = HALF * math.asin(sin_i) + theta_o - offset
    return width / (TWO * (t * t + width * width) * (high - low) * cos_i)


@kernel(forceinline=True)
def bell_round(at, phi):
    """The one round the strand, 0 in the half where samples of Cycles' do not fall either."""
    width, phi = at.rough[1], abs(phi)
    if (phi > HALF * PI) == (at.rough[3] == HAIR_REFLECTION):
        return ZERO
    if at.rough[3] == HAIR_REFLECTION:
        return math.cos(HALF * min(phi / width, PI)) * QUARTER / width
    whole = TWO * math.atan(HALF * PI / width)
    return width / (whole * ((PI - phi) * (PI - phi) + width * width))


@kernel
def eval_bells(at, wi_x, wi_y, wi_z):
    """The Hair BSDF x cosine from wi, sr^-1, without the factor of all."""
    frame = frame_at(at.tangent, at.wo)
    sin_i, phi = angles_of(frame, wi_x, wi_y, wi_z)
    return bell_along(at, frame, sin_i, cosine_of(sin_i)) * bell_round(at, phi)

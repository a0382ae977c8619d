"""What a normal that a map has turned reflects (Cycles' bump shadowing)."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.bump import bump_gain, turns
from iwis.core.data.lamps import SUN, make_lamps
from iwis.core.lamplight.lamp_light import COLUMNS, LampSamples, add_lamp_light
from support.lamp_points import seen_point
from support.scenes import glossy


class _At(NamedTuple):
    smooth: tuple
    bump: np.float32


@kernel
def _gains(at, directions, out):
    for k in range(len(directions)):
        wi = directions[k]
        out[k] = bump_gain(at, wi[0], wi[1], wi[2])


def _at_elevations(degrees, turned_by):
    """Gains of light from elevations over a surface whose normal is turned by an angle."""
    up = (np.float32(0.0), np.float32(0.0), np.float32(1.0))
    turn = math.radians(turned_by)
    normal = np.float32([[math.sin(turn), 0.0, math.cos(turn)]])
    angle = np.radians(degrees)
    directions = np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], -1).astype(np.float32)
    out = np.zeros(len(degrees), np.float32)
    _gains(_At(up, turns(np.float32([up]), normal)[0]), directions, out)
    return out


def test_no_matte_light_comes_from_below_the_smooth_surface():
    gains = _at_elevations(np.array([-80.0, -1.0]), 30.0)
    assert (gains == 0.0).all()


def test_grazing_light_is_shadowed():
    """G1 of GGX for alpha^2 = tan^2(turn) / 8."""
    gains = _at_elevations(np.array([5.0, 30.0, 90.0]), 45.0)
    tangent2 = 1.0 / np.tan(np.radians([5.0, 30.0, 90.0])) ** 2
    expected = 2.0 / (1.0 + np.sqrt(1.0 + 0.125 * tangent2))
    assert gains == pytest.approx(expected, abs=1e-5)
    assert gains[0] < 0.4 < gains[1]


def test_small_turns_change_nothing():
    gains = _at_elevations(np.array([10.0, 60.0]), 0.5)
    assert gains == pytest.approx(1.0, abs=1e-3)


def _gloss_of_sun(smooth):
    """What a sun brings to gloss of a floor that is smooth with the normals ``smooth``."""
    points, lobes, accel = seen_point(glossy(0.4, (1.0, 1.0, 1.0)))
    own = np.float32([smooth]) / np.float32(np.linalg.norm(smooth))
    lobes = lobes._replace(smooth=own, bump=turns(own, lobes.normal))
    sun = {"kind": SUN, "size": (0.004, 0.0), "forward": (-0.8, 0.0, -0.6), "radiance": (1, 1, 1)}
    sums, row = np.zeros((1, COLUMNS)), np.zeros(1, np.int64)
    samples = LampSamples(row, row, row, 7)
    add_lamp_light(points, lobes, make_lamps([sun]), accel, samples, sums)
    return sums[0, 3:6].sum()


def test_gloss_has_no_lamp_below_the_smooth_surface():
    """The sun is above the face and the turned normal, 4 degrees above or below the surface."""
    assert _gloss_of_sun((-0.538, 0.0, 0.843)) > 0.0
    assert _gloss_of_sun((-0.656, 0.0, 0.755)) == 0.0

"""What a normal that a map has turned reflects (Cycles' bump shadowing)."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.bump import bump_gain, turns


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

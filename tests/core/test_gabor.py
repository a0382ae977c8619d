"""Gabor noise (gabor.py); its values beside Cycles' are in parity/texture_cases.py."""

import numpy as np
import pytest

from iwis.core.textures.gabor import IMPULSES, gabor_2d, gabor_3d

N = 4000


def _sums(dimensions, places, frequency=2.0, isotropy=0.0, direction=(1.0, 0.0, 0.0)):
    n = places.shape[1]
    out = np.empty((2, n), np.float32)
    room = np.empty((4, IMPULSES), np.float32), out
    frequency, isotropy = (np.full(n, value, np.float32) for value in (frequency, isotropy))
    if dimensions == 2:
        angle = np.full(n, np.arctan2(direction[1], direction[0]), np.float32)
        gabor_2d(places[0], places[1], frequency, isotropy, angle, *room)
    else:
        axis = np.tile(np.float32(direction)[:, None], (1, n))
        gabor_3d(places, frequency, isotropy, np.ascontiguousarray(axis), *room)
    return out


def _places(rng, size=40.0):
    return (rng.random((3, N), np.float32) - np.float32(0.5)) * np.float32(size)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("isotropy", [0.0, 0.7])
def test_mean_and_spread(dimensions, isotropy):
    """The mean is 0 and six standard deviations are about 1 [Lagae09, eq. 9]: the window takes some
    of the spread that this formula has."""
    for part in _sums(dimensions, _places(np.random.default_rng(1)), isotropy=isotropy):
        assert abs(part.mean()) < 0.02
        assert 0.1 < part.std() < 0.25


@pytest.mark.parametrize("dimensions", [2, 3])
def test_it_is_smooth_across_cells(dimensions):
    """Cells that are skipped bring nothing: there is no step where a cell, or its reach, ends."""
    step = np.float32(2e-3)
    near = np.round(_places(np.random.default_rng(2)))
    for axis in range(dimensions):
        places = near + np.float32([[0.37], [0.61], [0.18]])
        places[axis] = near[axis]
        before, after = places.copy(), places.copy()
        before[axis] -= step
        after[axis] += step
        change = np.abs(_sums(dimensions, after) - _sums(dimensions, before))
        assert change.max() < 2.0 * step * 2.0 * np.pi * 2.0  # waves of 2 a cell, up to 1 high


@pytest.mark.parametrize("dimensions", [2, 3])
def test_waves_go_along_their_direction(dimensions):
    """Across it they change more slowly: by the bell alone."""
    places = _places(np.random.default_rng(3))
    change = []
    for axis in (0, 1):
        moved = places.copy()
        moved[axis] += np.float32(0.25 / 4.0)
        difference = _sums(dimensions, moved, 4.0) - _sums(dimensions, places, 4.0)
        change.append(np.sqrt((difference**2).mean()))
    assert change[0] > 3.0 * change[1]


def test_phase_grows_evenly_along_a_wave():
    """cosine and sine turn together: 2 pi for each wave, where the amplitude is not 0."""
    places = _places(np.random.default_rng(4))
    moved = places.copy()
    moved[0] += np.float32(0.01)
    (c, s), (d, t) = _sums(2, places, 3.0), _sums(2, moved, 3.0)
    turned = np.angle((d + 1j * t) / (c + 1j * s))
    strong = np.hypot(c, s) > 0.1
    np.testing.assert_allclose(np.median(turned[strong]), 2.0 * np.pi * 3.0 * 0.01, rtol=0.05)

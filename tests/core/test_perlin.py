"""core/textures/perlin.py: the noise of Blender's textures, against the same formulas in NumPy."""

import itertools

import numpy as np
import pytest

from iwis.core.nodes.hashing import hash_words
from iwis.core.nodes.noise import perlin

DIMENSIONS = (1, 2, 3, 4)
SCALE = {1: 0.25, 2: 0.6616, 3: 0.9820, 4: 0.8344}
# What sums of 2 to 16 products of float32 numbers of some 3 may differ by, in another order.
ROUNDING = 4e-6


def _signed(value, bit):
    return np.where(bit != 0, -value, value)


def _gradient(h, p):
    """The gradient that a hash chooses, times the way from its corner. p: d arrays"""
    if len(p) == 1:
        return _signed((1 + (h & 7)).astype(float), h & 8) * p[0]
    if len(p) == 2:
        near = (h & 7) < 4
        u, v = np.where(near, p[0], p[1]), 2.0 * np.where(near, p[1], p[0])
        return _signed(u, h & 1) + _signed(v, h & 2)
    if len(p) == 3:
        h, (x, y, z) = h & 15, p
        u = np.where(h < 8, x, y)
        v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
        return _signed(u, h & 1) + _signed(v, h & 2)
    h, (x, y, z, w) = h & 31, p
    u, v, s = np.where(h < 24, x, y), np.where(h < 16, y, z), np.where(h < 8, z, w)
    return _signed(u, h & 1) + _signed(v, h & 2) + _signed(s, h & 4)


def _expected(p):
    """Noise at p, float (d, n), a corner after another."""
    d, cell = len(p), np.floor(p)
    way = p.astype(np.float64) - cell
    fade = way**3 * (way * (way * 6.0 - 15.0) + 10.0)
    total = np.zeros(p.shape[1])
    for corner in itertools.product((0, 1), repeat=d):
        words = [(cell[k].astype(np.int64) + corner[k]).astype(np.uint32) for k in range(d)]
        ways = [way[k] - corner[k] for k in range(d)]
        weights = [fade[k] if corner[k] else 1.0 - fade[k] for k in range(d)]
        total += np.prod(weights, axis=0) * _gradient(hash_words(*words), ways)
    return total * SCALE[d]


@pytest.mark.parametrize("d", DIMENSIONS)
def test_it_is_the_sum_over_the_corners_of_a_cell(d, rng):
    p = rng.uniform(-300.0, 300.0, (d, 5000)).astype(np.float32)
    np.testing.assert_allclose(perlin(p), _expected(p), atol=ROUNDING)


@pytest.mark.parametrize("d", DIMENSIONS)
def test_it_goes_through_all_its_range_and_no_farther(d, rng):
    value = perlin(rng.uniform(-50.0, 50.0, (d, 20_000)).astype(np.float32))
    assert np.abs(value).max() <= 1.0
    assert value.std() > 0.15


@pytest.mark.parametrize("d", DIMENSIONS)
def test_whole_numbers_have_none(d, rng):
    p = rng.integers(-1000, 1000, (d, 500)).astype(np.float32)
    np.testing.assert_array_equal(perlin(p), 0.0)


@pytest.mark.parametrize("far", [1e5, -3e6, 1e20, np.inf, -np.inf, np.nan])
def test_far_away_and_nowhere_it_is_a_number(far):
    p = np.float32([[0.3, far], [0.2, 0.2], [0.6, far]])
    value = perlin(p)
    assert np.isfinite(value).all()
    assert np.abs(value).max() <= 1.0
    np.testing.assert_allclose(value[:1], _expected(p[:, :1]), atol=ROUNDING)

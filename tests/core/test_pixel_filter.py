"""core/camera/pixel_filter.py: where the shading points of a pixel lie."""

import numpy as np
import pytest

from iwis.core.camera.pixel_filter import filter_offsets, unit_points
from iwis.core.unit_square.halton import hash_pixel


def _points(count, columns, rows, seed=0):
    """float64 (count, n, 2): the first points of each pixel."""
    columns, rows = np.asarray(columns), np.asarray(rows)
    return np.stack([unit_points(columns, rows, k, seed) for k in range(count)])


@pytest.mark.parametrize("exponent", [1, 2, 4, 6])
def test_first_points_are_a_net(exponent):
    """Of the first 2^m points each box of area 2^-m holds one, whatever its shape."""
    points = _points(1 << exponent, np.arange(50), 7 * np.arange(50), seed=3)
    assert (points >= 0.0).all() and (points < 1.0).all()
    for a in range(exponent + 1):
        columns, rows = 1 << a, 1 << (exponent - a)
        box = (points[..., 0] * columns).astype(int) * rows + (points[..., 1] * rows).astype(int)
        assert (np.sort(box, axis=0) == np.arange(1 << exponent)[:, None]).all()


def test_points_are_a_pixels_own():
    """Other pixels, other seeds, other points; the same pixel and seed, the same."""
    columns, rows = np.mgrid[:20, :20].reshape(2, -1)
    points = _points(1, columns, rows)[0]
    assert len(np.unique(points, axis=0)) == 400
    np.testing.assert_array_equal(points[21:22], unit_points(columns[21:22], rows[21:22], 0, 0))
    assert (points != unit_points(columns, rows, 0, 1)).all()


def test_points_of_a_pixel_do_not_depend_on_those_before():
    """A pixel whose points follow each other, one that comes again, one between them."""
    columns, rows = np.array([3, 3, 3, 4, 3, 3, 4]), np.array([5, 5, 6, 6, 5, 5, 6])
    number = np.array([0, 1, 0, 7, 2, 0, 7])
    together = unit_points(columns, rows, number, 1)
    for k, point in enumerate(together):
        alone = unit_points(columns[k : k + 1], rows[k : k + 1], number[k : k + 1], 1)
        np.testing.assert_array_equal(alone[0], point)
    assert unit_points(columns[:0], rows[:0], 0, 1).shape == (0, 2)


@pytest.mark.statistical
def test_points_are_apart_from_those_of_light():
    """No correlation with the shifts of the light's points, in any pass. alpha = 1e-3, Sidak."""
    columns, rows = np.mgrid[:100, :100].reshape(2, -1)
    shifts = [
        [hash_pixel(x, y, 0, salt) for salt in (1, 2)] for x, y in zip(columns, rows, strict=True)
    ]
    for points in _points(4, columns, rows):
        correlation = np.corrcoef(np.concatenate([points, shifts], 1).T)[:2, 2:]
        # 16 correlations of 10^4 pairs: standard deviation .01, 4.0 of them
        assert np.abs(correlation).max() < 0.04


def _window(v):
    """The Blackman-Harris window on -1 ... 1."""
    angle = np.pi * (v + 1.0)
    terms = 0.35875, -0.48829, 0.14128, -0.01168
    return sum(a * np.cos(k * angle) for k, a in enumerate(terms))


@pytest.mark.parametrize("width", [0.01, 1.5, 10.0])
def test_blackman_harris_reaches_its_width(width):
    """The share of offsets below a place is the window's integral up to it."""
    u = (np.arange(100_000) + 0.5) / 100_000
    offsets = filter_offsets("BLACKMAN_HARRIS", width, np.stack([u, u[::-1]], -1)) / width
    place = np.linspace(-1.0, 1.0, 20_001)
    below = np.cumsum(_window(place)) / _window(place).sum()
    for axis in range(2):
        found = np.searchsorted(np.sort(offsets[:, axis]), place) / len(u)
        np.testing.assert_allclose(found, below, atol=2e-4)  # sums of 20 001 terms
    assert 0.95 < np.abs(offsets).max() <= 1.0
    np.testing.assert_allclose(offsets[::-1], -offsets, atol=1e-9)


@pytest.mark.parametrize("width", [0.01, 1.5, 10.0])
def test_gaussian_has_four_deviations_to_its_width(width):
    """Shares of places as the normal distribution has them; the last at six deviations."""
    u = (np.arange(100_000) + 0.5) / 100_000
    offsets = filter_offsets("GAUSSIAN", width, np.stack([u, u[::-1]], -1)) * (4.0 / width)
    for axis in range(2):
        assert offsets[:, axis].std() == pytest.approx(1.0, abs=1e-3)
        for place, share in ((-2.0, 0.02275), (-1.0, 0.15866), (0.5, 0.69146), (3.0, 0.99865)):
            assert (offsets[:, axis] < place).mean() == pytest.approx(share, abs=2e-5)
    ends = filter_offsets("GAUSSIAN", width, np.array([[0.0, 1.0 - 2.0**-32]])) * (4.0 / width)
    assert ends[0, 0] == pytest.approx(-6.0) and 5.0 < ends[0, 1] <= 6.0
    np.testing.assert_allclose(offsets[::-1], -offsets, atol=1e-6)


def test_box_is_a_pixel_wide_and_center_has_no_width():
    """As in Cycles, whatever the width."""
    points = _points(16, [3], [4])[:, 0]
    np.testing.assert_array_equal(filter_offsets("BOX", 4.0, points), points - 0.5)
    assert not filter_offsets("CENTER", 4.0, points).any()

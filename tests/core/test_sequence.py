"""core/unit_square/sequence.py: each pixel's own low-discrepancy points."""

import numpy as np
import pytest

from iwis.core.settings import RenderSettings
from iwis.core.unit_square.sequence import common_points, pixel_sequence, sequence_point
from support.naive import radical_inverse
from support.samplers import pixel_points, plain_sequence, random_sequence
from support.scenes import varied_scene


def _points(sequence, p, count):
    return np.array([sequence_point(sequence, p, k) for k in range(count)])


def _is_net(points, m):
    """Whether 2^m points stand one in each elementary interval of volume 2^-m: a (0, m, 2)-net."""
    for across in range(m + 1):
        cell = np.floor(points * (1 << across, 1 << (m - across))).astype(int)
        if len(np.unique(cell, axis=0)) != 1 << m:
            return False
    return True


def test_scrambled_points_are_nets_in_every_pixel(rng):
    """Every beginning of 2^m points, m up to 8; the twin, Halton's points, is none."""
    scrambled = random_sequence(rng, 8, 256, "OWEN")
    for p in range(8):
        points = _points(scrambled, p, 256)
        assert all(_is_net(points[: 1 << m], m) for m in range(1, 9))
    assert not _is_net(_points(plain_sequence(1, 256), 0, 256), 8)


@pytest.mark.statistical
def test_scrambled_points_are_uniform_and_pixels_independent(rng):
    """The k-th points of 20000 pixels fill the square; so do pairs of neighbours' points.

    Five standard deviations of a mean and of a correlation.
    """
    n = 20000
    pixel = np.arange(n, dtype=np.int32)
    sequence = pixel_sequence(common_points(8, "OWEN"), pixel, (0, 0, 200), 3, "OWEN")
    for k in (0, 1, 7):
        points = np.array([sequence_point(sequence, p, k) for p in range(n)])
        assert np.abs(points.mean(0) - 0.5).max() < 5.0 / np.sqrt(12.0 * n)
        assert abs(np.corrcoef(points[:, 0], points[:, 1])[0, 1]) < 5.0 / np.sqrt(n)
        assert abs(np.corrcoef(points[:-1, 0], points[1:, 0])[0, 1]) < 5.0 / np.sqrt(n)


def test_halton_points_are_haltons():
    """Index 1 first, bases 2 and 3, as 32-bit fractions."""
    points = _points(plain_sequence(1, 20), 0, 20)
    expected = [[radical_inverse(k + 1, 2), radical_inverse(k + 1, 3)] for k in range(20)]
    np.testing.assert_allclose(points, expected, atol=2.0**-32)


def test_shifts_move_points_on_the_torus(rng):
    """A pixel's points are the common ones plus its shift, modulo 1."""
    sequence = random_sequence(rng, 3, 16, "PIXEL")
    plain = _points(plain_sequence(1, 16), 0, 16)
    for p in range(3):
        shift = np.array([sequence.x[p], sequence.y[p]]) / 2.0**32
        away = np.abs(_points(sequence, p, 16) - (plain + shift) % 1.0)
        assert np.minimum(away, 1.0 - away).max() < 1e-9


@pytest.mark.parametrize("kind", ["OWEN", "PIXEL"])
def test_sequences_belong_to_pixels_not_to_tiles(kind):
    """The same pixel of the frame, in another tile: the same points; other pixels, others."""
    whole = pixel_points(varied_scene()).points.pixel
    points = common_points(4, kind)
    sequence = pixel_sequence(points, whole, (0, 0, 40), 7, kind)
    part = pixel_points(varied_scene(region=(10, 6, 30, 20))).points.pixel
    moved = pixel_sequence(points, part, (10, 6, 20), 7, kind)
    where = np.searchsorted(whole, (6 + part // 20) * 40 + 10 + part % 20)
    np.testing.assert_array_equal(moved.x, sequence.x[where])
    np.testing.assert_array_equal(moved.y, sequence.y[where])
    assert len(np.unique(sequence.x)) > 0.99 * len(whole)
    assert not np.array_equal(pixel_sequence(points, whole, (0, 0, 40), 8, kind).x, sequence.x)
    none = pixel_sequence(points, whole, (0, 0, 40), 7, "NONE")
    assert not none.x.any() and not none.y.any()


@pytest.mark.parametrize("kind", ["OWEN", "PIXEL"])
def test_a_larger_count_begins_with_the_same_points(kind):
    """Samples taken once stay good when MAX is raised."""
    np.testing.assert_array_equal(common_points(100, kind)[:24], common_points(24, kind))


def test_the_papers_estimator_keeps_haltons_points():
    """OWEN is for UNBIASED; what was chosen by name is used."""
    assert RenderSettings().point_set == "OWEN"
    assert RenderSettings(estimator="PAPER").point_set == "PIXEL"
    assert RenderSettings(estimator="PAPER", decorrelation="NONE").point_set == "NONE"

"""Metals by their indices (core/nodes/metals.py)."""

import numpy as np
import pytest

from iwis.core.nodes.metals import approximated, conductor, reflectance

COSINES = np.linspace(0.001, 1.0, 2000)[:, None]
METALS = {
    "iron": ((2.757, 2.513, 2.231), (3.867, 3.404, 3.009)),
    "gold": ((0.14, 0.37, 1.44), (3.97, 2.5, 1.9)),
    "silver": ((0.05, 0.06, 0.05), (4.2, 3.5, 2.6)),
    "tungsten": ((3.6, 3.5, 3.3), (2.9, 2.7, 2.5)),
}


def _nearest(n, k, **settings):
    return conductor(None, settings, {"IOR": np.float32(n), "Extinction": np.float32(k)})


def _f82(found):
    """The curve of Cycles' Metallic BSDF."""
    base, tint = found["Base Color"], found["Edge Tint"]
    edge = (base + (1.0 - base) * (6.0 / 7.0) ** 5) * 7.0 / (6.0 / 7.0) ** 6 * (1.0 - tint)
    return base + (1.0 - base) * (1.0 - COSINES) ** 5 - edge * COSINES * (1.0 - COSINES) ** 6


@pytest.mark.parametrize("curve", [reflectance, approximated])
@pytest.mark.parametrize("metal", METALS)
def test_light_of_all_directions_is_the_metals(metal, curve):
    """Weighted by the cosine, as a matte surround lights: within .1 %; no angle more than 5 % off,
    and none of the inner ones, below 80 degrees, more than 2."""
    n, k = METALS[metal]
    found = _nearest(n, k, approximated=curve is approximated)
    error = _f82(found) - curve(COSINES, np.array(n), np.array(k))
    whole = (COSINES * curve(COSINES, np.array(n), np.array(k))).mean(0)
    assert np.abs((COSINES * error).mean(0) / whole).max() < 1e-3
    assert np.abs(error).max() < 0.05
    assert np.abs(error[COSINES[:, 0] > 0.17]).max() < 0.02


def test_reflectance_along_the_normal():
    """((n - 1)^2 + k^2) / ((n + 1)^2 + k^2), and all of it at grazing angles."""
    n, k = np.array([0.2, 1.5, 3.0]), np.array([3.0, 0.0, 2.0])
    expected = ((n - 1.0) ** 2 + k**2) / ((n + 1.0) ** 2 + k**2)
    np.testing.assert_allclose(reflectance(1.0, n, k), expected, rtol=1e-12)
    np.testing.assert_allclose(reflectance(1e-6, n, k), 1.0, atol=1e-4)


def test_the_approximation_is_right_along_the_normal_and_else_brighter():
    n, k = np.array([1.5, 3.0]), np.array([0.1, 2.0])
    np.testing.assert_allclose(approximated(1.0, n, k), reflectance(1.0, n, k), rtol=1e-12)
    more = approximated(COSINES[:-1], n, k) - reflectance(COSINES[:-1], n, k)
    assert more.min() > 0.0 and more[:, 0].max() > 0.09 > 0.02 > more[:, 1].max()


def test_points_are_fitted_one_by_one():
    """As they are alone; one index may be the same for all."""
    n = np.float32([METALS[metal][0] for metal in METALS])
    k = np.float32([3.0, 2.5, 2.0])
    found = _nearest(n, k)
    for row in range(len(n)):
        alone = _nearest(n[row], k)
        assert alone["Base Color"].shape == (3,)
        for name in found:
            np.testing.assert_allclose(found[name][row], alone[name], rtol=1e-6)


@pytest.mark.parametrize("value", [0.0, -1.0, 1e6])
def test_absurd_indices_give_numbers(value):
    found = _nearest((value,) * 3, (value,) * 3)
    assert all(
        np.isfinite(a).all() and (a >= 0.0).all() and (a <= 1.0).all() for a in found.values()
    )

"""core/wavelets/haar.py: the transform is the orthonormal one, there and back."""

import numpy as np
import pytest

from iwis.core.wavelets.haar import forward, inverse, truncated
from support.naive import haar_basis


@pytest.mark.parametrize("side", [1, 2, 4, 16, 64])
def test_round_trip_gives_the_grid_back(side, rng):
    """inverse(forward(grid)) = grid, and the grid given is left as it was."""
    grid = rng.standard_normal((side, side)).astype(np.float32)
    before = grid.copy()
    np.testing.assert_allclose(inverse(forward(grid)), grid, atol=4e-6)  # float32, 2 x 6 levels
    np.testing.assert_array_equal(grid, before)


def test_forward_equals_scalar_products_with_the_basis(rng):
    """Coefficient k is the mean of grid x basis function k."""
    grid = rng.random((16, 16), np.float32)
    expected = haar_basis(16) @ grid.ravel().astype(np.float64) / 256
    np.testing.assert_allclose(forward(grid), expected, atol=3e-7)  # float32, sums of 256


def test_the_basis_is_orthonormal():
    """What Parseval and the choice of the largest coefficients rest on."""
    basis = haar_basis(8)
    np.testing.assert_allclose(basis @ basis.T / 64, np.eye(64), atol=1e-14)


def test_inverse_of_one_coefficient_is_its_basis_function():
    """Signs, order and scale of every detail, as the docstring says."""
    for k, function in enumerate(haar_basis(8)):
        unit = np.zeros(64, np.float32)
        unit[k] = 1.0
        np.testing.assert_array_equal(inverse(unit).ravel(), function)


def test_energy_is_kept(rng):
    """Parseval: the squares of the coefficients add up to the mean square."""
    grid = rng.standard_normal((64, 64)).astype(np.float32)
    energy = (forward(grid).astype(np.float64) ** 2).sum()
    assert energy == pytest.approx((grid.astype(np.float64) ** 2).mean(), rel=1e-6)  # float32


def test_truncated_keeps_the_mean_and_the_largest(rng):
    """Exactly the share asked for, never a smaller one before a larger one."""
    coefficients = forward(rng.standard_normal((16, 16)).astype(np.float32))
    coefficients[0] = 1e-9  # the mean stays, small as it is
    kept = truncated(coefficients, 0.1)
    chosen = kept != 0.0
    assert chosen.sum() == round(0.1 * 256) and chosen[0]
    np.testing.assert_array_equal(kept[chosen], coefficients[chosen])
    assert np.abs(coefficients[1:][chosen[1:]]).min() >= np.abs(coefficients[~chosen]).max()


def test_truncated_at_one_is_everything(rng):
    """And however small the fraction, the mean."""
    coefficients = rng.standard_normal(64).astype(np.float32)
    np.testing.assert_array_equal(truncated(coefficients, 1.0), coefficients)
    assert truncated(coefficients, 1e-6).nonzero()[0].tolist() == [0]


@pytest.mark.parametrize("shape", [(4, 8), (6, 6), (3, 3)])
def test_other_shapes_are_refused(shape):
    """Only 2^n x 2^n has this series."""
    with pytest.raises(ValueError, match=r"2\^n x 2\^n"):
        forward(np.zeros(shape, np.float32))

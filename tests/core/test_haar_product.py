"""haar_product.py: the product of two sparse series equals the product of their grids."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.wavelets.haar_forest import build_forest
from iwis.core.wavelets.haar_product import (
    MAX_COMMON,
    ProductTrees,
    build_product_tree,
    count_common,
    new_scratch,
    product_integral,
    warp_tree,
)
from support.naive import forest_grid, warp_grid
from support.statistics import chi2_p_value, sidak

WEIGHTS = np.float32([0.2126, 0.7152, 0.0722])


@kernel
def _warp_many(light, brdf, weights, trees, root, points, out):
    for k in range(len(points)):
        out[k, 0], out[k, 1], out[k, 2] = warp_tree(
            light, brdf, weights, trees, root, points[k, 0], points[k, 1]
        )


class _Product:
    """The product of two forests of one slice, and both grids."""

    def __init__(self, light_grid, brdf_grid, fraction):
        side = brdf_grid.shape[0]
        self.light = build_forest(light_grid[None].astype(np.float32), fraction)
        self.brdf = build_forest(brdf_grid[None, None].astype(np.float32), fraction)
        self.dense_light = np.stack([forest_grid(self.light, 0, c, side) for c in range(3)])
        self.dense_brdf = forest_grid(self.brdf, 0, 0, side)
        weights = WEIGHTS.astype(np.float64)
        self.weighted = np.tensordot(weights, self.dense_light, 1) * self.dense_brdf
        size = count_common(self.light, 0, self.brdf, 0, new_scratch())
        self.trees = ProductTrees(
            np.full((size, 4), np.nan, np.float32), np.zeros((size, 4), np.int32)
        )
        self.root, self.end = build_product_tree(
            self.light, 0, self.brdf, 0, WEIGHTS, new_scratch(), self.trees, 0
        )

    def integral(self):
        out = np.zeros(3, np.float32)
        product_integral(self.light, 0, self.brdf, 0, np.empty((2, MAX_COMMON), np.int32), out)
        return out

    def warp(self, points):
        out = np.empty((len(points), 3))
        _warp_many(self.light, self.brdf, WEIGHTS, self.trees, self.root, points, out)
        return out


def _smooth(rng, side, n):
    """n grids >= 0 of some bumps, as lobes and lights are."""
    y, x = np.mgrid[:side, :side] / side
    grids = np.zeros((n, side, side))
    for grid in grids:
        for _ in range(4):
            cx, cy, width = *rng.random(2), 0.05 + 0.2 * rng.random()
            grid += rng.random() * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * width**2))
    return grids


CASES = [(side, fraction) for side in (8, 64) for fraction in (1.0, 0.2, 0.03)]


@pytest.mark.parametrize(("side", "fraction"), CASES)
def test_integral_equals_the_dense_products(side, fraction, rng):
    """Full and truncated series alike, per channel, to 1e-6 of both factors' root mean squares.

    (What rounding in a scalar product is measured by: normal random factors cancel to about 0.)
    """
    for make in (lambda n: _smooth(rng, side, n), lambda n: rng.standard_normal((n, side, side))):
        product = _Product(make(3), make(1)[0], fraction)
        light, brdf = product.dense_light, product.dense_brdf
        scale = np.sqrt((light**2).mean((1, 2)) * (brdf**2).mean())
        error = product.integral() - (light * brdf).mean((1, 2))
        assert (np.abs(error) <= 1e-6 * scale).all()


@pytest.mark.parametrize(("side", "fraction"), CASES)
def test_weights_equal_the_dense_means_of_every_quadrant(side, fraction, rng):
    """All nodes of the tree: the product's mean over each quadrant, not below 0, to 1e-6."""
    product = _Product(_smooth(rng, side, 3), _smooth(rng, side, 1)[0], fraction)
    assert product.root == 0 and product.end == len(product.trees.weight) > 0
    todo, seen = [(0, 0, 0, 0)], 0
    while todo:
        node, level, i, j = todo.pop()
        seen += 1
        size = side >> (level + 1)
        for q in range(4):
            row, column = 2 * i + q // 2, 2 * j + q % 2
            square = product.weighted[row * size : (row + 1) * size, column * size :][:, :size]
            expected = max(square.mean(), 0.0)
            # float32: up to 4095 products are added below the root
            tolerance = 1e-6 * product.weighted.max()
            assert product.trees.weight[node, q] == pytest.approx(expected, abs=tolerance)
            if product.trees.child[node, q] >= 0:
                todo.append((int(product.trees.child[node, q]), level + 1, row, column))
    assert seen == product.end


@pytest.mark.parametrize("fraction", [1.0, 0.05])
def test_density_equals_the_dense_product_everywhere(fraction, rng):
    """Points in all cells: the warp's density is the cell's product over the mean, as printed.

    Smooth grids plus a floor, so that no square's mean is negative and nothing is cut.
    """
    side = 16
    light, brdf = 0.3 + _smooth(rng, side, 3), 0.3 + _smooth(rng, side, 1)[0]
    product = _Product(light, brdf, fraction)
    assert product.weighted.min() > 0.0
    x, y, density = product.warp(rng.random((4000, 2))).T
    row, column = (y * side).astype(int), (x * side).astype(int)
    expected = product.weighted[row, column] / product.weighted.mean()
    np.testing.assert_allclose(density, expected, rtol=1e-5)  # float32 weights, a ratio a level
    visited = np.zeros((side, side))
    visited[row, column] = 1.0
    assert visited.mean() > 0.9


def test_warp_equals_its_naive_twin(rng):
    """The same point, not only the same density: rows before columns, at every level."""
    product = _Product(0.3 + _smooth(rng, 16, 3), 0.3 + _smooth(rng, 16, 1)[0], 1.0)
    points = rng.random((300, 2))
    expected = np.array([warp_grid(product.weighted, x, y) for x, y in points])
    # float32 weights: shares are off by 1e-7, stretched by up to 1 / share a level
    np.testing.assert_allclose(product.warp(points), expected, rtol=2e-5, atol=2e-5)


def test_densities_are_normalised_however_series_ring(rng):
    """The densities of all cells that points reach, times their areas, add up to 1.

    Truncated spikes go negative in places; those squares count as 0 and get no point.
    """
    side, n = 16, 200_000
    product = _Product(_smooth(rng, side, 3), rng.random((side, side)) ** 8, 0.2)
    assert product.weighted.min() < 0.0
    x, y, density = product.warp(rng.random((n, 2))).T
    assert (density > 0.0).all()
    cell = (y * side).astype(int) * side + (x * side).astype(int)
    _, first = np.unique(cell, return_index=True)
    # Cells that n points miss hold 256 p (1 - p)^n < 256 / (e n) = 5e-4 of them on average.
    assert density[first].sum() / side**2 == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("constant", ["light", "brdf", "both"])
def test_constant_factors(constant, rng):
    """A factor without details: the product is the other one, or the square itself."""
    side = 8
    light, brdf = 0.3 + _smooth(rng, side, 3), 0.3 + _smooth(rng, side, 1)[0]
    if constant != "brdf":
        light = np.ones((3, side, side)) * [[[0.5]], [[1.0]], [[2.0]]]
    if constant != "light":
        brdf = np.full((side, side), 0.7)
    product = _Product(light, brdf, 1.0)
    np.testing.assert_allclose(product.integral(), (light * brdf).mean((1, 2)), rtol=1e-6)
    assert product.end == 0 and product.root < 0
    points = rng.random((500, 2))
    x, y, density = product.warp(points).T
    expected = product.weighted[(y * side).astype(int), (x * side).astype(int)]
    np.testing.assert_allclose(density, expected / product.weighted.mean(), rtol=1e-5)  # float32
    if constant == "both":
        np.testing.assert_array_equal(np.stack([x, y], -1), points)


@pytest.mark.statistical
def test_warp_is_distributed_as_the_dense_product(rng):
    """chi-square of independent points in 256 cells, five products; a twin 5 % off is rejected.

    alpha 1e-3 for the file, over all five (the twin's rejection is asked for at the same level).
    """
    side, n = 16, 200_000
    for _ in range(5):
        product = _Product(_smooth(rng, side, 3), _smooth(rng, side, 1)[0], 1.0)
        expected = n * product.weighted / product.weighted.sum()
        x, y, _ = product.warp(rng.random((n, 2))).T
        observed, _, _ = np.histogram2d(y, x, side, [[0, 1], [0, 1]])
        assert chi2_p_value(observed, expected) > sidak(1e-3, 5)
        wrong = expected * np.where(np.arange(side) % 2, 1.05, 1.0)
        assert chi2_p_value(observed, wrong * n / wrong.sum()) < sidak(1e-3, 5)


@pytest.mark.parametrize("corner", [0.0, 1.0 - 2.0**-53])
def test_corners_stay_inside(corner, rng):
    """Points at 0 and next to 1 neither leave the lit square nor get density 0.

    (2 + x) / 8 rounds to 3 / 8 for the largest x below 1: the edge itself is allowed.
    """
    light = np.zeros((3, 8, 8))
    light[:, 2:6, 1:3] = 1.0
    product = _Product(light, np.ones((8, 8)), 1.0)
    other = 0.5
    points = np.array([[corner, corner], [corner, other], [other, corner]])
    x, y, density = product.warp(points).T
    assert ((x >= 1 / 8) & (x <= 3 / 8) & (y >= 2 / 8) & (y <= 6 / 8)).all()
    np.testing.assert_allclose(density, 8.0)

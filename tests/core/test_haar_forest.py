"""core/wavelets/haar_forest.py: a forest is its slices' largest coefficients, and nothing else."""

import numpy as np
import pytest

from iwis.core.wavelets.haar import forward, inverse, truncated
from iwis.core.wavelets.haar_forest import HaarForest, build_forest, join_forests
from support.naive import forest_grid, haar_basis

SIDE = 16


def _grids(rng, n=5, channels=1, side=SIDE):
    return rng.standard_normal((n, channels, side, side)).astype(np.float32)


def _n_kept(forest: HaarForest, s: int) -> int:
    """Details of slice s that are not zero in every channel."""
    todo, total = [int(forest.root[s])] if forest.root[s] >= 0 else [], 0
    while todo:
        node = todo.pop()
        total += int((forest.detail[node] != 0.0).any(axis=-1).sum())
        todo += [int(child) for child in forest.child[node] if child >= 0]
    return total


@pytest.mark.parametrize("fraction", [1.0, 0.5, 0.1, 0.02])
def test_forest_is_the_truncated_series(fraction, rng):
    """One channel: the same grid as transform, truncation and inverse give."""
    grids = _grids(rng)
    forest = build_forest(grids.copy(), fraction)
    for s, grid in enumerate(grids[:, 0]):
        expected = inverse(truncated(forward(grid), fraction))
        np.testing.assert_allclose(forest_grid(forest, s, 0, SIDE), expected, atol=4e-6)  # float32


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("keep", [1, 2, 13, 255, 256])
def test_forest_keeps_exactly_the_k_largest(channels, keep, rng):
    """The mean and k - 1 details, the largest by their length over all channels."""
    grids = _grids(rng, 3, channels)
    forest = build_forest(grids.copy(), keep / SIDE**2)
    for s in range(3):
        assert _n_kept(forest, s) == keep - 1
        coefficients = np.stack([forward(grid) for grid in grids[s]])
        length = np.linalg.norm(coefficients, axis=0)
        chosen = np.append(0, 1 + np.argsort(-length[1:])[: keep - 1])
        for c in range(channels):
            kept = np.zeros(SIDE**2)
            kept[chosen] = coefficients[c, chosen]
            expected = kept @ haar_basis(SIDE)
            np.testing.assert_allclose(
                forest_grid(forest, s, c, SIDE).ravel(), expected, atol=4e-6
            )  # float32


def test_ties_are_cut_to_exactly_k():
    """All 255 details of a grid of squares' differences are equally large: still only k stay."""
    coefficients = np.ones(SIDE**2, np.float32)
    grid = inverse(coefficients)
    np.testing.assert_array_equal(forward(grid), coefficients)  # small whole numbers: exact
    for keep in (2, 100, 255):
        forest = build_forest(grid[None, None].copy(), keep / SIDE**2)
        assert _n_kept(forest, 0) == keep - 1


def test_constant_slices_have_no_node(rng):
    """Only their mean, also beside slices that have nodes; a whole forest of them is empty."""
    grids = _grids(rng, 3)
    grids[1] = 2.5
    forest = build_forest(grids.copy(), 0.1)
    assert forest.root[1] == -1 and forest.slice_mean[1, 0] == 2.5
    assert forest.root[0] >= 0 and forest.root[2] >= 0
    flat = build_forest(np.full((4, 3, SIDE, SIDE), 0.25, np.float32), 0.1)
    assert flat.root.tolist() == [-1] * 4 and len(flat.mean) == 0


def test_keeping_one_coefficient_leaves_means(rng):
    """The smallest fraction: every slice is constant."""
    grids = _grids(rng)
    forest = build_forest(grids.copy(), 1e-6)
    assert (forest.root == -1).all()
    np.testing.assert_allclose(forest.slice_mean[:, 0], grids.mean((1, 2, 3)), atol=1e-6)  # float32


@pytest.mark.parametrize("fraction", [1.0, 0.05])
def test_node_means_are_averages_over_their_squares(fraction, rng):
    """What a walk reads instead of summing from the top: the truncated series' own averages."""
    forest = build_forest(_grids(rng, 2, 3), fraction)
    for s in range(2):
        for c in range(3):
            grid = forest_grid(forest, s, c, SIDE)
            todo = [(int(forest.root[s]), 0, 0, 0)]
            while todo:
                node, level, i, j = todo.pop()
                size = SIDE >> level
                square = grid[i * size : (i + 1) * size, j * size : (j + 1) * size]
                assert forest.mean[node, c] == pytest.approx(square.mean(), abs=3e-6)  # float32
                todo += [
                    (int(child), level + 1, 2 * i + q // 2, 2 * j + q % 2)
                    for q, child in enumerate(forest.child[node])
                    if child >= 0
                ]


def test_joined_forests_hold_all_slices_in_order(rng):
    """Also where one of them is empty of nodes."""
    parts = [_grids(rng, 2), np.ones((1, 1, SIDE, SIDE), np.float32), _grids(rng, 3)]
    joined = join_forests([build_forest(part.copy(), 0.1) for part in parts])
    whole = build_forest(np.concatenate(parts), 0.1)
    for name in HaarForest._fields:
        np.testing.assert_array_equal(getattr(joined, name), getattr(whole, name))
        assert getattr(joined, name).dtype == getattr(whole, name).dtype


def test_nbytes_counts_all_arrays(rng):
    """What is told to the user as the table's size."""
    forest = build_forest(_grids(rng), 0.1)
    n, m = 5, len(forest.mean)
    assert forest.nbytes == 4 * n + 4 * n + m * (4 + 12 + 16)

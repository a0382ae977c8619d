"""core/sampling/neighbours.py: who tells of whom, and what they say together."""

import itertools

import numpy as np
import pytest

from iwis.core.sampling.incremental import new_sums
from iwis.core.sampling.neighbours import (
    CELL_PX,
    cell_order,
    find_neighbours,
    no_neighbours,
)
from support.spreads import relative_spread


def _random_points(rng, n=700, side=30):
    """Points of a tile with holes, three materials and normals of three directions."""
    pixel = np.sort(rng.permutation(side * side)[:n])
    columns, rows = 5 + pixel % side, 11 + pixel // side
    normal = np.eye(3, dtype=np.float32)[rng.integers(0, 3, n)]
    return columns, rows, rng.integers(0, 3, n), normal


def test_cells_are_whole_and_in_order(rng):
    """Every point once; a cell's points stand together, row by row."""
    columns, rows, _, _ = _random_points(rng)
    order, begins = cell_order(columns, rows)
    assert sorted(order) == list(range(len(rows))) and begins[-1] == len(rows)
    seen = set()
    for first, last in itertools.pairwise(begins):
        own = order[first:last]
        cells = set(zip(columns[own] // CELL_PX, rows[own] // CELL_PX, strict=True))
        assert len(cells) == 1 and not cells & seen
        seen |= cells
        places = list(zip(rows[own], columns[own], strict=True))
        assert places == sorted(places)


def test_neighbours_are_those_of_the_definition(rng):
    """One pixel away at most, in the same cell, of one material, normals within 37 degrees."""
    points = _random_points(rng)
    order, _ = cell_order(*points[:2])
    columns, rows, material, normal = (a[order] for a in points)
    found = find_neighbours(columns, rows, material, normal)
    for p in range(len(rows)):
        cell = (columns // CELL_PX == columns[p] // CELL_PX) & (
            rows // CELL_PX == rows[p] // CELL_PX
        )
        alike = cell & (material == material[p])
        far = np.abs(columns - columns[p]) + np.abs(rows - rows[p])
        close = np.maximum(np.abs(columns - columns[p]), np.abs(rows - rows[p])) == 1
        same = alike & close & (normal @ normal[p] > 0.8)
        assert set(found.near[p, :4]) - {-1} == set(np.flatnonzero(same & (far == 1)))
        assert set(found.near[p, 4:]) - {-1} == set(np.flatnonzero(same & (far == 2)))
        assert set(np.flatnonzero(found.group == found.group[p])) == set(np.flatnonzero(alike))


def _sums(light, seen):
    """The sums of samples (n_points, n_samples)."""
    f = np.where(seen, light, 0.0)
    sums = new_sums(len(f))
    sums.count[:], sums.visible[:] = f.shape[1], seen.sum(1)
    sums.seen[:], sums.seen_squared[:] = f.sum(1), (f * f).sum(1)
    return sums


def _naive_spread(sums, neighbours, floor):
    """The docstring of the module, point by point."""
    k, n = sums.visible.astype(float), sums.count.astype(float)
    mean = np.divide(sums.seen, k, out=np.zeros_like(k), where=k > 0)
    q = np.where(k > 1, sums.seen_squared / np.where(mean > 0, mean, 1) ** 2 - k, 0.0)
    dof = np.maximum(k - 1, 0.0)
    spread = []
    for p in range(len(k)):
        cell = neighbours.group == neighbours.group[p]
        terms = [(0.25, p)]
        terms += [(0.61 if i < 4 else 0.37, j) for i, j in enumerate(neighbours.near[p]) if j >= 0]
        seen = sum(w * k[j] for w, j in terms) + 8 * (k[cell].sum() + 0.5) / (n[cell].sum() + 1)
        share = seen / (sum(w * n[j] for w, j in terms) + 8)
        s2 = sum(w * q[j] for w, j in terms) + 8 * (q[cell].sum() + 0.1) / (dof[cell].sum() + 1)
        s2 /= sum(w * dof[j] for w, j in terms) + 8
        spread.append(np.sqrt(share * (1 - share) + s2 * share) / (share + floor))
    return np.array(spread)


def test_spread_agrees_with_the_naive_version(rng):
    """Points with and without company, some that saw nothing."""
    points = _random_points(rng, n=300)
    order, _ = cell_order(*points[:2])
    neighbours = find_neighbours(*(a[order] for a in points))
    seen = rng.random((300, 16)) < rng.random((300, 1)) ** 2
    sums = _sums(rng.random((300, 16)) + 0.1, seen)
    every = np.arange(300, dtype=np.int32)
    spread = relative_spread(sums, neighbours, 0.01, every)
    np.testing.assert_allclose(spread, _naive_spread(sums, neighbours, 0.01), rtol=1e-6)  # float32
    some = np.int32([7, 3, 250])
    np.testing.assert_array_equal(relative_spread(sums, neighbours, 0.01, some), spread[some])


@pytest.mark.parametrize("visibility", [0.1, 0.5, 0.9])
def test_spread_is_the_samples_own_where_there_are_many(visibility, rng):
    """Standard deviation over mean of 200 000 samples, whatever carries the variance."""
    light = rng.random((1, 200_000)) + 0.2
    seen = rng.random((1, 200_000)) < visibility
    f = np.where(seen, light, 0.0)
    spread = relative_spread(_sums(light, seen), no_neighbours(1), 0.0, np.zeros(1, np.int32))
    # The cell's prior is the point's own share here; half a hit and a tenth are 2e-5 of the counts.
    np.testing.assert_allclose(spread, f.std() / f.mean(), rtol=1e-4)


def test_floor_matters_in_the_dark_only():
    """A visibility of ten times the floor or more is judged within a tenth of its spread."""
    count = 100_000
    for visible, expected in ((count // 2, 1.0), (count // 10, 3.0), (0, None)):
        sums = new_sums(1)
        sums.count[:], sums.visible[:] = count, visible
        sums.seen[:] = sums.seen_squared[:] = visible
        spread = relative_spread(sums, no_neighbours(1), 0.01, np.zeros(1, np.int32))[0]
        if expected is None:
            assert spread < 1.0  # as little work as a half-lit point, not without end
        else:
            assert 0.9 * expected < spread <= expected * (1 + 1e-4)

"""core/light/light_leaves.py: the leaves of a cell, chosen in proportion to their light."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.light.light_leaves import choose_leaf
from iwis.core.light.pyramid import level_offset
from support.scenes import one_texel_world
from support.statistics import chi2_p_value, sidak
from support.warps import light_of


@kernel
def _choose_many(leaves, average, cell, points, out):
    for k in range(len(points)):
        x, y, light = choose_leaf(leaves, average, cell, points[k, 0], points[k, 1])
        out[k, 0], out[k, 1], out[k, 2] = x, y, light


@pytest.fixture(scope="module")
def light():
    """A sun of one texel over a dim ground: cells of many leaves at its rim."""
    return light_of(one_texel_world(256, 180, 100, 1e5, 0.5))


def _cells(light):
    """Some split cells, those with most leaves among them, and one that is a leaf."""
    counts = np.diff(light.leaves.first)
    split = np.argsort(counts, kind="stable")[-3:]
    return [*split.tolist(), int(np.flatnonzero(counts == 0)[0])], counts


def _chosen(light, cell, points):
    average = light.pyramid.averages[level_offset(light.pyramid.levels) + cell]
    out = np.empty((len(points), 3), np.float32)
    _choose_many(light.leaves, average, cell, points.astype(np.float32), out)
    return out


def test_every_leaf_is_in_a_table(light):
    """As many entries as leaves below the whole levels, and their light is the cell's."""
    pyramid, counts = light.pyramid, np.diff(light.leaves.first)
    begin = level_offset(pyramid.levels)
    split = pyramid.children[begin : begin + 4**pyramid.levels] > 0
    np.testing.assert_array_equal(counts > 0, split)
    inner = (pyramid.children[begin:] > 0).sum()
    assert counts.sum() == split.sum() + 3 * inner  # each split makes one leaf four
    assert counts.max() > 4


@pytest.mark.statistical
def test_leaves_are_chosen_by_their_light(light, rng):
    """chi-square over 8 x 8 parts of a cell against the light that falls from each.

    alpha 1e-3 over the four cells; the twin, light of every other column 5 % brighter, is rejected.
    """
    n, side = 400_000, 8
    cells, _ = _cells(light)
    middles = (np.arange(64) + 0.5) / 64
    grid = np.stack(np.meshgrid(middles, middles), -1).reshape(-1, 2)
    for cell in cells:
        points = _chosen(light, cell, rng.random((n, 2)))
        seen, _, _ = np.histogram2d(points[:, 1], points[:, 0], side, [[0, 1], [0, 1]])
        expected = _light_at(light, cell, grid).reshape(side, 8, side, 8).sum((1, 3))
        assert chi2_p_value(seen, n * expected / expected.sum()) > sidak(1e-3, 4)
        wrong = expected * np.where(np.arange(side) % 2, 1.05, 1.0)
        assert chi2_p_value(seen, n * wrong / wrong.sum()) < sidak(1e-3, 4)


def _light_at(light, cell, points):
    """The average of the leaf at points of a cell, by descent."""
    pyramid = light.pyramid
    out = np.empty(len(points))
    for k, (x, y) in enumerate(points):
        node = level_offset(pyramid.levels) + cell
        while pyramid.children[node] > 0:
            x, y = 2.0 * x, 2.0 * y
            right, below = int(x >= 1.0), int(y >= 1.0)
            x, y = x - right, y - below
            node = pyramid.children[node] + 2 * below + right
        out[k] = pyramid.averages[node]
    return out


def test_the_light_returned_is_the_leafs(light, rng):
    """What the density is made from is the average of the leaf that the point fell into."""
    cells, counts = _cells(light)
    assert counts[cells[-1]] == 0 and counts[cells[0]] > 4
    for cell in cells:
        points = _chosen(light, cell, rng.random((2000, 2)))
        there = _light_at(light, cell, points[:, :2].astype(np.float64))
        same = np.abs(points[:, 2] / there - 1.0) < 1e-6
        assert same.mean() > 0.998  # float32: a point may be rounded onto its leaf's border


def test_corners_stay_inside(light):
    """0 and the largest number below 1."""
    cells, _ = _cells(light)
    corners = np.array([(x, y) for x in (0.0, 1.0 - 2.0**-24) for y in (0.0, 1.0 - 2.0**-24)])
    for cell in cells:
        points = _chosen(light, cell, corners)
        assert (points[:, :2] >= 0.0).all() and (points[:, :2] < 1.0).all()
        assert (points[:, 2] > 0.0).all()

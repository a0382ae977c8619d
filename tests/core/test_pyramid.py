"""core/light/pyramid.py: indices of the quadtree, and what its leaves say of a direction."""

import numpy as np
import pytest

from iwis.core.light.environment import make_lookup
from iwis.core.light.light_tree import build_pyramid
from iwis.core.light.pyramid import (
    WHOLE_LEVELS,
    eval_leaf,
    level_offset,
    morton_to_row_column,
    pdf_light,
    row_column_to_morton,
)
from iwis.core.products.product import DEEPEST_LEVEL
from iwis.core.unit_square.sphere_map import square_to_sphere
from support.light_leaves import leaves_of, sun_world


def test_products_find_their_cells_light():
    """They multiply cell by cell: their levels must be whole."""
    assert DEEPEST_LEVEL <= WHOLE_LEVELS


def test_levels_stand_one_after_the_other():
    """Level l begins after 1 + 4 + ... + 4^(l - 1) cells."""
    assert [level_offset(level) for level in range(5)] == [0, 1, 5, 21, 85]


@pytest.mark.parametrize("level", [1, 3, 12])
def test_morton_codes_there_and_back(level, rng):
    """Every cell; the lowest bit is the column's, and children of k are 4 k ... 4 k + 3."""
    side = 1 << level
    for row, column in rng.integers(side, size=(200, 2)):
        cell = row_column_to_morton(row, column, level)
        assert 0 <= cell < side * side
        assert morton_to_row_column(cell) == (row, column)
        assert row_column_to_morton(row // 2, column // 2, level - 1) == cell // 4
        assert cell % 4 == 2 * (row % 2) + column % 2


@pytest.fixture(scope="module")
def sunny():
    """A tree with leaves of many levels."""
    pyramid = build_pyramid(make_lookup(sun_world(128, 40)))
    assert pyramid.deepest > pyramid.levels + 2
    return pyramid


def test_a_point_finds_its_leaf(sunny, rng):
    """Points inside 500 leaves, the brightest among them: average and whole-level cell."""
    average, size, x, y = leaves_of(sunny)
    some = np.unique(np.concatenate([np.argsort(average)[-200:], rng.integers(len(x), size=300)]))
    side = 1 << sunny.levels
    for k in some:
        u, v = x[k] + size[k] * rng.random(), y[k] + size[k] * rng.random()
        light, cell = eval_leaf(sunny, u, v)
        assert light == average[k]
        assert cell == row_column_to_morton(int(v * side), int(u * side), sunny.levels)


def test_the_borders_of_the_square_have_a_leaf(sunny):
    """x or y of 1 is what sphere_to_square may return."""
    for x, y in ((0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.5)):
        light, cell = eval_leaf(sunny, x, y)
        assert light > 0.0 and 0 <= cell < 4**sunny.levels


def test_density_of_the_light_is_its_share(sunny):
    """Leaf over mean over 4 pi, and all of it makes 1."""
    average, size, x, y = leaves_of(sunny)
    for k in range(0, len(x), len(x) // 50):
        direction = square_to_sphere(x[k] + size[k] / 2, y[k] + size[k] / 2)
        expected = average[k] / float(sunny.averages[0]) / (4.0 * np.pi)
        assert pdf_light(sunny, *direction) == pytest.approx(expected, rel=1e-12)
    # Sums of float32 averages of four, fifteen levels deep.
    assert (average * size * size).sum() == pytest.approx(float(sunny.averages[0]), rel=1e-6)

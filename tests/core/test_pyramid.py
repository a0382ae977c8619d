"""core/pyramid.py: the light as averages over the cells of a quadtree."""

import numpy as np
import pytest

from iwis.core.environment import eval_environment_many, make_lookup
from iwis.core.pyramid import (
    MAX_LEVELS,
    MIN_LEVELS,
    build_pyramid,
    level_offset,
    levels_for,
    luminance,
    morton_to_row_column,
    row_column_to_morton,
)
from iwis.core.sphere_map import sphere_grid, sphere_to_square
from support.scenes import constant_world, gradient_world, one_texel_world


def _level(pyramid, level):
    return pyramid.averages[level_offset(level) : level_offset(level + 1)]


def _luminance_grid(lookup, side):
    """float64 (side, side): luminance at the centres of a fine sphere grid."""
    radiance = np.empty((side * side, 3), np.float32)
    eval_environment_many(lookup, sphere_grid(side), radiance)
    return (radiance.astype(np.float64) @ (0.2126, 0.7152, 0.0722)).reshape(side, side)


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
        assert morton_to_row_column(cell, level) == (row, column)
        assert row_column_to_morton(row // 2, column // 2, level - 1) == cell // 4
        assert cell % 4 == 2 * (row % 2) + column % 2


def test_parents_are_the_averages_of_their_children():
    """At every level, to the rounding of three additions."""
    pyramid = build_pyramid(make_lookup(gradient_world()), 1)
    for level in range(pyramid.levels):
        children = _level(pyramid, level + 1).astype(np.float64).reshape(-1, 4)
        np.testing.assert_allclose(_level(pyramid, level), children.mean(1), rtol=3e-7)  # float32


@pytest.mark.parametrize("level", [0, 3, 5])
def test_cells_hold_the_average_luminance(level):
    """Against 16 times finer sampling of the same map, in place and value."""
    lookup = make_lookup(gradient_world(32))
    grid, side = _luminance_grid(lookup, 512), 1 << level
    expected = grid.reshape(side, 512 // side, side, 512 // side).mean((1, 3))
    cells = _level(build_pyramid(lookup, 1), level)
    for k, value in enumerate(cells):
        row, column = morton_to_row_column(k, level)
        # Five samples a leaf; at the poles, where the map blends in the other pole's row, the
        # light has a kink that 80 samples of a cell resolve to a percent.
        assert value == pytest.approx(expected[row, column], rel=1e-2)


def test_constant_light_is_constant():
    """Strength included; also at the poles and seams of both maps."""
    strength = np.float32([2.0, 3.0, 5.0])
    pyramid = build_pyramid(make_lookup(constant_world((0.5, 0.5, 0.5), strength=strength)), 1)
    np.testing.assert_allclose(pyramid.averages, luminance(1.0, 1.5, 2.5), rtol=1e-6)  # float32


def test_black_worlds_are_zero():
    """No floor where there is no light."""
    assert not build_pyramid(make_lookup(constant_world((0, 0, 0))), 1).averages.any()


@pytest.mark.parametrize("row", [12, 24, 33, 45])
def test_every_direction_that_a_lit_texel_reaches_has_density(row, rng):
    """Its light extends to the centres of its neighbours: no cell it touches may be dark.

    Up to 56 degrees of latitude; nearer to a pole texels are narrower than cells.
    """
    height, column = 64, 77
    lookup = make_lookup(one_texel_world(height, row, column))
    pyramid = build_pyramid(lookup, 1)
    offset = rng.uniform(-1.0, 1.0, (20_000, 2)) * 0.98  # at the rim itself there is no light left
    latitude = ((row + 0.5 + offset[:, 0]) / height - 0.5) * np.pi
    longitude = (0.5 - (column + 0.5 + offset[:, 1]) / (2 * height)) * 2.0 * np.pi
    directions = np.stack(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ],
        -1,
    )
    radiance = np.empty((len(directions), 3), np.float32)
    eval_environment_many(lookup, directions.astype(np.float32), radiance)
    side, leaves = 1 << pyramid.levels, _level(pyramid, pyramid.levels)
    missed = 0.0
    for direction, light in zip(directions, radiance[:, 1], strict=True):
        x, y = sphere_to_square(*direction)
        cell = row_column_to_morton(int(y * side), int(x * side), pyramid.levels)
        missed += light * (leaves[cell] <= 0.0)
    # What touches a cell between its corners and its centre only is the tip of the rim.
    assert missed <= 1e-3 * radiance[:, 1].sum()


def test_threads_do_not_change_it():
    """Chunks are written in place."""
    lookup = make_lookup(gradient_world(128))
    one = build_pyramid(lookup, 1)
    np.testing.assert_array_equal(build_pyramid(lookup, 3).averages, one.averages)


def test_levels_follow_the_maps_size():
    """At least as many cells as texels; 16 cells a texel up to 4^10 of them, 4 up to 4^11."""
    for height, finest in ((64, 9), (128, 10), (256, 10), (512, 11), (1024, 11), (2048, 12)):
        assert levels_for(height, 2 * height) == finest
        assert 4**finest >= 2 * height * height
    assert levels_for(1, 1) == MIN_LEVELS and levels_for(16384, 32768) == MAX_LEVELS


def test_a_cancelled_build_ends_early():
    """It is asked between chunks; what comes back is not used."""
    asked = []

    def cancelled():
        asked.append(1)
        return True

    build_pyramid(make_lookup(gradient_world(256)), 1, cancelled)
    assert len(asked) == 64  # 4^10 cells in chunks of 4^7

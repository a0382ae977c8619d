"""light_tree.py, light_cells.py, cell_lookup.py: the light's quadtree holds the light."""

import time

import numpy as np
import pytest

import iwis.core.light.light_tree as light_tree
from iwis.core.bsdf.luminance import luminance
from iwis.core.light.environment import eval_environment_many, make_lookup
from iwis.core.light.light_tree import build_pyramid
from iwis.core.light.pyramid import (
    WHOLE_LEVELS,
    cell_beside,
    eval_leaf,
    level_offset,
    morton_to_row_column,
)
from iwis.core.scene import CLOSEST, LINEAR_SRGB, MIRROR_BALL, EnvironmentMap
from iwis.core.unit_square.sphere_map import sphere_grid, sphere_to_square
from support.light_leaves import (
    LUMINANCE,
    leaves_of,
    light_weights,
    looked_up,
    mean_light,
    sun_world,
    texel_world,
)
from support.scenes import constant_world, gradient_world

LATITUDES = (0, 30, 60, 75, 85)


def _mean_on_a_grid(lookup, side=2048):
    """Mean luminance at the centres of a fine grid of the sphere."""
    radiance = np.empty((side * side, 3), np.float32)
    eval_environment_many(lookup, sphere_grid(side), radiance)
    return float((radiance.mean(0, dtype=np.float64) * LUMINANCE).sum())


def test_parents_are_the_averages_of_their_children():
    """Of whole levels and below them, to the rounding of three additions and a factor."""
    pyramid = build_pyramid(make_lookup(texel_world(64, 30)))
    averages = pyramid.averages.astype(np.float64)
    for level in range(pyramid.levels):
        here, below = level_offset(level), level_offset(level + 1)
        children = averages[below : below + 4 ** (level + 1)].reshape(-1, 4)
        np.testing.assert_allclose(averages[here:below], children.mean(1), rtol=5e-7)
    split = np.flatnonzero(pyramid.children)
    assert len(split) > 100
    children = averages[pyramid.children[split][:, None] + np.arange(4)]
    np.testing.assert_allclose(averages[split], children.mean(1), rtol=5e-7)


@pytest.mark.parametrize("level", [0, 3, 5])
def test_cells_hold_the_average_luminance(level):
    """Against 16 times finer sampling of the same map, in place and value."""
    lookup = make_lookup(gradient_world(32))
    grid, side = looked_up(lookup, sphere_grid(512)).reshape(512, 512), 1 << level
    expected = grid.reshape(side, 512 // side, side, 512 // side).mean((1, 3))
    begin = level_offset(level)
    for k, value in enumerate(build_pyramid(lookup).averages[begin : begin + side * side]):
        # At the poles the map blends in the other pole's row: a kink that both sides only sample.
        assert value == pytest.approx(expected[morton_to_row_column(k)], rel=5e-3)


def test_cells_beyond_the_squares_border_are_next_on_the_sphere():
    """Of 32 x 32 cells, about .11 rad wide: a cell and those one step out of the square are no
    farther apart than any two that share a side."""
    side, border = 32, np.arange(32)
    centers = sphere_grid(side).reshape(side, side, 3)
    ways = np.arccos((centers[:, 1:] * centers[:, :-1]).sum(-1).clip(-1.0, 1.0))
    edges = [(border, 0 * border, 0, -1), (border, 0 * border + 31, 0, 1)]
    edges += [(0 * border, border, -1, 0), (0 * border + 31, border, 1, 0)]
    for rows, columns, down, right in edges:
        near = [cell_beside(i + down, j + right, side) for i, j in zip(rows, columns, strict=True)]
        beyond = np.array([centers[morton_to_row_column(cell)] for cell in near])
        way = np.arccos((beyond * centers[rows, columns]).sum(-1).clip(-1.0, 1.0))
        assert 0.5 * ways.min() < way.min() and way.max() < 1.2 * ways.max()  # not the cell itself


def test_constant_light_is_constant():
    """Strength included; also at the poles and seams of both maps. No leaf below whole levels."""
    strength = np.float32([2.0, 3.0, 5.0])
    pyramid = build_pyramid(make_lookup(constant_world((0.5, 0.5, 0.5), strength=strength)))
    np.testing.assert_allclose(
        pyramid.averages, luminance(1.0, 1.5, 2.5), rtol=1e-5
    )  # float32 sums
    assert pyramid.deepest == WHOLE_LEVELS and not pyramid.children.any()


def test_darkness_stays_dark():
    """A lit texel lends its neighbours a little; it does not creep from cell to cell."""
    averages = build_pyramid(make_lookup(texel_world(512, 30))).averages
    assert averages[averages > 0.0].min() > 1e-24 * averages.max()  # 2^-10 a level, no denormals
    begin = level_offset(WHOLE_LEVELS)
    assert 0 < np.count_nonzero(averages[begin : level_offset(WHOLE_LEVELS + 1)]) < 40


def test_black_worlds_are_zero():
    """No floor where there is no light."""
    assert not build_pyramid(make_lookup(constant_world((0, 0, 0)))).averages.any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (3, 7), (16, 32), (200, 400), (512, 1024)])
def test_the_whole_light_is_the_maps(shape, rng):
    """The root is the exact integral of the bilinear map, for any number of texels."""
    texels = rng.random((*shape, 3), np.float32) ** 8
    root = build_pyramid(make_lookup(EnvironmentMap(radiance=texels))).averages[0]
    # Samples at texels' centres; where texels are larger than cells, at several points of each.
    assert root == pytest.approx(mean_light(texels), rel=1e-4 if shape[0] > 8 else 2e-3)


@pytest.mark.parametrize("latitude", LATITUDES)
@pytest.mark.parametrize("height", [256, 1024])
def test_a_suns_samples_are_nearly_alike(height, latitude, rng):
    """Half a degree, 1e5 times the sky: mean of the weights within 4 standard errors of the truth.

    The tree stops at a spread of .1; leaves' own estimates of it are off by less than half.
    """
    world = sun_world(height, latitude)
    lookup = make_lookup(world)
    pyramid, truth = build_pyramid(lookup), mean_light(world.radiance)
    weights = light_weights(pyramid, lookup, 1_000_000, rng)
    spread = weights.std() / truth
    # At a rim a leaf keeps an eighth of its brightest sample; of a million weights one is 8.1.
    assert spread < 0.15 and weights.max() < 9.0 * truth
    assert abs(weights.mean() / truth - 1.0) < 4.0 * spread / np.sqrt(len(weights)) + 1e-5
    assert pyramid.averages[0] == pytest.approx(truth, rel=1e-5)


@pytest.mark.parametrize("latitude", LATITUDES)
@pytest.mark.parametrize("ground", [0.0, 1.0])
def test_a_single_texels_samples_are_nearly_alike(latitude, ground, rng):
    """At 85 degrees a texel is eleven times narrower than at the equator, and still resolved."""
    world = texel_world(1024, latitude, ground=ground)
    lookup = make_lookup(world)
    truth = mean_light(world.radiance)
    weights = light_weights(build_pyramid(lookup), lookup, 200_000, rng)
    spread = weights.std() / truth
    assert spread < 0.4 and weights.max() < 20.0 * truth
    assert abs(weights.mean() / truth - 1.0) < 4.0 * spread / np.sqrt(len(weights)) + 1e-5


@pytest.mark.parametrize("latitude", (*LATITUDES, -89, 89.9))
@pytest.mark.parametrize("height", [64, 512])
def test_every_direction_that_a_lit_texel_reaches_has_density(height, latitude, rng):
    """Its light extends to the centres of its neighbours: no leaf it touches may be dark."""
    lookup = make_lookup(texel_world(height, latitude))
    pyramid = build_pyramid(lookup)
    row, column = np.unravel_index(lookup.texels[..., 0].argmax(), lookup.texels.shape[:2])
    offset = rng.uniform(-1.0, 1.0, (20_000, 2))
    up = ((row + 0.5 + offset[:, 0]) / height - 0.5) * np.pi
    around = (0.5 - (column + 0.5 + offset[:, 1]) / (2 * height)) * 2.0 * np.pi
    directions = np.stack(
        [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], -1
    )
    light = looked_up(lookup, directions)
    leaf = np.array([eval_leaf(pyramid, *sphere_to_square(*d))[0] for d in directions])
    assert (light > 0.0).sum() > 10_000
    assert not ((light > 0.0) & (leaf <= 0.0)).any()


_TURNED = np.float32([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]])
_STRETCHED = np.float32([[1.5, 0.2, 0, 0], [0, 1, 0, 0], [0, 0.1, -0.7, 0]])
_MOVED = np.float32([[1, 0, 0, 0.3], [0, 1, 0, -0.2], [0, 0, 1, 0.1]])
_FLAT = np.float32([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]])


@pytest.mark.parametrize(
    "mapping",
    [
        {"world_to_map": _TURNED},
        {"world_to_map": _STRETCHED},
        {"world_to_map": _MOVED},
        {"world_to_map": _FLAT},
        {"projection": MIRROR_BALL},
        {"interpolation": CLOSEST},
        {"interpolation": LINEAR_SRGB},
    ],
    ids=["turned", "stretched", "moved", "flat", "mirror ball", "closest", "srgb"],
)
def test_any_mapping_is_followed(mapping, rng):
    """A map of 256 by 512 with a bright spot, as the lookup shows it to the world."""
    texels = rng.random((256, 512, 3), np.float32)
    texels[150:154, 200:206] = 400.0
    lookup = make_lookup(EnvironmentMap(radiance=texels, **mapping))
    pyramid = build_pyramid(lookup)
    truth = _mean_on_a_grid(lookup)
    # The spot is 30 texels: half of its rim's 20 is what the grid, or the cells, may miss.
    assert pyramid.averages[0] == pytest.approx(truth, rel=1e-2)
    weights = light_weights(pyramid, lookup, 200_000, rng)
    assert weights.std() / truth < 0.5
    error = 4.0 * weights.std() / np.sqrt(len(weights))
    assert abs(weights.mean() - truth) < error + 5e-3 * truth  # the grid's: .3 % at hard edges


def test_a_tree_does_not_outgrow_its_bound(monkeypatch):
    """Where every texel differs from the next, the tree ends at its size, not at its aim."""
    monkeypatch.setattr(light_tree, "_NODES", 400_000)
    row, column = np.indices((512, 1024))
    texels = np.repeat(((row + column) % 2)[..., None], 3, 2).astype(np.float32)
    pyramid = build_pyramid(make_lookup(EnvironmentMap(radiance=texels)))
    assert 399_990 < len(pyramid.averages) <= 400_000
    assert pyramid.children.max() == len(pyramid.averages) - 4
    assert pyramid.averages.flags.owndata and (leaves_of(pyramid)[0] > 0.0).all()


def test_progress_rises_and_may_stop_the_work():
    """It is told at least every tenth of a second, from 0 to 1; what it raises comes through."""
    lookup, told = make_lookup(sun_world(1024, 30)), []
    build_pyramid(lookup)

    def note(fraction):
        told.append((fraction, time.thread_time()))

    build_pyramid(lookup, note)
    fractions, seconds = np.array(told).T
    assert (np.diff(fractions) >= 0.0).all() and fractions[0] == 0.0 and fractions[-1] <= 1.0
    assert np.diff(seconds).max() < 0.1

    def stop(fraction):
        if fraction > 0.2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build_pyramid(lookup, stop)

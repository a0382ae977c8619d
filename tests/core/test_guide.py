"""core/products/guide.py: what shadow rays teach the samples after them."""

import numpy as np
import pytest

from iwis.core.light.pyramid import cell_beside, morton_to_row_column
from iwis.core.machine.lanes import new_lanes
from iwis.core.products.guide import (
    learn,
    new_guide_room,
    new_guides,
    next_lesson,
    note_rays,
    scale_product,
)
from iwis.core.products.product import BASE_BEGIN, BLOCK_BEGIN
from iwis.core.tiles.center_tile import CenterTile
from iwis.core.tiles.tile_job import Rect
from support.scenes import (
    box,
    camera_above,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_job,
    make_scene,
    one_texel_world,
)
from support.warps import PointProduct, light_of


def _taught(asked, free):
    """(Guides of one block after a lesson, its room) from counts in every cell."""
    guides, room = new_guides(1), new_guide_room()
    guides.asked[0], guides.free[0] = asked, free
    learn(guides, 8, room)
    return guides, room


def test_gain_is_the_root_of_what_is_free():
    """With many rays in each cell: of V (1 - V / 2)."""
    free = np.repeat([0, 250, 1000, 4000], 256)
    guides, room = _taught(np.full(1024, 4000), free)
    part = free / 4000.0
    expected = np.sqrt(part * (1.0 - part / 2.0))
    np.testing.assert_allclose(guides.gain[0], expected, rtol=0.02, atol=0.01)
    np.testing.assert_array_equal(room.ratio, guides.gain[0])  # it was 1 before


@pytest.mark.parametrize("rays", [1, 15])
def test_few_rays_leave_doubt(rays):
    """Where none of the whole sphere's was free, a thousandth of one of them is taken to be."""
    gain = _taught(np.full(1024, rays), np.zeros(1024))[0].gain[0]
    np.testing.assert_allclose(gain, np.sqrt(0.001 / (1024.0 * rays + 1.0)), rtol=1e-5)


def test_a_hidden_sun_does_not_hide_the_sky():
    """However many rays went into one cell, those around it keep what few rays tell of them."""
    asked, free = np.full(1024, 10), np.full(1024, 8)
    few = _taught(asked, free)[0].gain[0]
    asked[77], free[77] = 30000, 0
    many = _taught(asked, free)[0].gain[0]
    assert many[77] < 0.02 < few[77]
    around = np.flatnonzero(np.arange(1024) != 77)
    assert (many[around] > 0.8 * few[around]).all()


def test_without_rays_all_cells_are_alike():
    """Nobody knows anything: one factor for all."""
    guides, _ = _taught(np.zeros(1024), np.zeros(1024))
    assert np.ptp(guides.gain) < 1e-6 and guides.gain.min() > 0.5


def test_cells_lean_on_what_is_around():
    """A cell without rays has the gain of its free, or occluded, surroundings."""
    asked, free = np.full(1024, 50), np.repeat([0, 50], 512)
    asked[[5, 1000]] = free[[5, 1000]] = 0
    gain = _taught(asked, free)[0].gain[0]
    assert gain[5] < 0.25 and gain[1000] > 0.7


def _rows_and_columns():
    return np.array([morton_to_row_column(c) for c in range(1024)]).T


@pytest.mark.parametrize("edge", [16, 21, 24])
def test_cells_lean_on_those_beside_them(edge):
    """Where what is free ends, the next cell may be free in part, whether or not its own parent is:
    three of the eight around are, as if two rays of its own had seen that."""
    rows, columns = _rows_and_columns()
    gain = _taught(np.full(1024, 20), np.where(columns < edge, 20, 0))[0].gain[0]
    part = 2.0 * (3 * 20) / (8 * 20 + 8) / 22.0
    expected = np.sqrt(part * (1.0 - part / 2.0))
    inside = (rows > 3) & (rows < 28)  # at the border others are beside it
    beside = gain[inside & (columns == edge)]
    assert (beside > 0.99 * expected).all() and (beside < 1.05 * expected).all()
    assert gain[inside & (columns > edge + 3)].max() < 0.01 * expected


def test_what_is_beside_a_cell_goes_on_over_the_squares_border():
    """Cells at two ends of a border of the square, one of them free, are neighbours."""
    rows, columns = _rows_and_columns()
    free = np.where((rows >= 28) & (columns < 14), 20, 0)
    gain = _taught(np.full(1024, 20), free)[0].gain[0]
    opposite = gain[(rows == 31) & (columns >= 20)]
    assert opposite.min() > 4.0 * gain[(rows == 29) & (columns >= 20)].max()


def test_all_eight_are_counted_at_the_borders_too():
    """What learn() leaves in its room are the rays of the eight cells beside each, as cell_beside
    names them: over an edge of the square, and over its corners."""
    asked = np.random.default_rng(4).integers(0, 20, 1024)
    _, room = _taught(asked, asked // 2)
    around = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    for c in range(1024):
        row, column = morton_to_row_column(c)
        near = [cell_beside(np.int32(row + i), np.int32(column + j), 32) for i, j in around]
        assert room.asked[BASE_BEGIN + c] == asked[near].sum()


def test_full_counts_add_up():
    """65535 rays in each cell are more than 16 bits and than a float32 counts one by one."""
    gain = _taught(np.full(1024, 65535), np.zeros(1024))[0].gain[0]
    np.testing.assert_allclose(gain, np.sqrt(0.001 / (1024.0 * 65535.0 + 1.0)), rtol=1e-3)


def test_the_second_lesson_scales_by_what_is_new():
    """Ratios multiply up to the gain."""
    guides, room = _taught(np.full(1024, 100), np.full(1024, 100))
    first = room.ratio.copy()
    guides.asked[0] += 900
    learn(guides, 32, room)
    np.testing.assert_allclose(first * room.ratio, guides.gain[0], rtol=1e-6)
    assert guides.gain.max() < 0.5 and guides.learnt[0] == 32


def test_lessons_are_at_2_8_32():
    """Each costs as much as a few rays of every point."""
    guides, found = new_guides(1), []
    for _ in range(4):
        found.append(int(next_lesson(guides)))
        guides.learnt[0] = found[-1]
    assert found == [2, 8, 32, 128]


def test_rays_are_noted_by_cell():
    """Those that follow a lobe are not; a full count is halved, with its share."""
    guides, lanes = new_guides(1), new_lanes()
    guides.asked[0, 7], guides.free[0, 7] = 65535, 32000
    lanes.base[:4], lanes.seen[:4], lanes.ray[:4] = (
        [3, 3, -1, 7],
        [True, False, True, True],
        [*range(4)],
    )
    note_rays(lanes, 4, guides)
    assert (guides.asked[0, 3], guides.free[0, 3]) == (2, 1)
    assert (guides.asked[0, 7], guides.free[0, 7]) == (32768, 16001)
    assert guides.asked[0].sum() == 32770


@pytest.mark.parametrize(
    ("material", "low", "high"), [(diffuse(), 0.9, 1.0), (glossy(1e-3), 0.0, 0.2)]
)
def test_only_rays_of_the_product_teach(material, low, high):
    """Of a Lambert surface 98 % of them, of a mirror 10 %: the others follow the lobe, and have no
    cell of the product's base."""
    scene = make_scene([floor()], [material], gradient_world(), camera_above(z=2.0, half=0.4))
    tile = CenterTile(make_job(scene, stop_rule="FIXED", max_samples=16), Rect(0, 0, 8, 8))
    tile._look()
    tile.advance(16)
    asked = sum(int(guides.asked.sum()) for guides in tile._guides)
    assert low < asked / tile.counts().shadow_rays < high


@pytest.mark.parametrize("material", [diffuse(), glossy(0.02), glossy(0.3)])
def test_a_scaled_product_adds_up(material, rng):
    """Its density over the sphere is 1, and its cells' are scaled as was asked."""
    light = light_of(gradient_world())
    product = PointProduct(light, material)
    before, whole = product.products.trees[0].copy(), product.whole_pdf()
    by = rng.uniform(0.1, 1.0, 1024).astype(np.float32)
    scale_product(product.products, 0, by)
    tree = product.products.trees[0]
    np.testing.assert_allclose(tree[BASE_BEGIN:BLOCK_BEGIN], before[BASE_BEGIN:BLOCK_BEGIN] * by)
    assert tree[0] == pytest.approx(tree[BASE_BEGIN:BLOCK_BEGIN].sum(), rel=1e-5)
    scaled = product.whole_pdf()
    assert scaled.mean() * 4.0 * np.pi == pytest.approx(whole.mean() * 4.0 * np.pi, rel=1e-4)
    assert np.abs(scaled / np.maximum(whole, 1e-30) - 1.0).max() > 0.2


def _error(guided, material, seed, world):
    """Mean relative error of 128 samples under a roof with a gap, and the mean itself."""
    parts = [floor(), box((-3.0, -3.0, 0.5), (0.25, 3.0, 0.6)), box((0.45, -3.0, 0.5), (3, 3, 0.6))]
    scene = make_scene(parts, [material] * 3, world, camera_above(z=0.45, half=0.4))
    job = make_job(scene, stop_rule="FIXED", max_samples=4096, seed=seed)
    tile = CenterTile(job, Rect(0, 0, 16, 16))
    tile._look()
    if not guided:
        tile._guides = [new_guides(0)] * len(tile._layers)
    tile.advance(128)
    picture = tile.develop().layers["combined"][..., 1].copy()
    tile.advance(4096)
    truth = tile.develop().layers["combined"][..., 1]
    return np.abs(picture / truth - 1.0).mean(), picture.mean() / truth.mean() - 1.0


@pytest.mark.statistical
@pytest.mark.parametrize("material", [diffuse(), glossy(0.3)])
def test_what_was_learnt_lowers_the_error(material):
    """Light through a gap: by a quarter at least (measured: .63, .58), and the mean stays."""
    world = gradient_world()
    found = np.array([_error(True, material, seed, world) for seed in (1, 2, 3)])
    plain = np.array([_error(False, material, seed, world) for seed in (1, 2, 3)])
    assert found[:, 0].mean() < 0.75 * plain[:, 0].mean()
    assert abs(found[:, 1].mean()) < 0.01


@pytest.mark.statistical
def test_a_hidden_sun_is_let_go():
    """Ten times as bright as its sky, and behind the roof: what it costs the sky's light.

    Errors measured: .15 with the sun, .119 without it; .59 where nothing is learnt.
    """
    suns = [one_texel_world(32, 24, 0, value, ground=1.0) for value in (5e3, 1.0)]
    found = np.array(
        [[_error(True, diffuse(), seed, sun)[0] for seed in (1, 2, 3)] for sun in suns]
    )
    plain = np.mean([_error(False, diffuse(), seed, suns[0])[0] for seed in (1, 2, 3)])
    with_sun, without = found.mean(axis=1)
    assert with_sun < 1.5 * without and with_sun < 0.35 * plain

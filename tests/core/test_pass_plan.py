"""core/tiles/pass_plan.py: how many passes pixels want, and which are taken at once."""

import numpy as np
import pytest

from iwis.core.camera.pass_rays import PILOT, rays_by_pass
from iwis.core.data.asked_passes import AskedPasses
from iwis.core.data.lamps import SPHERE, make_lamps
from iwis.core.passes.lucky_passes import raise_lucky
from iwis.core.passes.pass_sums import close_passes, fill_spreads, new_pass_sums
from iwis.core.sampling.block_loop import BLOCK_POINTS, PASSES_AT_ONCE
from iwis.core.sampling.neighbours import CELL_PX
from iwis.core.scene import CAMERA_RAYS, SHADOW_CATCHER, SHADOW_RAYS
from iwis.core.settings import RenderSettings
from iwis.core.tiles import pass_plan, pass_samples
from iwis.core.tiles.pass_plan import PassPlan, end_of_batch
from iwis.core.tiles.pass_samples import PassSampler
from iwis.core.tiles.tile_job import Rect
from support.scenes import (
    camera_above,
    diffuse,
    gradient_world,
    make_job,
    make_picture,
    make_scene,
    quad,
    varied_scene,
)

FILTERED = {"pixel_filter": "BLACKMAN_HARRIS", "threads": 1}


def _ends(together, most, first=PILOT):
    """Where batches end, from the first pass on."""
    passes, ends = 0, []
    while passes < most:
        passes = end_of_batch(passes, together, first)
        ends.append(passes)
    return ends


def test_a_windows_first_passes_are_taken_alone():
    """A picture is there at once, and a pilot ends where it is decided upon."""
    assert _ends(8, 32) == [4, 8, 16, 24, 32]
    assert _ends(8, 24, first=1) == [1, 2, 4, 8, 16, 24]
    assert _ends(4, 16, first=1) == [1, 2, 4, 8, 12, 16]
    assert _ends(1, 6) == [1, 2, 3, 4, 5, 6]
    assert PILOT in _ends(PASSES_AT_ONCE, 8)
    assert CELL_PX**2 * PASSES_AT_ONCE <= BLOCK_POINTS


@pytest.mark.parametrize("first", [1, PILOT])
@pytest.mark.parametrize("passes", range(30))
def test_batches_end_at_the_same_passes_wherever_they_begin(passes, first):
    """So pixels of a budget that have fallen behind come back into step."""
    end = end_of_batch(passes, PASSES_AT_ONCE, first)
    assert passes < end <= passes + PASSES_AT_ONCE
    assert end in _ends(PASSES_AT_ONCE, 40, first)


def test_passes_that_agree_by_chance_are_not_certain():
    """Four of the same light, whose own samples were noisy: the error is theirs, pooled as two
    passes; without noise it is 0."""
    sums, pixels = new_pass_sums(2), np.arange(2, dtype=np.int32)
    sums.light[:], sums.light_squared[:], sums.hits[:], sums.count[:] = 4.0, 4.0, 4, 32
    sums.noise[0] = 4 * 0.01  # of a mean, squared
    close_passes(pixels, np.full(2, 4, np.int32), False, sums)
    expected = np.sqrt(2.0 * 0.01 / (4 - 1 + 2) / 4**1.3)
    np.testing.assert_allclose(sums.error, [expected, 0.0], rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("with_alpha", [False, True])
def test_a_transparent_films_alpha_has_an_error_of_its_own(with_alpha):
    """Light without noise, of which half of the passes see the world: as uncertain as a draw of
    them, sqrt(1/4) of one pass, and so is its spread."""
    sums, pixels = new_pass_sums(1), np.zeros(1, np.int32)
    sums.light[:], sums.light_squared[:], sums.hits[:], sums.count[:] = 4.0, 4.0, 2, 16
    close_passes(pixels, np.full(1, 4, np.int32), with_alpha, sums)
    spread = np.empty(1, np.float32)
    fill_spreads(pixels, 8, 0.0, with_alpha, sums, spread)
    expected = (np.sqrt(0.25 / 4**1.3), np.sqrt(0.25 * 8)) if with_alpha else (0.0, 0.0)
    np.testing.assert_allclose([sums.error[0], spread[0]], expected, rtol=1e-5, atol=1e-7)


def test_every_pixel_takes_its_own_next_passes():
    """Pixels that are behind begin where they are; one that wants none has no ray."""
    rays = rays_by_pass(np.int32([7, 3, 5]), np.int32([0, 4, 6]), np.int32([2, 0, 3]))
    assert rays.pixel.tolist() == [7, 7, 5, 5, 5]
    assert rays.number.tolist() == [0, 1, 6, 7, 8]
    assert rays.at(rays.pixel == 5).number.tolist() == [6, 7, 8]


class _Flat:
    """Silhouettes of a tile where some pixels are near one."""

    def __init__(self, near, width):
        self._near, self.blurred, self.width = near, np.zeros(len(near), np.bool_), width

    def near(self):
        return self._near


def _row_of(near, cells, **settings):
    """(plan, its pixels) of a row of pixels, with a border as tiles have one."""
    n, width = len(near), len(near) + 2
    pixels = np.arange(n, dtype=np.int32) + np.int32(width + 1)
    cell, whole = np.full(3 * width, -1, np.int32), np.zeros(3 * width, np.bool_)
    cell[pixels], whole[pixels] = cells, near
    return PassPlan(RenderSettings(**settings), 8, False, _Flat(whole, width), pixels, cell), pixels


def _some_sums(pixels, spread, light=1.0):
    """Four passes of some pixels: their radiance, with a relative standard deviation of a pass."""
    sums = new_pass_sums(3 * (len(pixels) + 2))
    sums.passes[:], sums.hits[:], sums.count[:] = 4, 4, 32
    sums.visible[:] = 32
    sums.light[pixels] = 4.0 * light
    sums.light_squared[pixels] = (4.0 + 3.0 * np.square(spread)) * np.square(light)
    sums.unoccluded[:] = 4.0
    return sums


def test_noisier_pixels_want_more_passes_and_edges_some_at_least():
    """PERCEPTUAL, after the pilot: N grows with the spread; 1.2 / E near a silhouette."""
    spread = np.array([0.0, 0.3, 1.0, 0.0])
    settings = {"stop_rule": "PERCEPTUAL", "error_threshold": 0.1, "max_samples": 4096}
    plan, active = _row_of([False, False, False, True], 0, **settings)
    found = plan.wanted(active, 4, _some_sums(active, spread))
    assert found[0] == 4 and 4 < found[1] < found[2] and found[3] == 12
    found = plan.wanted(active, 2, _some_sums(active, spread))
    assert (found == 512).all()  # nobody ends before the pilot


def test_no_pixel_wants_more_than_the_most():
    """Whatever its noise, and whatever silhouettes ask for."""
    settings = {"stop_rule": "PERCEPTUAL", "error_threshold": 0.001, "max_samples": 44}
    plan, active = _row_of([False, True], 0, **settings)
    found = plan.wanted(active, 4, _some_sums(active, np.ones(2)))
    assert found.tolist() == [6, 6]  # of 8 samples, the last of 4


def _nine_of_two_cells(light, spread=0.0):
    """(plan, pixels, sums) of nine in a row, of other light; the last four are another cell's."""
    settings = {"stop_rule": "PERCEPTUAL", "error_threshold": 0.1, "max_samples": 4096}
    plan, pixels = _row_of(np.zeros(9, np.bool_), np.arange(9) >= 5, **settings)
    return plan, pixels, _some_sums(pixels, np.full(9, spread), np.array(light))


def test_pixels_beside_other_light_go_on_though_their_passes_agree():
    """An edge between colors is where no object ends; cells do not tell of each other."""
    plan, pixels, sums = _nine_of_two_cells([1.0, 1.0, 1.0, 0.25, 0.25, 1.0, 1.0, 1.0, 1.0])
    wanted = plan.wanted(pixels, 4, sums)
    assert (wanted[[0, 1, 5, 6, 7, 8]] == 4).all()
    assert (wanted[[2, 3]] > 6).all() and (wanted[[2, 3]] < 12).all()
    assert wanted[4] == 4  # beside a pixel of its own light, and one of another cell


def test_noise_between_pixels_is_no_edge():
    """Pixels that differ by no more than their passes say want what their passes say."""
    uneven = [1.0, 1.1, 0.9, 1.05, 1.0, 1.0, 1.0, 1.0, 1.0]
    plan, pixels, sums = _nine_of_two_cells(uneven, 0.3)
    alike, _, same = _nine_of_two_cells(np.ones(9), 0.3)
    assert (plan.spreads(pixels, 45.0, sums) < 1.2 * alike.spreads(pixels, 45.0, same)).all()


def test_pixels_that_were_bright_by_luck_go_on():
    """r is relative to what the pixels around say, too, where that is as likely; of what was dark,
    of what is brighter for certain and of another cell it is about the pixel's own."""
    light = [1.0, 1.5, 1.0, 0.6, 1.0, 1.0, 1.5, 1.0, 1.0]
    plan, pixels, sums = _nine_of_two_cells(light, 0.6)
    alike, _, same = _nine_of_two_cells(np.ones(9), 0.6)
    own = alike.spreads(pixels, 45.0, same)
    found = plan.spreads(pixels, 45.0, sums) / own
    # Of _some_sums' half sample that counts as unseen, less where there is more light.
    np.testing.assert_allclose(found[[1, 6]], 1.5 / (3.5 / 3.0), rtol=0.02)
    assert 0.95 < found[3] < 1.06 and found[4] > 1.1 and found[5] < 1.06
    plan, pixels, sums = _nine_of_two_cells(light, 0.01)
    sure = np.full(9, 45.0, np.float32)
    raised = sure.copy()
    raise_lucky(pixels, plan._cell, 11, sums, raised)
    np.testing.assert_allclose(raised, sure, rtol=1e-6)


def test_pixels_whose_passes_agree_by_luck_go_on():
    """Beside noisier ones of the same light r is up to half as much again; these keep theirs."""
    plan, pixels, sums = _nine_of_two_cells(np.ones(9), np.where(np.arange(9) == 2, 0.1, 0.6))
    raised = np.ones(9, np.float32)
    raise_lucky(pixels, plan._cell, 11, sums, raised)
    np.testing.assert_allclose(raised, np.where(np.arange(9) == 2, 1.5, 1.0), rtol=1e-6)


def _glint(spread, kind):
    """(plan, pixels, sums) of two cells of eight pixels that are sure of their light, of which one
    has light of that kind, ten times as bright, with that spread of its passes."""
    settings = {"stop_rule": "PERCEPTUAL", "error_threshold": 0.1, "max_samples": 4096}
    plan, pixels = _row_of(np.zeros(16, np.bool_), np.arange(16) >= 8, **settings)
    light, own = np.ones(16), np.zeros(16)
    light[2], own[2] = 10.0, spread
    sums = _some_sums(pixels, own, light)
    getattr(sums, kind)[pixels[2]] = 4.0 * 9.0
    return plan, pixels, sums


@pytest.mark.parametrize("kind", ["glossy", "diffuse", "emission", "environment"])
def test_pixels_of_a_cell_with_glints_go_on_though_they_have_seen_none(kind):
    """All of the cell's, where light comes of one pass in four; no other's. Where most passes show
    it a pixel beside is as sure as before, but for the edge."""
    plan, pixels, sums = _glint(np.sqrt(3.0), kind)
    wanted = plan.wanted(pixels, 4, sums)
    assert (wanted[:8] > 12).all() and (wanted[8:] == 4).all()
    plan, pixels, sums = _glint(0.5, kind)
    wanted = plan.wanted(pixels, 4, sums)
    assert wanted[2] > 4 and (wanted[[0, 4, 5, 6, 7]] == 4).all()


def _plates(**fields):
    """Two plates, one in the other's shadow: few normals, so that like points' products agree."""
    parts = [
        quad((-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)),
        quad((-0.4, -0.3, 0.3), (0.8, 0.0, 0.0), (0.0, 0.5, 0.3)),
    ]
    looks = [diffuse((0.7, 0.5, 0.4)), diffuse((0.3, 0.6, 0.8))]
    return make_scene(parts, looks, gradient_world(), camera_above(24, 16), **fields)


PLAIN = CAMERA_RAYS | SHADOW_RAYS
LAMPS = [{"kind": SPHERE, "position": (1.0, 1.0, 2.0), "size": (0.3, 0.0)}]


@pytest.mark.parametrize(
    ("most", "fields"),
    [
        (64, {}),
        (90, {"asked": AskedPasses(occlusion_distance=0.5)}),
        (64, {"lamps": make_lamps([row | {"radiance": (5.0, 4.0, 3.0)} for row in LAMPS])}),
    ],
    ids=["world", "occlusion", "lamps"],
)
def test_passes_at_once_are_the_passes_one_by_one(monkeypatch, most, fields):
    """The same rays and samples; learnt gains are multiplied in steps, so not the same bits."""
    settings = FILTERED | {"stop_rule": "FIXED", "max_samples": most}
    once, _ = make_picture(_plates(**fields), **settings)
    monkeypatch.setattr(pass_samples, "PASSES_AT_ONCE", 1)
    alone, _ = make_picture(_plates(**fields), **settings)
    for name in ("samples", "sample_count", "normal", "diffuse_color", "ambient_occlusion"):
        np.testing.assert_allclose(once[name], alone[name], rtol=1e-5, atol=1e-6, err_msg=name)
    assert once["combined"][..., :3].max() > 0.0
    difference = np.abs(once["combined"] - alone["combined"])
    same = difference <= 1e-4 * np.abs(alone["combined"]) + 1e-6
    # A direction that has moved by a rounding may pass an edge: one sample of ``most``.
    assert same.all(axis=-1).mean() > 0.9
    assert difference.max() <= 4.0 / most * alone["combined"].max()


def test_catchers_passes_at_once_are_as_good_as_one_by_one(monkeypatch):
    """Catchers share their cells' guides, which learn of the plate's passes first, and so of other
    rays: the picture has another noise, as much of it, and the same mean."""
    fields = {"object_flags": np.uint8([PLAIN | SHADOW_CATCHER, PLAIN])}
    settings = FILTERED | {"stop_rule": "FIXED", "max_samples": 256}
    once, _ = make_picture(_plates(**fields), **settings)
    monkeypatch.setattr(pass_samples, "PASSES_AT_ONCE", 1)
    alone, _ = make_picture(_plates(**fields), **settings)
    for name in ("samples", "sample_count", "normal", "diffuse_color"):
        np.testing.assert_allclose(once[name], alone[name], rtol=1e-5, atol=1e-6, err_msg=name)
    monkeypatch.undo()
    other, _ = make_picture(_plates(**fields), **settings | {"seed": 1})
    noise = np.abs(other["shadow_catcher"] - once["shadow_catcher"]).mean()
    assert 0.0 < np.abs(alone["shadow_catcher"] - once["shadow_catcher"]).mean() < 1.2 * noise
    means = [picture["shadow_catcher"].mean() for picture in (once, alone)]
    assert means[0] == pytest.approx(means[1], rel=0.002)  # of 384 pixels, 256 samples each


def _together(scene, **settings):
    job = make_job(scene, **FILTERED | settings)
    return PassSampler(job, Rect(0, 0, 8, 8), np.zeros(64, np.int32), new_pass_sums(64)).together


def test_rule_paper_decides_after_each_pass():
    """As the paper's loop does; other rules plan ahead."""
    assert _together(varied_scene()) == PASSES_AT_ONCE
    assert _together(varied_scene(), stop_rule="PAPER") == 1


def test_silhouettes_may_ask_for_nothing(monkeypatch):
    """The bound is the constant's."""
    monkeypatch.setattr(pass_plan, "_SILHOUETTE", 0)
    settings = {"stop_rule": "PERCEPTUAL", "error_threshold": 0.1, "max_samples": 4096}
    plan, active = _row_of([True], 0, **settings)
    found = plan.wanted(active, 4, _some_sums(active, np.zeros(1)))
    assert found.tolist() == [4]

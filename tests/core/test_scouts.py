"""core/sampling/scouts.py: rays that a block sends ahead of its samples."""

import numpy as np
import pytest

from iwis.core.tiles.center_tile import CenterTile
from iwis.core.tiles.tile_job import Rect
from support.scenes import (
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_job,
    make_scene,
    one_texel_world,
)

_GAP = [box((-3.0, -3.0, 0.5), (0.25, 3.0, 0.6)), box((0.45, -3.0, 0.5), (3, 3, 0.6))]


def _tile(world, seed=0, samples=4096, parts=()):
    parts = [floor(), *parts]
    scene = make_scene(parts, [diffuse()] * len(parts), world, camera_above(z=0.45, half=0.4))
    tile = CenterTile(
        make_job(scene, stop_rule="FIXED", max_samples=samples, seed=seed), Rect(0, 0, 16, 16)
    )
    tile._look()
    return tile


@pytest.mark.parametrize(
    ("parts", "samples", "ahead"),
    [((), 4, 0), ((), 7, 0), ((), 8, 0.5), ((), 16, 0.5), (_GAP, 8, 1.5)],
)
def test_they_are_sent_where_that_pays(parts, samples, ahead):
    """By every other pixel, and by each where most of these meet something; not for few samples.
    They are rays, and noted in the guide, but nobody's samples."""
    tile = _tile(gradient_world(), samples=samples, parts=parts)
    tile.advance(samples)
    counts = tile.counts()
    whole = 256 * (samples + ahead)
    assert counts.samples == 256 * samples
    # 1 to 2 % go below the face and have no ray, and of these 2 % follow the lobe and have no cell.
    assert whole - 0.03 * 256 * samples < counts.shadow_rays <= whole
    (guides,) = tile._guides
    assert 0.93 < guides.asked.sum() / counts.shadow_rays <= 1.0


def test_they_are_sent_once():
    """A tile that goes on does not begin anew."""
    tile = _tile(gradient_world())
    tile.advance(8)
    first = tile.counts().shadow_rays
    tile.advance(16)
    assert first > 256 * 8 and tile.counts().shadow_rays - first <= 256 * 8


def test_a_stopped_render_sends_none():
    """Cancelled before it began."""
    tile = _tile(gradient_world())
    tile._job.stop.set()
    tile.advance(64)
    assert tile.counts().samples == 0 and tile.counts().shadow_rays <= 256


def test_no_light_no_scouts():
    """A black world has nothing to learn from."""
    tile = _tile(constant_world(0.0))
    tile.advance(64)
    assert tile.counts().shadow_rays == 0


def _first_samples(seed, ahead):
    """Of 8 samples under a roof with a gap, over the truth's mean: error, and mean less 1."""
    tile = _tile(one_texel_world(32, 24, 0, 5e3, ground=1.0), seed, parts=_GAP)
    if not ahead:
        tile.advance(4)  # what is wanted at once is too little
    tile.advance(8)
    picture = tile.develop().layers["combined"][..., 1].copy()
    tile.advance(4096)
    truth = tile.develop().layers["combined"][..., 1]
    return np.abs(picture - truth).mean() / truth.mean(), picture.mean() / truth.mean() - 1.0


@pytest.mark.statistical
def test_the_first_samples_know_of_a_hidden_sun():
    """Ten times as bright as its sky, and behind the roof: .74 of the error (measured)."""
    seeds = range(1, 9)
    found, plain = (
        np.array([_first_samples(seed, ahead) for seed in seeds]) for ahead in (True, False)
    )
    assert found[:, 0].mean() < 0.85 * plain[:, 0].mean()
    assert abs(found[:, 1].mean()) < 4.0 * found[:, 1].std() / np.sqrt(len(seeds) - 1)

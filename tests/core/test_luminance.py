"""core/bsdf/luminance.py, and what noise of color alone is worth to the stop rules."""

import numpy as np
import pytest

from iwis.core.bsdf.luminance import chroma, luminance
from iwis.core.camera.camera import camera_rays
from iwis.core.data.channels import LUMINANCE_B, LUMINANCE_G, LUMINANCE_R
from iwis.core.passes.pass_sums import add_seen, close_passes, fill_spreads, new_pass_sums
from iwis.core.sampling.incremental import new_sums
from iwis.core.sampling.neighbours import no_neighbours
from iwis.core.scene import EnvironmentMap
from iwis.core.surfaces.merged_layers import merge_layers
from iwis.core.surfaces.seen_points import with_all_lobes
from iwis.core.tiles.tile_job import trace_points
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_job,
    make_picture,
    make_scene,
)
from support.spreads import relative_spread

WEIGHTS = np.array([LUMINANCE_R, LUMINANCE_G, LUMINANCE_B])
RED, CYAN = np.array([1.0 / LUMINANCE_R, 0.0, 0.0]), np.array([0.0, 1.0, 1.0]) / (1 - LUMINANCE_R)


def _chroma(colors):
    """The definition: weighted mean square of the channels, less the square of luminance."""
    return (colors**2) @ WEIGHTS - (colors @ WEIGHTS) ** 2


def test_chroma_is_what_luminance_leaves_of_the_square(rng):
    """0 for grey; by the channels alone, so that light twice as bright has four times as much."""
    assert chroma(*np.full(3, 0.7, np.float32)) == pytest.approx(0.0, abs=1e-13)
    for color in rng.random((50, 3)).astype(np.float32):
        expected = _chroma(color.astype(np.float64))
        assert chroma(*color) == pytest.approx(expected, rel=1e-4, abs=1e-7)
        assert chroma(*(2.0 * color)) == pytest.approx(4.0 * expected, rel=1e-4, abs=1e-7)
    assert luminance(*RED.astype(np.float32)) == pytest.approx(1.0)


def _sums(colors, seen):
    """PixelSums of one point, of samples (n, 3) of which bool (n,) were seen."""
    sums, kept = new_sums(1), colors[seen]
    sums.count[:], sums.visible[:] = len(colors), len(kept)
    sums.diffuse[0], sums.unoccluded[0] = kept.sum(0), colors.sum(0)
    light = kept @ WEIGHTS
    sums.seen[:], sums.seen_squared[:] = light.sum(), (light**2).sum()
    sums.hue[:] = _chroma(kept).sum()
    return sums


@pytest.mark.parametrize("visibility", [0.3, 1.0])
def test_spread_is_that_of_all_channels(visibility, rng):
    """Of many samples: the part that is hidden, and the seen samples' variance of each channel."""
    colors = rng.random((200_000, 3)) * [2.0, 1.0, 0.5]
    seen = rng.random(200_000) < visibility
    part, kept = seen.mean(), colors[seen]
    variance = kept.var(axis=0) @ WEIGHTS / (kept.mean(axis=0) @ WEIGHTS) ** 2
    expected = np.sqrt(part * (1.0 - part) + variance * part) / part
    one = np.zeros(1, np.int32)
    spread = relative_spread(_sums(colors, seen), no_neighbours(1), 0.0, one)
    np.testing.assert_allclose(spread, expected, rtol=1e-4)  # as in test_neighbours.py


def _floor_layer():
    """One point of a white floor, and its closure."""
    camera = camera_above(1, 1)
    job = make_job(make_scene([floor()], [diffuse()], constant_world(), camera), threads=1)
    return with_all_lobes(job.scene, trace_points(job, camera_rays(camera, 0, 0, 1, 1)))[0]


def _variance_of_color(sums):
    """Of one sample of PixelSums of one point that saw all, as the rules have it."""
    count, light = sums.count[0], sums.diffuse[0] + sums.glossy[0]
    return (sums.hue[0] - _chroma(light) / count) / (count - 1)


def test_closures_add_their_variance_of_color(rng):
    """What two closures bring together varies as much as both, a sample of each at a time."""
    layer, every = _floor_layer(), np.ones(40, np.bool_)
    parts = [_sums(rng.random((40, 3)) * color, every) for color in (RED, CYAN)]
    _, whole = merge_layers([layer, layer], parts)
    apart = sum(_variance_of_color(part) / 40 for part in parts)
    assert _variance_of_color(whole) / 80 == pytest.approx(apart, rel=1e-6)
    assert apart > 0.0


def test_passes_of_other_colors_are_noise():
    """Passes of one luminance, red and cyan by turns: their spread is that of color."""
    layer, state, one = _floor_layer(), new_pass_sums(1), np.zeros(1, np.int32)
    for number in range(8):
        sums = _sums(np.tile(RED if number % 2 else CYAN, (8, 1)), np.ones(8, np.bool_))
        add_seen(one, layer.seen.points.normal, layer.seen.lobes, sums, state)
    close_passes(one, np.full(1, 8), False, state)
    spread = np.empty(1, np.float32)
    fill_spreads(one, 8, 0.0, False, state, spread)
    variance = _chroma(np.stack([RED, CYAN])).mean() - _chroma((RED + CYAN) / 2)
    # Two passes more are thought of, without noise of their own; half a sample more is seen.
    assert spread[0] == pytest.approx(np.sqrt(8 * variance * 8 / (8 - 1 + 2)), rel=0.02)
    assert state.error[0] > 0.1


def _two_colors():
    """Red from x > 0, cyan from x < 0, of one luminance."""
    radiance = np.ones((16, 32, 3), np.float32)
    radiance[:, :16], radiance[:, 16:] = RED, CYAN
    return EnvironmentMap(radiance=radiance)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_light_of_two_colors_takes_more_samples(pixel_filter):
    """A floor that sees all of the sky: of one luminance: grey light has no noise."""
    settings = {"pixel_filter": pixel_filter, "error_threshold": 0.05, "max_samples": 4096}
    counts = []
    for world in (constant_world(), _two_colors()):
        scene = make_scene([floor()], [diffuse()], world, camera_above(16, 16, half=0.5))
        counts.append(make_picture(scene, **settings)[0]["samples"].mean())
    assert counts[1] > 2.0 * counts[0], counts

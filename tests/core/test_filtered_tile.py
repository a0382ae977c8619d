"""core/tiles/filtered_tile.py: pictures whose pixels average several shading points."""

import dataclasses
import math

import numpy as np
import pytest

from iwis.core.camera.pass_rays import PILOT, samples_of_a_pass
from iwis.core.film import LAYERS
from iwis.core.settings import RenderSettings
from iwis.core.tiles import pass_plan
from iwis.core.tiles.filtered_tile import FilteredTile
from iwis.core.tiles.tile_job import Rect
from support.scenes import (
    black,
    camera_above,
    camera_at,
    constant_world,
    diffuse,
    make_job,
    make_picture,
    make_scene,
    quad,
    varied_scene,
)

BOTH = pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])
FILTERED = {"pixel_filter": "BLACKMAN_HARRIS", "max_samples": 40, "error_threshold": 0.2}
CENTRED = ("depth", "position", "object_index", "material_index")
DARK = constant_world((0.0, 0.0, 0.0))


def _glowing(camera, edge=0.03, slope=0.0, **fields):
    """A plane of radiance 1 right of x = edge + slope y, in the dark."""
    part = quad((edge - 50.0 * slope, -50.0, 0.0), (90.0, 0.0, 0.0), (100.0 * slope, 100.0, 0.0))
    return make_scene([part], [black(emission=(1.0, 1.0, 1.0))], DARK, camera, **fields)


def _shares(camera, edge, cdf, stretch=1.0):
    """What of each column's filter lies right of the edge; cdf: of the filter, in pixels."""
    left, right = camera.window[:2]
    centres = np.arange(camera.width) + 0.5
    edge_px = (edge * stretch - left) / (right - left) * camera.width
    return 1.0 - cdf(edge_px - centres)


def _box_cdf(x):
    return np.clip(x + 0.5, 0.0, 1.0)


def _blackman_harris_cdf(width):
    place = np.linspace(-1.0, 1.0, 20_001)
    angle = np.pi * (place + 1.0)
    terms = 0.35875, -0.48829, 0.14128, -0.01168
    density = sum(a * np.cos(k * angle) for k, a in enumerate(terms))
    cdf = np.cumsum(density) / density.sum()
    return lambda x: np.interp(x / width, place, cdf)


def _gaussian_cdf(width):
    return np.vectorize(lambda x: 0.5 * math.erfc(-4.0 * x / width / math.sqrt(2.0)))


FILTERS = {
    "box": ({"pixel_filter": "BOX", "filter_width": 1.0}, _box_cdf),
    "box is one pixel wide": ({"pixel_filter": "BOX", "filter_width": 3.0}, _box_cdf),
    "as cycles": ({"pixel_filter": "BLACKMAN_HARRIS"}, _blackman_harris_cdf(1.5)),
    "gaussian": ({"pixel_filter": "GAUSSIAN"}, _gaussian_cdf(1.5)),
    "narrow": ({"pixel_filter": "BLACKMAN_HARRIS", "filter_width": 0.5}, _blackman_harris_cdf(0.5)),
    "wide": ({"pixel_filter": "BLACKMAN_HARRIS", "filter_width": 10.0}, _blackman_harris_cdf(10.0)),
}


@pytest.mark.parametrize("name", FILTERS)
def test_an_edge_is_the_filters_integral(name):
    """64 points a pixel are stratified: a share along one axis is off by at most 1/64."""
    settings, cdf = FILTERS[name]
    camera = camera_above(24, 16)
    layers, _ = make_picture(
        _glowing(camera), batch_size=1, max_samples=64, stop_rule="FIXED", **settings
    )
    expected = np.tile(_shares(camera, 0.03, cdf), (16, 1))
    found = layers["combined"][..., 0]
    assert np.abs(found - expected).max() <= 1 / 64 + 2e-4  # the CDF's own 2e-4
    mixed = (expected > 0.01) & (expected < 0.99)
    # scrambled points are uniform in their strata: standard deviation at most .5 / 64 a pixel
    assert abs((found - expected)[mixed].mean()) <= 3.0 * 0.5 / 64 / np.sqrt(mixed.sum())
    np.testing.assert_array_equal(layers["emission"][..., 0], found)


def test_widths_are_pixels_in_either_direction():
    """Pixels twice as wide as tall: an edge across and one along blur over as many pixels."""
    camera = camera_above(16, 16)
    camera = dataclasses.replace(camera, window=(-1.8, 1.8, -0.9, 0.9))
    settings = {"batch_size": 1, "max_samples": 64, "stop_rule": "FIXED"}
    settings["pixel_filter"] = "BLACKMAN_HARRIS"
    upright, _ = make_picture(_glowing(camera, edge=0.06), **settings)
    flat = quad((-50.0, 0.03, 0.0), (100.0, 0.0, 0.0), (0.0, 90.0, 0.0))
    lying, _ = make_picture(
        make_scene([flat], [black(emission=(1.0, 1.0, 1.0))], DARK, camera), **settings
    )
    across, along = upright["combined"][..., 0], lying["combined"][..., 0].T
    assert np.abs(across - along).max() <= 2 / 64


def test_a_perspective_edge_too():
    """The window of a perspective camera is the plane one metre before it."""
    camera = camera_at((0.0, -1e-3, 1.0), (0.0, 0.0, 0.0), 16, 16, 0.4)
    layers, _ = make_picture(
        _glowing(camera), batch_size=1, max_samples=64, stop_rule="FIXED", pixel_filter="BOX"
    )
    expected = np.tile(_shares(camera, 0.03, _box_cdf), (16, 1))
    # the camera looks .001 rad aside: the edge is slanted by 1e-3 of the picture, .01 pixels
    assert np.abs(layers["combined"][..., 0] - expected).max() <= 1 / 64 + 0.02


def test_alpha_is_the_share_of_the_object():
    """With a transparent film; the Environment pass holds the rest of the world."""
    camera = camera_above(24, 16)
    scene = _glowing(camera, transparent_film=True)
    scene = dataclasses.replace(scene, environment=constant_world((2.0, 2.0, 2.0)))
    settings = {"batch_size": 1, "max_samples": 64, "stop_rule": "FIXED", "pixel_filter": "BOX"}
    layers, _ = make_picture(scene, **settings)
    alpha = layers["combined"][..., 3]
    assert np.abs(alpha - _shares(camera, 0.03, _box_cdf)).max() <= 1 / 64
    np.testing.assert_allclose(layers["combined"][..., 0], alpha, atol=1e-6)  # emission 1
    np.testing.assert_allclose(layers["environment"][..., 0], 2.0 * (1.0 - alpha), atol=1e-6)
    np.testing.assert_allclose(layers["normal"][..., 2], alpha, atol=1e-6)  # as in Cycles
    opaque, _ = make_picture(dataclasses.replace(scene, transparent_film=False), **settings)
    assert (opaque["combined"][..., 3] == 1.0).all()
    expected = alpha + 2.0 * (1.0 - alpha)
    np.testing.assert_allclose(opaque["combined"][..., 0], expected, atol=1e-6)


def test_depth_position_and_indices_are_those_of_the_centre():
    """As in Cycles; the same bits as with filter CENTER."""
    filtered, _ = make_picture(varied_scene(), **FILTERED)
    centred, _ = make_picture(varied_scene(), max_samples=8)
    for name in CENTRED:
        np.testing.assert_array_equal(filtered[name], centred[name], err_msg=name)


def _assert_same(layers, expected):
    assert set(layers) == set(expected) == set(LAYERS)
    for name, layer in expected.items():
        np.testing.assert_array_equal(layers[name], layer, err_msg=name)


@BOTH
@pytest.mark.parametrize("rule", ["PAPER", "PERCEPTUAL"])
@pytest.mark.parametrize("change", [{"threads": 3, "tile_px": 8}, {"tile_px": 13}])
def test_threads_and_tiles_do_not_change_the_picture(estimator, change, rule, table_dir):
    """Bit for bit, although a pixel's stop asks its neighbours."""
    settings = FILTERED | {"estimator": estimator, "stop_rule": rule, "cache_dir": table_dir}
    layers, _ = make_picture(varied_scene(), **settings)
    _assert_same(make_picture(varied_scene(), **settings | change)[0], layers)
    for layer in layers.values():
        assert np.isfinite(layer).all()


@pytest.mark.parametrize("region", [(11, 5, 30, 23), (39, 27, 40, 28)])
def test_a_border_is_a_part_of_the_whole(region):
    """Down to a single pixel: those around it are looked at all the same."""
    x0, y0, x1, y1 = region
    whole, _ = make_picture(varied_scene(), **FILTERED)
    part, _ = make_picture(varied_scene(region=region), **FILTERED)
    _assert_same(part, {name: layer[y0:y1, x0:x1] for name, layer in whole.items()})


@pytest.mark.parametrize("first", [1, PILOT])
@pytest.mark.parametrize("rule", ["FIXED", "PAPER", "PERCEPTUAL"])
def test_a_tile_that_pauses_ends_with_the_same_bits(rule, first):
    """Advanced by 8 samples at a time, developed in between: a window's, and a render's."""
    job = make_job(varied_scene(), stop_rule=rule, **FILTERED)
    job = dataclasses.replace(job, first_passes=first)
    once, often = (FilteredTile(job, Rect(8, 4, 20, 16)) for _ in range(2))
    assert once.advance(40)
    for samples in range(8, 41, 8):
        done = often.advance(samples)
        tile = often.develop()
        often.rest()
        assert tile.layers["samples"].max() <= samples
    assert done
    _assert_same(often.develop().layers, once.develop().layers)


def test_passes_of_few_samples():
    """Never less than four shading points a pixel, unless MAX is below that."""
    for most, n, expected in ((100, 8, 8), (16, 8, 4), (5, 8, 1), (1, 8, 1), (100, 1, 1)):
        settings = RenderSettings(max_samples=most, batch_size=n)
        assert samples_of_a_pass(settings, camera_above()) == expected


@pytest.mark.parametrize(("most", "n"), [(1, 8), (13, 3), (30, 8)])
def test_fixed_takes_every_sample_once(most, n):
    """MAX that is no multiple of n: where all points see the floor, MAX samples."""
    scene = make_scene(
        [quad((-5.0, -5.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0))],
        [diffuse()],
        constant_world(),
        camera_above(8, 8),
    )
    layers, stats = make_picture(
        scene, pixel_filter="BOX", stop_rule="FIXED", max_samples=most, batch_size=n
    )
    assert (layers["samples"] == most).all() and (layers["sample_count"] == 1.0).all()
    assert stats.samples_total == 64 * most and stats.shaded_pixels == 64


def test_the_empty_world_stops_early():
    """Nothing but a constant world: four passes, no sample."""
    scene = make_scene([], [], constant_world((0.2, 0.5, 1.0)), camera_above(16, 16))
    layers, stats = make_picture(scene, pixel_filter="BLACKMAN_HARRIS", max_samples=1 << 20)
    # Four passes of four tiles of 8 x 8 pixels and one around them; then the centres.
    assert stats.primary_rays == 4 * 4 * 10 * 10 + 16 * 16 and stats.samples_total == 0
    expected = np.tile(np.float32([0.2, 0.5, 1.0, 1.0]), (16, 16, 1))
    np.testing.assert_allclose(layers["combined"], expected, rtol=1e-6)


def _wire_scene(width_px):
    """Black wires before a white sky, slanted, 5.6 pixels apart."""
    camera = camera_above(48, 48)
    across = (width_px * 1.8 / 48, 0.0, 0.0)
    parts = [quad((x, -2.0, 0.0), across, (0.8, 4.0, 0.0)) for x in np.arange(-1.7, 1.0, 0.21)]
    return make_scene(parts, [black()] * len(parts), constant_world(), camera)


@pytest.mark.parametrize("rule", ["PAPER", "PERCEPTUAL"])
def test_thin_wires_before_the_sky_keep_their_darkness(rule, monkeypatch):
    """A quarter of a pixel wide: they take their share of the sky, within the error asked for.

    With a rule that asks only a pixel's own first points a third of it would be lost.
    """
    scene, settings = _wire_scene(0.25), {"pixel_filter": "BLACKMAN_HARRIS"}
    truth, _ = make_picture(scene, max_samples=512, batch_size=1, stop_rule="FIXED", **settings)
    expected = (1.0 - truth["combined"][..., 0]).sum()

    def share():
        limits = {"max_samples": 256, "error_threshold": 0.1, "stop_rule": rule}
        layers, _ = make_picture(scene, **settings, **limits)
        return (1.0 - layers["combined"][..., 0]).sum() / expected

    assert share() == pytest.approx(1.0, abs=0.1)
    monkeypatch.setattr(pass_plan, "_SILHOUETTE", 0)
    assert share() < 0.75


def test_edges_take_more_samples_and_reach_the_error():
    """Edges get what the threshold asks for, as flat parts do, by more samples."""
    scene = varied_scene(width=80, height=56)
    settings = {"pixel_filter": "BLACKMAN_HARRIS", "max_samples": 1024}
    truth, _ = make_picture(scene, stop_rule="FIXED", seed=5, **settings)
    layers, _ = make_picture(scene, stop_rule="PAPER", error_threshold=0.05, **settings)
    light = truth["combined"][..., :3].sum(-1)
    error = np.abs(layers["combined"][..., :3].sum(-1) - light) / np.maximum(light, 0.01)
    shown = (truth["depth"][..., 0] < 1e9) & (light > 0.01)
    edges = shown & (np.linalg.norm(truth["normal"], axis=-1) < 0.98)
    flat = shown & ~edges
    assert edges.sum() > 100 and flat.sum() > 100
    assert error[edges].mean() < 0.05 and error[flat].mean() < 0.05
    # measured 1.2: a spread of few passes is known less well where they differ much
    assert error[edges].mean() < 1.5 * error[flat].mean()
    assert layers["samples"][edges].mean() > 2.0 * layers["samples"][flat].mean()


def test_passes_that_are_cut_short_do_not_count():
    """A tile that is stopped in a batch shows the passes before it."""
    job = make_job(varied_scene(), stop_rule="FIXED", **FILTERED | {"max_samples": 64})
    work = FilteredTile(job, Rect(8, 4, 20, 16))
    work.advance(32)
    before, gather = work.develop().layers, work._sampler.gather

    def stopped(*points):
        found = gather(*points)
        job.stop.set()
        return found

    work._sampler.gather = stopped
    assert not work.advance(64)
    _assert_same(work.develop().layers, before)
    assert before["samples"].max() == 32

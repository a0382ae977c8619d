"""filtered_tile.py where the lens blurs: enough passes, shared decisions, no dark holes."""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera import silhouettes
from iwis.core.camera.pass_rays import samples_of_a_pass
from iwis.core.passes.pass_sums import cell_spreads
from iwis.core.scene import CameraMotion, Lens, Panorama
from iwis.core.settings import RenderSettings
from iwis.core.tiles import pass_plan
from iwis.core.tiles.filtered_tile import FilteredTile
from iwis.core.tiles.tile_job import Rect
from support.scenes import (
    black,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_job,
    make_picture,
    make_scene,
    quad,
    varied_scene,
)

# Spread over 16 pixels of .0375 m, 8 m before the plane of focus.
OUT_OF_FOCUS = Lens(0.15, 2.0)


def _spot_scene(lens=OUT_OF_FOCUS, **fields):
    """A bright spot of less than a pixel, 10 m below an orthographic camera, before the world."""
    camera = dataclasses.replace(camera_above(48, 48, z=6.0), lens=lens)
    spot = quad((-0.02, -0.02, 0.0), (0.04, 0.0, 0.0), (0.0, 0.04, 0.0))
    return make_scene(
        [spot], [black(emission=(200.0,) * 3)], constant_world((0.1,) * 3), camera, **fields
    )


def _spot_light(**settings):
    """Light of the whole picture above the world's."""
    layers, _ = make_picture(_spot_scene(), pixel_filter="BOX", **settings)
    return (layers["combined"][..., 0].astype(np.float64) - 0.1).sum(), layers


@pytest.mark.slow
def test_a_bright_spot_out_of_focus_keeps_its_light(monkeypatch):
    """Pixels that miss it do not end before those that hit it: asked of the whole cell.

    Where each asks only its own passes, nearly all of the light is lost (94 % over 12 seeds).
    """
    truth = (200.0 - 0.1) * (0.04 / (1.8 / 48)) ** 2
    adaptive = {"max_samples": 1024, "error_threshold": 0.1}
    found = np.mean([_spot_light(seed=seed, **adaptive)[0] for seed in range(3)])
    # One seed's standard deviation is 6 %, measured over 12: four of them for a mean of three.
    assert found == pytest.approx(truth, rel=0.15)
    monkeypatch.setattr(silhouettes, "blurred", lambda camera, at: np.zeros(len(at), bool))
    monkeypatch.setattr(silhouettes, "world_blurred", lambda camera: False)
    # What comes seldom is asked for as well: four fifths of it by that alone.
    monkeypatch.setattr(pass_plan, "seldom_spreads", lambda cell, n, *_: np.zeros(n, np.float32))
    assert _spot_light(**adaptive)[0] < 0.5 * truth


def test_the_spot_becomes_a_disc_of_the_lens():
    """As wide as the aperture and the distance make it, and nothing beside it."""
    _, layers = _spot_light(max_samples=1024, stop_rule="FIXED")
    light = layers["combined"][..., 0] - 0.1
    rows, columns = np.nonzero(light > 0.05 * light.max())
    radius = 0.15 * abs(1.0 - 6.0 / 2.0) / (1.8 / 48)
    for places in (rows, columns):
        assert np.ptp(places) == pytest.approx(2.0 * radius, abs=2.0)
    middle = np.hypot(*(np.mgrid[:48, :48] - 23.5))
    assert light[middle < radius - 1.0].min() > 0.0
    assert np.abs(light[middle > radius + 1.5]).max() < 1e-6


def test_blurred_pixels_of_a_cell_end_together():
    """One decision for 8 x 8 pixels, so none ends because of what it happened to see."""
    job = make_job(_spot_scene(), pixel_filter="BOX", max_samples=512)
    tile = FilteredTile(job, Rect(0, 0, 48, 48))
    tile.advance(512)
    passes = tile._shaped(tile._sums.passes)[1:-1, 1:-1]
    cells = passes.reshape(6, 8, 6, 8).transpose(0, 2, 1, 3).reshape(36, 64)
    assert (cells == cells[:, :1]).all()
    assert cells.max() > 2 * cells.min() > 0


def test_a_blurred_picture_depends_on_no_tile():
    """Bit for bit: cells lie fixed in the frame."""
    scene = varied_scene()
    scene = dataclasses.replace(
        scene, camera=dataclasses.replace(scene.camera, lens=Lens(0.08, 2.0, 5))
    )
    pictures = [
        make_picture(scene, pixel_filter="BLACKMAN_HARRIS", max_samples=64, tile_px=size)[0]
        for size in (8, 64)
    ]
    np.testing.assert_array_equal(pictures[0]["combined"], pictures[1]["combined"])


def test_depth_and_position_are_of_the_sharp_picture():
    """Through the lens' centre: no noise of the lens in them."""
    sharp = _spot_scene(lens=None)
    settings = {"pixel_filter": "BOX", "max_samples": 16}
    a, b = (make_picture(scene, **settings)[0] for scene in (sharp, _spot_scene()))
    for name in ("depth", "position", "object_index"):
        np.testing.assert_array_equal(a[name], b[name])
    assert not np.array_equal(a["combined"], b["combined"])


def test_what_is_in_focus_takes_no_more_passes():
    """A floor in the plane of focus, seen with an open lens: only fewer samples a point."""
    camera = dataclasses.replace(camera_above(16, 16, z=6.0), lens=Lens(0.15, 6.0))
    scene = make_scene([floor(5.0)], [diffuse()], constant_world(), camera)
    layers, _ = make_picture(scene, pixel_filter="BOX", max_samples=256, error_threshold=0.1)
    settings = RenderSettings()
    n = samples_of_a_pass(settings, camera)
    assert n < samples_of_a_pass(settings, camera_above())
    assert layers["samples"].max() < 12 * n


def test_a_cell_says_what_its_pixels_know_together():
    """One pixel in eight hit a spot: all get the spread of one hit in eight."""
    light = np.array([4.0, *np.zeros(7), *np.ones(8)])
    spread = np.float32([2.0, *np.zeros(7), *np.zeros(8)])  # of 4 passes with one hit: sqrt(3)
    found = cell_spreads(np.repeat([0, 1], 8), 3, np.full(16, 4), light, spread)
    # mean variance (2 x 1)^2 / 8, mean light 1 / 8: r^2 = 32
    np.testing.assert_allclose(found, [np.sqrt(32.0), 0.0, 0.0], rtol=1e-6)


@pytest.mark.parametrize("transparent", [False, True])
@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_outside_a_fisheyes_circle_is_black_and_opaque(pixel_filter, transparent):
    """As in Cycles; inside it the world is as the film says."""
    camera = dataclasses.replace(
        camera_above(24, 24),
        kind="PANORAMIC",
        window=(0.0, 1.0, 0.0, 1.0),
        panorama=Panorama("FISHEYE_EQUIDISTANT", (np.pi,)),
    )
    world = constant_world((0.5, 0.6, 0.7))
    scene = make_scene([floor(3.0)], [diffuse()], world, camera, transparent_film=transparent)
    layers, _ = make_picture(scene, pixel_filter=pixel_filter, max_samples=8)
    corner, rim = layers["combined"][0, 0], layers["combined"][12, 1]
    np.testing.assert_array_equal(corner, [0.0, 0.0, 0.0, 1.0])
    assert layers["depth"][0, 0, 0] == 1e10 and layers["samples"][0, 0, 0] == 0.0
    np.testing.assert_allclose(rim, [0.0] * 4 if transparent else [0.5, 0.6, 0.7, 1.0], rtol=1e-6)


def test_a_moving_camera_blurs_along_its_way():
    """An orthographic camera that goes 8 pixels to the right: an edge becomes a ramp of 8."""
    camera = camera_above(48, 8, half=0.9)
    matrices = np.tile(camera.camera_to_world, (2, 1, 1))
    pixel = 1.8 / 48
    matrices[:, 0, 3] = -4.0 * pixel, 4.0 * pixel
    motion = CameraMotion(matrices, np.tile(camera.window, (2, 1)), np.array([0.0, 1.0]))
    edge = quad((0.0, -5.0, 0.0), (5.0, 0.0, 0.0), (0.0, 10.0, 0.0))
    light = [black(emission=(1.0,) * 3)]
    scene = make_scene(
        [edge], light, constant_world((0.0,) * 3), dataclasses.replace(camera, motion=motion)
    )
    layers, _ = make_picture(scene, pixel_filter="BOX", stop_rule="FIXED", max_samples=1024)
    seen = layers["combined"][..., 0].mean(axis=0)
    ramp = np.clip((np.arange(48) + 0.5 - 24 + 4) / 8.0, 0.0, 1.0)
    np.testing.assert_allclose(seen, ramp, atol=0.01)  # 256 stratified points x 8 rows

"""oidn.py, denoise.py, denoised_render.py: the noise goes, everything else stays as it was."""

import ctypes.util
import dataclasses
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from iwis.core import denoised_render
from iwis.core.data.program import Program
from iwis.core.denoised_render import render_denoised
from iwis.core.denoising.denoise import (
    DATA_LAYERS,
    NOISY,
    Denoising,
    Guided,
    data_layers,
    denoise_apart,
    prepared,
)
from iwis.core.denoising.oidn import Device, as_image, load_library
from iwis.core.film import LAYERS, NO_DEPTH, Film
from iwis.core.render import render
from iwis.core.scene import Lens
from iwis.core.settings import DenoiseSettings, RenderSettings
from support.oidn_library import library
from support.scenes import varied_scene

FEW = RenderSettings(stop_rule="FIXED", max_samples=4, pixel_filter="CENTER", threads=1)
ON = DenoiseSettings(denoise=True)


@pytest.fixture(scope="module")
def scene():
    """96 x 72 pixels: enough for a picture to have neighbours."""
    return varied_scene(width=96, height=72)


def picture(scene, settings=FEW, denoise=None, data=False, film=None):
    """(layers, stats), denoised where settings for that are given."""
    film = film or Film(scene.camera.region)
    if denoise is None and not data:
        return film.layers, render(scene, settings, film)
    denoising = Denoising(denoise or DenoiseSettings(), library())
    return film.layers, render_denoised(scene, settings, denoising, data, film)


@pytest.fixture(scope="module")
def noisy(scene):
    return picture(scene)[0]


@pytest.fixture(scope="module")
def truth(scene):
    many = RenderSettings(stop_rule="FIXED", max_samples=4096, pixel_filter="CENTER", seed=5)
    return picture(scene, many)[0]


def error(layers, truth):
    """Root of the mean square of the difference, of the picture's colors."""
    difference = layers["combined"][..., :3] - truth["combined"][..., :3]
    return float(np.sqrt((difference.astype(np.float64) ** 2).mean()))


def test_the_noise_falls(scene, noisy, truth):
    """Of 4 samples; measured: to .26 of it (docs/decisions/0037-denoising.md)."""
    layers, stats = picture(scene, denoise=ON)
    assert error(layers, truth) < 0.5 * error(noisy, truth)
    assert stats.warnings == [] and stats.seconds["denoising"] > 0.0 and not stats.cancelled


@pytest.mark.parametrize("passes", ["NONE", "ALBEDO", "ALBEDO_NORMAL"])
@pytest.mark.parametrize("prefilter", ["NONE", "FAST", "ACCURATE"])
def test_every_choice_lowers_the_error(scene, noisy, truth, passes, prefilter):
    """Whatever is chosen, and in the fastest quality."""
    choice = {"denoise_passes": passes, "denoise_prefilter": prefilter}
    layers, _ = picture(
        scene, denoise=DenoiseSettings(denoise=True, denoise_quality="FAST", **choice)
    )
    assert error(layers, truth) < error(noisy, truth)


def test_only_colors_change_and_only_where_objects_are(scene, noisy):
    """Alpha, the other layers and pixels of the world alone keep their bits; noisy is what was."""
    layers, _ = picture(scene, denoise=ON)
    np.testing.assert_array_equal(layers[NOISY], noisy["combined"])
    for name in set(LAYERS) - {"combined"}:
        np.testing.assert_array_equal(layers[name], noisy[name], err_msg=name)
    combined = layers["combined"]
    np.testing.assert_array_equal(combined[..., 3], noisy["combined"][..., 3])
    world = noisy["samples"][..., 0] == 0
    world &= (noisy["emission"] == 0.0).all(axis=2)
    assert world.any() and not world.all()
    np.testing.assert_array_equal(combined[world], noisy["combined"][world])
    assert (combined[~world] != noisy["combined"][~world]).any(axis=1).mean() > 0.9


def test_a_transparent_film_stays_empty_around_objects():
    """No light leaks into pixels of alpha 0, beside the brightest edge too."""
    scene = dataclasses.replace(varied_scene(width=96, height=72), transparent_film=True)
    layers, _ = picture(scene, denoise=ON)
    empty = layers["combined"][..., 3] == 0.0
    assert empty.any() and (layers["combined"][empty] == 0.0).all()


def test_silhouettes_are_denoised_on_both_sides():
    """With one point a pixel of a filter: pixels that saw the world by chance change as well."""
    scene = varied_scene(width=96, height=72)
    settings = RenderSettings(stop_rule="FIXED", max_samples=8, threads=1)
    layers, _ = picture(scene, settings, denoise=ON)
    before, after = layers[NOISY][..., :3], layers["combined"][..., :3]
    world = (before == layers["environment"]).all(axis=2)
    changed = (before != after).any(axis=2)
    beside = np.zeros_like(world)
    for shift in (-1, 1):
        beside[:, 1:-1] |= ~world[:, 1 + shift : 95 + shift]
    assert changed[world & beside].mean() > 0.9
    assert not changed[world].all()


def test_how_far_a_blurred_silhouette_reaches_is_not_known(noisy, scene):
    """With a lens the world is denoised too; what is empty stays so."""
    guided = Guided.of_layers(noisy, scene)
    assert prepared(guided, ON, scene, FEW)[0].exact.sum() == guided.exact.sum() > 0
    camera = dataclasses.replace(scene.camera, lens=Lens(0.1, 2.0))
    blurred = dataclasses.replace(scene, camera=camera)
    box = dataclasses.replace(FEW, pixel_filter="BOX")
    assert not prepared(guided, ON, blurred, box)[0].exact.any()
    guided = guided._replace(combined=guided.combined.copy())
    guided.combined[:3, :3, 3] = 0.0
    assert prepared(guided, ON, blurred, box)[0].exact.sum() == 9


def test_guides_without_noise_are_not_filtered(noisy, scene):
    """One point a pixel; with cut-outs that draw lots, or a pixel filter, they may have some."""
    guided = Guided.of_layers(noisy, scene)
    for pixel_filter, expected in (("CENTER", "NONE"), ("BOX", "ACCURATE")):
        settings = dataclasses.replace(FEW, pixel_filter=pixel_filter)
        assert prepared(guided, ON, scene, settings)[1].denoise_prefilter == expected
    half = Program(ops=(), closures=(), transparent=(0.5, 0.5, 0.5))
    shaders = SimpleNamespace(programs=(None, half))
    leaves = SimpleNamespace(shaders=shaders, camera=scene.camera, motion=None)
    assert prepared(guided, ON, leaves, FEW)[1].denoise_prefilter == "ACCURATE"


def test_without_a_library_the_picture_is_there_and_a_warning(scene, noisy):
    """The reason is that of who looked for it; a path that is no library says so itself."""
    for denoising, said in (
        (Denoising(ON, "", "this one has none"), "keeps its noise: this one has none"),
        (Denoising(ON, "/no/library.so"), "keeps its noise: /no/library.so"),
    ):
        film = Film(scene.camera.region)
        stats = render_denoised(scene, FEW, denoising, False, film)
        assert len(stats.warnings) == 1 and said in stats.warnings[0] and not stats.cancelled
        np.testing.assert_array_equal(film.layers["combined"], noisy["combined"])


def test_another_library_is_refused_by_name():
    """Not with a crash at its first call."""
    with pytest.raises(OSError, match="version 2 of Open Image Denoise"):
        load_library(ctypes.util.find_library("m"))


class Stopping(Film):
    """A film that cancels as soon as it hears of denoising."""

    def __init__(self, region):
        super().__init__(region)
        self.asked_at = None

    def progress(self, progress):
        if progress.phase == "denoising" and self.asked_at is None:
            self.asked_at = time.perf_counter()

    def cancelled(self):
        return self.asked_at is not None


def test_a_cancel_while_denoising_leaves_the_noisy_picture(scene, noisy):
    """At once, with a warning; the library's thread ends by itself."""
    film = Stopping(scene.camera.region)
    layers, stats = picture(scene, denoise=ON, film=film)
    assert time.perf_counter() - film.asked_at < 0.2  # what a cancel may take
    assert stats.cancelled and "cancelled" in stats.warnings[0]
    np.testing.assert_array_equal(layers["combined"], noisy["combined"])
    for thread in threading.enumerate():
        if thread.name == "iwis-denoise":
            thread.join(10.0)
            assert not thread.is_alive()


def test_a_cancelled_render_is_not_denoised(scene, monkeypatch):
    """Half a picture would be smeared over its edges."""
    monkeypatch.setattr(denoised_render, "denoise_apart", None)

    class Never(Film):
        def cancelled(self):
            return True

    _, stats = picture(scene, denoise=ON, film=Never(scene.camera.region))
    assert stats.cancelled and stats.warnings == []


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 3e38])
def test_a_pixel_without_sense_spoils_no_other(noisy, scene, wrong):
    """What comes out is finite, and far from it the same as without it."""
    guided = Guided.of_layers(noisy, scene)
    spoilt = guided._replace(combined=guided.combined.copy())
    spoilt.combined[2, 3, 1] = wrong
    denoising = Denoising(ON, library())
    clean = denoise_apart(guided, denoising, 1, lambda fraction: True)
    got = denoise_apart(spoilt, denoising, 1, lambda fraction: True)
    kept = guided.exact.copy()
    kept[2, 3] = True
    assert np.isfinite(got[~kept]).all()
    far = np.abs(got[40:] - clean[40:])[~guided.exact[40:]]
    assert far.max() < 0.2 * clean[40:].max()  # the exposure that is guessed moves a little


def test_the_edges_of_a_picture_are_nearly_as_good_as_its_middle():
    """An even grey with noise: its outer three pixels are off by 1.5 times as much, 2.7 without a
    rim."""
    rng = np.random.default_rng(3)
    guided = Guided.empty(97, 71)
    guided.combined[..., :3] = rng.gamma(40.0, 0.7 / 40.0, (71, 97, 3))
    guided.albedo[:], guided.normal[..., 2] = 0.7, 1.0
    out = denoise_apart(guided, Denoising(ON, library()), 1, lambda fraction: True)[..., :3]
    far = np.abs(out - 0.7).mean(axis=2)
    edges = [part.mean() for part in (far[:3], far[-3:], far[:, :3], far[:, -3:])]
    assert np.mean(edges) < 2.0 * far[8:-8, 8:-8].mean()


def test_sizes_that_fill_no_block():
    """One pixel, one row: the library is asked for pictures of any size."""
    with Device(library(), 1) as device:
        for size in ((1, 1), (1, 37), (23, 2)):
            image = np.full((*size, 3), 0.5, np.float32)
            out = device.run({"color": image}, {"hdr": True})
            assert out.shape == image.shape and np.isfinite(out).all()
    for size in ((1, 1), (37, 1), (2, 23)):
        out = denoise_apart(Guided.empty(*size), Denoising(ON, library()), 1, lambda fraction: True)
        assert out.shape == (size[1], size[0], 4) and (out == 0.0).all()


def test_wrong_images_are_refused_with_the_librarys_words():
    """Two sizes at once: an error of ours, not a crash."""
    images = {"color": np.zeros((4, 4, 3), np.float32), "albedo": np.zeros((2, 4, 3), np.float32)}
    with Device(library(), 1) as device, pytest.raises(RuntimeError, match="Open Image Denoise"):
        device.run(images, {"hdr": True})


def test_images_are_copies_within_reason():
    """The picture itself is never written."""
    layer = np.array([[[np.nan, 1e20, -1e20, 7.0]]], np.float32)
    image = as_image(layer)
    assert image.shape == (1, 1, 3) and (np.abs(image) <= 1e8).all()
    assert np.isnan(layer[0, 0, 0])


def test_data_layers_are_of_the_camera(scene):
    """Unit normals towards the camera have z below 0; depth is along the ray, from clip_start."""
    layers, stats = picture(scene, data=True)
    assert {name: layers[name].shape[2] for name in DATA_LAYERS} == DATA_LAYERS
    assert NOISY not in layers and stats.seconds["denoising"] == 0.0
    hit = layers["depth"][..., 0] < NO_DEPTH
    normal = layers["denoising_normal"]
    np.testing.assert_allclose(np.linalg.norm(normal[hit], axis=1), 1.0, atol=1e-5)  # float32
    assert (normal[hit][:, 2] < 0.1).mean() > 0.99 and not normal[~hit].any()
    depth = layers["denoising_depth"][..., 0]
    away = layers["position"][hit] - scene.camera.camera_to_world[:3, 3]
    start = scene.camera.clip_start / layers["depth"][hit][:, 0]
    expected = np.linalg.norm(away, axis=1) * (1.0 - start)
    np.testing.assert_allclose(depth[hit], expected, rtol=1e-5)  # float32
    assert (depth[~hit] == NO_DEPTH).all()
    np.testing.assert_array_equal(layers["denoising_albedo"][~hit], layers["environment"][~hit])


def test_data_layers_know_no_exposure(scene):
    """Light that is seen itself counts as it is emitted; surfaces by their color alone."""
    brighter = dataclasses.replace(scene, exposure=4.0)
    one, four = (data_layers(picture(each)[0], each) for each in (scene, brighter))
    for name in DATA_LAYERS:
        np.testing.assert_allclose(one[name], four[name], rtol=1e-6, err_msg=name)  # one division

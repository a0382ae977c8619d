"""progressive.py: a coarse picture at once, the final one at the end, nothing after a stop."""

import dataclasses
import time

import numpy as np
import pytest

from iwis.core.camera.camera import rays_through
from iwis.core.data.asked_passes import AskedPasses, Matte, matte_ids
from iwis.core.denoising.denoise import Denoising, data_layers
from iwis.core.denoising.view_denoiser import ViewDenoiser
from iwis.core.machine.watch import Cancelled, StopFlag
from iwis.core.render_cache import RenderCache
from iwis.core.settings import DenoiseSettings, RenderSettings
from iwis.core.windows.coarse_pictures import STEPS, Pace, coarse_camera
from iwis.core.windows.progressive import render_progressive
from iwis.core.windows.shown_picture import SHOWN
from support.oidn_library import library
from support.scenes import camera_above, make_picture, varied_scene

SETTINGS = {"pixel_filter": "CENTER", "max_samples": 24, "error_threshold": 0.2, "tile_px": 16}


class Screen:
    """Takes pictures; sets an event at one of them."""

    def __init__(self, event=None, at=1):
        self.pictures, self._event, self._at = [], event, at

    def show(self, picture):
        layers = {name: layer.copy() for name, layer in picture.layers.items()}
        self.pictures.append(picture._replace(layers=layers))
        if self._event is not None and len(self.pictures) == self._at:
            self._event.set()


def run(scene, screen=None, restart=None, close=None, pace=None, denoiser=None, **settings):
    """All pictures that were shown."""
    screen = screen or Screen()
    render_progressive(
        scene,
        RenderSettings(**SETTINGS | settings),
        screen.show,
        RenderCache(),
        pace or Pace(),
        restart or StopFlag(),
        close or StopFlag(),
        denoiser,
    )
    return screen.pictures


@pytest.mark.parametrize(
    "settings",
    [{"pixel_filter": "CENTER"}, {"pixel_filter": "BOX"}, {"stop_rule": "FIXED"}],
)
def test_the_last_picture_is_as_good_as_the_final_render(settings):
    """FIXED, pixel centres: but for rounding. Else nearly so: PERCEPTUAL decides anew at each
    pause, and a window takes the first passes of a filter alone."""
    last = run(varied_scene(), **settings)[-1]
    final, _ = make_picture(varied_scene(), **SETTINGS | settings)
    assert last.converged and last.step == 1
    exact = settings == {"stop_rule": "FIXED"}
    for name in SHOWN if exact else ():
        # products are made anew after a pause: samples move by float32's last bits
        np.testing.assert_allclose(
            last.layers[name], final[name], rtol=1e-4, atol=1e-5, err_msg=name
        )
    samples = last.layers["samples"].mean() / final["samples"].mean()
    assert samples == pytest.approx(1.0, abs=0.0 if exact else 0.2)  # a round more, a round less
    light, expected = last.layers["combined"].mean(), final["combined"].mean()
    assert light == pytest.approx(expected, rel=0.02)  # of 1100 pixels with some 10 samples each


@pytest.mark.parametrize("shown", ["normal", "glossy_direct", "denoising_albedo", "matte"])
def test_every_picture_has_the_layer_that_is_looked_at(shown):
    """Coarse ones too; the last one's is the final render's, and no more is carried along."""
    scene = varied_scene()
    number = np.arange(len(scene.object_pass_index), dtype=np.int32)
    names = tuple(map(str, number))
    mattes = (Matte("matte", 3, False, number, names, matte_ids(names)),)
    asked = AskedPasses(shown=shown, mattes=mattes if shown == "matte" else ())
    scene = dataclasses.replace(scene, asked=asked)
    pictures = run(scene, stop_rule="FIXED")
    assert {picture.shown for picture in pictures} == {shown}
    assert all(set(picture.layers) == {*SHOWN, shown} for picture in pictures)
    assert all(picture.layers[shown].any() for picture in pictures)
    final, _ = make_picture(scene, **SETTINGS | {"stop_rule": "FIXED"})
    expected = (final | data_layers(final, scene))[shown]
    np.testing.assert_allclose(pictures[-1].layers[shown], expected, rtol=1e-4, atol=1e-5)


def test_pictures_get_finer_and_the_first_is_coarse():
    """The steps go down to 1; each picture covers the frame; only the last is converged."""
    pictures = run(varied_scene())
    steps = [picture.step for picture in pictures]
    assert steps[0] > 1 and steps == sorted(steps, reverse=True) and steps[-1] == 1
    assert [picture.converged for picture in pictures] == [False] * (len(steps) - 1) + [True]
    camera = varied_scene().camera
    for picture in pictures:
        x0, y0, x1, y1 = picture.region
        assert (x0, y0) == (0, 0)
        assert x1 * picture.step >= camera.width > (x1 - 1) * picture.step
        assert picture.layers["combined"].shape == (y1 - y0, x1 - x0, 4)


def test_coarse_pictures_show_the_same_light():
    """Their mean is the final picture's, as far as 4 samples of a part of the pixels tell."""
    pictures = run(varied_scene())
    final = pictures[-1].layers["combined"].mean()
    half = next(p for p in pictures if p.step == 2)
    assert half.layers["combined"].mean() == pytest.approx(final, rel=0.1)  # edges, noise


def test_restart_waits_for_the_first_picture():
    """Somebody who drags sees each place once, coarsely, even if the next is waiting already."""
    restart = StopFlag()
    restart.set()
    assert [picture.step > 1 for picture in run(varied_scene(), restart=restart)] == [True]


def test_close_shows_nothing_more():
    """Neither at the beginning nor between two rounds."""
    close = StopFlag()
    screen = Screen(close)
    assert len(run(varied_scene(), screen, restart=close, close=close)) == 1
    closed = StopFlag()
    closed.set()
    with pytest.raises(Cancelled):  # the BVH is not built either
        run(varied_scene(), close=closed)


def test_a_border_is_the_same_part_of_the_frame():
    """Its pixels are those of the whole frame."""
    region = (8, 8, 24, 24)
    whole = run(varied_scene(), stop_rule="FIXED")[-1].layers["combined"]
    part = run(varied_scene(region=region), stop_rule="FIXED")[-1]
    assert part.region == region
    np.testing.assert_array_equal(part.layers["combined"], whole[8:24, 8:24])


@pytest.mark.parametrize("step", STEPS[1:])
def test_a_coarse_pixel_is_where_its_fine_ones_are(step):
    """The ray through its middle is the fine camera's through the middle of those pixels."""
    fine = dataclasses.replace(camera_above(37, 23), region=(5, 3, 30, 20))
    coarse = coarse_camera(fine, step)
    x, y = np.array([0.5, 1.5]), np.array([0.5, 1.5])
    rays, expected = rays_through(coarse, x, y), rays_through(fine, x * step, y * step)
    for a, b in zip(rays, expected, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)  # float32 of numbers about 1
    x0, y0, x1, y1 = coarse.region
    assert x0 * step <= 5 and y0 * step <= 3 and x1 * step >= 30 and y1 * step >= 20


def test_pace_chooses_coarser_steps_where_points_are_slow():
    """A machine that takes ten times as long begins with a coarser picture."""
    camera = camera_above(800, 600)
    fast, slow = Pace(), Pace()
    for _ in range(20):
        fast.note(1000, 1e-4)
        slow.note(1000, 1e-1)
    assert fast.first_step(camera) == 2 and slow.first_step(camera) == STEPS[-1]


class Denoised(ViewDenoiser):
    """Denoises by settings of a view; counts how often, and what was shown with noise after it."""

    def __init__(self, start=1, library_path=None, **settings):
        super().__init__()
        own = DenoiseSettings(denoise=True, denoise_quality="FAST", **settings)
        self.denoising = Denoising(own, library() if library_path is None else library_path, "none")
        self.start, self.samples = start, []

    def take(self, guided, scene, settings, threads, samples, going):
        self.samples.append(samples)
        return super().take(guided, scene, settings, threads, samples, going)


def test_pictures_of_the_view_are_denoised():
    """From the first round on; the last one too, never the coarse ones; samples are the same."""
    plain = run(varied_scene(), stop_rule="FIXED")
    denoiser = Denoised()
    pictures = run(varied_scene(), denoiser=denoiser, stop_rule="FIXED")
    assert denoiser.samples[0] == 8 and denoiser.samples[-1] == SETTINGS["max_samples"]
    assert denoiser.shows and denoiser.problem == ""
    last, noisy = pictures[-1], plain[-1]
    assert last.converged
    np.testing.assert_array_equal(last.layers["samples"], noisy.layers["samples"])
    combined, before = last.layers["combined"], noisy.layers["combined"]
    np.testing.assert_array_equal(combined[..., 3], before[..., 3])
    assert (combined != before).any()
    for a, b in zip(pictures, plain, strict=False):
        if a.step > 1:
            np.testing.assert_array_equal(a.layers["combined"], b.layers["combined"])


def test_no_noise_comes_back_while_rounds_go_on():
    """Once a picture without noise was shown, none with noise follows."""
    denoiser, shown = Denoised(), []
    screen = Screen()
    show = screen.show

    def noting(picture):
        shown.append(denoiser.shows)
        show(picture)

    screen.show = noting
    run(varied_scene(), screen, denoiser=denoiser, stop_rule="FIXED", max_samples=64)
    assert shown[-1] and shown[shown.index(True) :].count(False) == 0


def test_the_view_is_denoised_from_the_start_sample_on():
    """A picture with fewer samples keeps its noise; a start beyond all of them: all do."""
    denoiser = Denoised(start=16)
    run(varied_scene(), denoiser=denoiser, stop_rule="FIXED")
    assert min(denoiser.samples) >= 16
    late = Denoised(start=1000)
    last = run(varied_scene(), denoiser=late, stop_rule="FIXED")[-1]
    plain = run(varied_scene(), stop_rule="FIXED")[-1]
    assert not late.shows
    np.testing.assert_array_equal(last.layers["combined"], plain.layers["combined"])


def test_a_picture_is_denoised_otherwise_without_sampling():
    """Other settings are seen to be missing; off: the picture with its noise."""
    denoiser = Denoised()
    run(varied_scene(), denoiser=denoiser, stop_rule="FIXED")
    assert not denoiser.outdated
    noisy = run(varied_scene(), stop_rule="FIXED")[-1].layers["combined"]
    own = denoiser.denoising
    denoiser.denoising = own._replace(settings=DenoiseSettings())
    assert denoiser.outdated
    np.testing.assert_array_equal(denoiser.again(lambda fraction: True), noisy)
    denoiser.denoising = own
    assert (denoiser.again(lambda fraction: True) != noisy).any() and not denoiser.outdated


def test_a_view_without_a_library_shows_its_noise_and_says_so():
    """The reason is kept for the panel of warnings."""
    denoiser = Denoised(library_path="")
    last = run(varied_scene(), denoiser=denoiser, stop_rule="FIXED")[-1]
    plain = run(varied_scene(), stop_rule="FIXED")[-1]
    np.testing.assert_array_equal(last.layers["combined"], plain.layers["combined"])
    assert denoiser.problem == "The view keeps its noise: none" and not denoiser.shows


def test_a_restart_does_not_wait_for_the_denoiser():
    """Somebody who turns the view goes on at once; the library ends by itself."""
    restart = StopFlag()
    denoiser = Denoised()
    asked = []

    def take(guided, scene, settings, threads, samples, going):
        restart.set()
        asked.append(time.perf_counter())
        return Denoised.take(denoiser, guided, scene, settings, threads, samples, going)

    denoiser.take = take
    run(varied_scene(width=320, height=240), restart=restart, denoiser=denoiser)
    assert len(asked) == 1 and time.perf_counter() - asked[0] < 0.1  # ten times its own wait

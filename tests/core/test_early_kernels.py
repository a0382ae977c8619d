"""Machine code is read while the hierarchy is built."""

import threading

import pytest

from iwis.core.film import Film
from iwis.core.machine import compile_apart
from iwis.core.render import render
from iwis.core.settings import PIXEL_FILTERS, STOP_RULES, RenderSettings
from iwis.core.tiles import early_kernels
from iwis.core.tiles.early_kernels import read_early, smallest_scene


@pytest.fixture
def nothing_begun(monkeypatch):
    monkeypatch.setattr(early_kernels, "_begun", set())


def _wait():
    for thread in threading.enumerate():
        if thread.name == "iwis-early":
            thread.join()


@pytest.mark.parametrize("pixel_filter", PIXEL_FILTERS)
def test_its_pixel_is_seen_and_lit(pixel_filter):
    film = Film((0, 0, 1, 1))
    render(smallest_scene(), RenderSettings(threads=1, pixel_filter=pixel_filter), film)
    assert 0.1 < film.layers["combined"][0, 0, 0] < 1.0


@pytest.mark.parametrize("stop_rule", STOP_RULES)
def test_each_kind_of_settings_once(nothing_begun, stop_rule):
    """With settings that a render takes, whatever they were; PAPER would build tables."""
    calls = []
    settings = RenderSettings(stop_rule=stop_rule, max_samples=4096, time_limit=100.0)
    for _ in range(2):
        read_early(settings, lambda *given: calls.append(given))
    read_early(RenderSettings(estimator="PAPER"), lambda *given: calls.append(given))
    _wait()
    ((scene, own, sink),) = calls
    assert own.stop_rule == stop_rule and own.max_samples == 8
    render(scene, own, sink)


def test_what_goes_wrong_is_left_to_the_render_itself(nothing_begun):
    def fails(*_):
        raise RuntimeError

    read_early(RenderSettings(), fails)
    _wait()


def test_what_waits_for_the_other_process_is_developed_and_rendered_again(
    nothing_begun, monkeypatch
):
    """So the rest is compiled meanwhile: the tile comes black at first, then with its light."""
    told, tiles = threading.Event(), []

    def wait(cancelled):
        if not told.is_set():
            told.set()
            monkeypatch.setattr(compile_apart, "_waiting", [1])
            while not cancelled():
                pass
            monkeypatch.setattr(compile_apart, "_waiting", [])
            return False
        return True

    def work(scene, settings, film):
        render(scene, settings, film)
        tiles.append(film.layers["combined"][0, 0, 0])

    monkeypatch.setattr(compile_apart, "wait", wait)
    read_early(RenderSettings(), work)
    _wait()
    assert len(tiles) == 2 and tiles[0] == 0.0 < tiles[1]


def test_threads_that_wait_are_known_of(monkeypatch):
    asked = []

    class Runs:
        def poll(self):
            return None

    def cancelled():
        asked.append(compile_apart.is_awaited())
        return True

    monkeypatch.setattr(compile_apart, "_running", [Runs()])
    assert not compile_apart.is_awaited()
    assert not compile_apart.wait(cancelled)
    assert asked == [True] and not compile_apart.is_awaited()

"""The rendered view's own object: it lives as long as Blender's engine object for the region."""

import time

from iwis.core.denoising.denoise import Denoising
from iwis.core.settings import DenoiseSettings, RenderSettings
from iwis.iwis_addon.denoiser import find_library
from iwis.iwis_addon.view_thread import ViewThread
from iwis.iwis_addon.viewport import Viewport, living
from support.scenes import varied_scene


class Engine:
    """What of Blender's engine object the view's thread knows."""

    def tag_redraw(self):
        pass


def test_a_view_ends_with_its_engine_object():
    # A sleeping thread that held its view would keep the scene of every region ever shown.
    engine = Engine()
    engine.viewport = Viewport(engine)
    thread = engine.viewport.thread
    assert engine.viewport in living()
    assert thread.is_alive()
    del engine
    thread.join(5.0)
    assert not thread.is_alive()
    assert living() == []


def test_a_views_thread_denoises_what_it_shows_and_again_when_asked():
    """On: the picture has no noise. Off: it has, at once, and nothing is sampled again."""
    thread = ViewThread(lambda: None)
    settings = RenderSettings(stop_rule="FIXED", max_samples=8, pixel_filter="CENTER", threads=1)
    on = Denoising(DenoiseSettings(denoise=True, denoise_quality="FAST"), find_library()[0])
    thread.denoise(on, 1)
    thread.request(varied_scene(), settings)
    thread.start()
    try:
        clean = settled(thread)
        assert clean.converged and thread.denoiser.shows
        thread.denoise(Denoising(DenoiseSettings()), 1)
        noisy = settled(thread)
        assert not thread.denoiser.shows
        for name in clean.layers:
            same = clean.layers[name] is noisy.layers[name]
            assert same == (name != "combined"), name
        assert (clean.layers["combined"] != noisy.layers["combined"]).any()
    finally:
        thread.close()
        thread.join(10.0)


def settled(thread):
    """Its picture, once it sleeps."""
    deadline = time.monotonic() + 200.0  # a machine's first picture compiles the kernels
    while thread.working:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert thread.failure is None
    return thread.picture

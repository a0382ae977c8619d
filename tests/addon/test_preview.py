"""Previews of materials and worlds, with Blender's engine object played by the test."""

import threading
import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.job import RenderJob
from iwis.iwis_addon.preview import PreviewRender, preview_settings


class Engine:
    """Takes tiles as Blender's RenderEngine does, and cancels when told to."""

    def __init__(self):
        self.pixels = np.zeros((24, 32, 4), np.float32)
        self.stop = threading.Event()
        self.empty = 0

    def test_break(self):
        return self.stop.is_set()

    def get_result(self):
        return SimpleNamespace(views=[], resolution_x=32, resolution_y=24)

    def begin_result(self, x, y, width, height, layer, view):
        rect = SimpleNamespace(values=None)
        rect.foreach_set = lambda values: setattr(rect, "values", values)
        passes = SimpleNamespace(find_by_name=lambda name, view: SimpleNamespace(rect=rect))
        return SimpleNamespace(
            layers=[SimpleNamespace(passes=passes)], rect=rect, at=(x, y, width, height)
        )

    def end_result(self, result):
        x, y, width, height = result.at
        if result.rect.values is None:
            self.empty += 1
            return
        tile = np.reshape(result.rect.values, (height, width, 4))
        self.pixels[y : y + height, x : x + width] = tile


def run_preview(engine):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    preview = PreviewRender(engine, depsgraph)
    preview.export(depsgraph)
    preview.run(depsgraph)
    preview.complete()
    return preview


@pytest.mark.slow
def test_a_preview_is_a_picture_and_leaves_no_trace(cube_scene):
    """Whole, lit, and neither a job nor the engine's status line knows of it."""
    RenderJob.current = None
    engine = Engine()
    run_preview(engine)
    assert (engine.pixels[..., 3] == 1.0).all() and engine.empty == 0
    assert 0.2 < engine.pixels[..., :3].mean() < 1.0 and engine.pixels[..., :3].std() > 0.05
    assert RenderJob.current is None


def test_lamps_alone_light_a_preview(cube_scene):
    """Blender's preview scene has lamps and a world that is nearly black."""
    cube_scene.world = None
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.location = 500.0, (0.0, 0.0, 4.0)
    cube_scene.collection.objects.link(lamp)
    engine = Engine()
    run_preview(engine)
    assert engine.pixels[..., :3].max() > 0.1


def test_a_cancelled_preview_ends_at_once(cube_scene):
    """Within .1 s, whatever the core does; an empty picture where no tile was done."""
    cube_scene.render.resolution_x = cube_scene.render.resolution_y = 2000
    engine = Engine()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    preview = PreviewRender(engine, depsgraph)
    preview.export(depsgraph)
    preview._render = lambda relay: time.sleep(1.0)  # a core that does not listen
    asked = []
    timer = threading.Timer(0.2, lambda: (asked.append(time.monotonic()), engine.stop.set()))
    timer.start()
    preview.run(depsgraph)
    assert time.monotonic() - asked[0] < 0.1
    preview.complete()
    assert engine.empty == 1


def test_the_users_settings_do_not_slow_a_preview(cube_scene):
    """Samples and threshold are a preview's own."""
    cube_scene.iwis.max_samples, cube_scene.iwis.stop_rule = 4096, "FIXED"
    settings = preview_settings(cube_scene)
    assert settings.max_samples <= 64 and settings.stop_rule == "PERCEPTUAL"

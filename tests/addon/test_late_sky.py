"""Skies in a window: what is there at once, the right one later, one process at a time."""

import threading
import types

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.images import sky
from iwis.iwis_addon.export.images.sky import SkyError
from iwis.iwis_addon.export.worlds import late_sky
from iwis.iwis_addon.export.worlds.late_sky import LateSkies

SECONDS = 10.0


class Kitchen:
    """In place of sky.render_sky: skies whose texels are the sun's elevation, when let out."""

    def __init__(self, monkeypatch, tmp_path):
        monkeypatch.setenv("IWIS_CACHE_DIR", str(tmp_path))
        monkeypatch.setattr(sky, "_LAST", {})
        monkeypatch.setattr(late_sky, "render_sky", self.render)
        monkeypatch.setattr(late_sky, "_REST_SECONDS", 0.0)
        self.begun, self.child = [], types.SimpleNamespace(killed=False, kill=self.kill)
        self.out = threading.Semaphore(0)
        self.failing = False
        self.news = threading.Semaphore(0)

    def render(self, wanted, launch, started):
        elevation = float(wanted.settings.split('"sun_elevation": ')[1].split(",")[0])
        self.begun.append(round(elevation, 3))
        started(self.child)
        assert self.out.acquire(timeout=SECONDS)
        if self.failing or self.child.killed:
            raise SkyError("no process")
        return np.full((2, 4, 3), elevation, np.float32)

    def kill(self):
        self.child.killed = True
        self.out.release()

    def serve(self):
        self.out.release()
        assert self.news.acquire(timeout=SECONDS)


@pytest.fixture
def kitchen(monkeypatch, tmp_path):
    return Kitchen(monkeypatch, tmp_path)


@pytest.fixture
def skies(kitchen):
    skies = LateSkies(kitchen.news.release)
    yield skies
    skies.close()


@pytest.fixture
def node(cube_scene):
    tree = cube_scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    background = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground")
    tree.links.new(node.outputs[0], background.inputs["Color"])
    node.sun_elevation = 0.1
    return node


def read(skies, *nodes):
    skies.begin()
    return [skies.read(node) for node in nodes]


def test_nothing_waits_for_a_sky(kitchen, skies, node):
    """None at first, then the one before, each until the right one is there."""
    assert read(skies, node) == [None]
    assert skies.waiting and not skies.take()
    kitchen.serve()
    assert skies.take() and not skies.take()
    (first,) = read(skies, node)
    assert first.mean() == pytest.approx(0.1) and not skies.waiting
    node.sun_elevation = 0.2
    assert read(skies, node)[0] is first and skies.waiting
    kitchen.serve()
    assert read(skies, node)[0].mean() == pytest.approx(0.2) and not skies.waiting


def test_a_dragged_slider_skips_what_nobody_asks_for_any_more(kitchen, skies, node):
    for elevation in (0.1, 0.2, 0.3, 0.4):
        node.sun_elevation = elevation
        read(skies, node)
        while not kitchen.begun:
            skies._thread.join(0.01)
    kitchen.serve()
    assert skies.take()  # the first, nearer than nothing
    assert read(skies, node)[0].mean() == pytest.approx(0.1) and skies.waiting
    kitchen.serve()
    assert read(skies, node)[0].mean() == pytest.approx(0.4) and not skies.waiting
    assert kitchen.begun == [0.1, 0.4]


def test_a_slider_is_waited_for_until_it_rests(kitchen, skies, node, monkeypatch):
    """Of one that is dragged for a moment only the last place is rendered."""
    monkeypatch.setattr(late_sky, "_REST_SECONDS", 0.5)
    for elevation in (0.1, 0.2, 0.3, 0.4):
        node.sun_elevation = elevation
        read(skies, node)
        skies._thread.join(0.02)
    kitchen.serve()
    assert read(skies, node)[0].mean() == pytest.approx(0.4)
    assert kitchen.begun == [0.4]
    monkeypatch.setattr(late_sky, "_LONGEST_SECONDS", 0.1)  # it does not rest: it has to come
    monkeypatch.setattr(late_sky, "_REST_SECONDS", SECONDS)
    node.sun_elevation = 0.5
    read(skies, node)
    kitchen.serve()
    assert read(skies, node)[0].mean() == pytest.approx(0.5)


def test_two_skies_of_a_tree_come_one_after_the_other(kitchen, skies, node):
    other = node.id_data.nodes.new("ShaderNodeTexSky")
    other.sun_elevation = 0.7
    assert read(skies, node, other) == [None, None]
    kitchen.serve()
    kitchen.serve()
    found = read(skies, node, other)
    assert [sky.mean() for sky in found if sky is not None] == pytest.approx([0.1, 0.7])
    assert not skies.waiting


def test_a_sky_that_fails_says_so_and_is_not_tried_again(kitchen, skies, node):
    kitchen.failing = True
    read(skies, node)
    kitchen.serve()
    for _ in range(2):
        with pytest.raises(SkyError, match="no process"):
            read(skies, node)
    assert len(kitchen.begun) == 1 and not skies.waiting


def test_a_window_that_closes_ends_the_process(kitchen, skies, node):
    read(skies, node)
    thread = skies._thread
    while not kitchen.begun:
        thread.join(0.01)
    skies.close()
    thread.join(SECONDS)
    assert kitchen.child.killed and not thread.is_alive()
    node.sun_elevation = 0.3
    read(skies, node)
    assert len(kitchen.begun) == 1


def test_an_export_goes_on_with_one_colour(kitchen, skies, node):
    """Of the size of the sky's light and without a warning; then with the sky."""
    cache, live = ExportCache(), LiveExport()
    cache.texels.skies = skies

    def export():
        live.begin([])
        lines = []
        graph = bpy.context.evaluated_depsgraph_get()
        return export_scene(graph, warnings=lines, cache=cache, live=live).environment, lines

    light, lines = export()
    assert light.radiance.shape[:2] == (1, 1) and light.strength.min() > 0.5 and lines == []
    assert export()[0] is light
    kitchen.serve()
    live.forget_world()
    light, lines = export()
    assert light.radiance.mean() == pytest.approx(0.1) and lines == []

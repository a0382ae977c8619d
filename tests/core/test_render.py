"""core/render.py: the same picture whatever the threads, tiles, region and company."""

import dataclasses
import threading

import numpy as np
import pytest

from iwis.core.film import LAYERS, Film
from iwis.core.render import prepare_tables, render, worker_count
from iwis.core.render_cache import RenderCache
from iwis.core.settings import RenderSettings
from support.scenes import (
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_picture,
    make_scene,
    varied_scene,
)

BOTH = pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])


@pytest.fixture(scope="module")
def pictures(table_dir):
    """make_picture of the varied scene with shared tables; the standard picture of an estimator."""

    class Pictures:
        def __init__(self):
            self._standard = {}

        def make(self, estimator, scene=None, cache=None, **settings):
            settings = {"max_samples": 20, "cache_dir": table_dir} | settings
            return make_picture(scene or varied_scene(), cache, estimator=estimator, **settings)[0]

        def standard(self, estimator):
            if estimator not in self._standard:
                self._standard[estimator] = self.make(estimator)
            return self._standard[estimator]

    return Pictures()


def _assert_same(layers, expected):
    assert set(layers) == set(expected) == set(LAYERS)
    for name, layer in expected.items():
        np.testing.assert_array_equal(layers[name], layer, err_msg=name)


def _assert_finite(layers):
    for name, layer in layers.items():
        assert np.isfinite(layer).all(), name


@BOTH
@pytest.mark.parametrize("threads", [2, 3])
def test_threads_do_not_change_the_picture(estimator, threads, pictures):
    """Bit for bit, in every layer."""
    layers = pictures.make(estimator, threads=threads, tile_px=8)
    _assert_same(layers, pictures.standard(estimator))


@BOTH
@pytest.mark.parametrize("tile_px", [8, 13, 256])
def test_tiles_do_not_change_the_picture(estimator, tile_px, pictures):
    """Small, odd, and one for all."""
    _assert_same(pictures.make(estimator, tile_px=tile_px), pictures.standard(estimator))


@BOTH
@pytest.mark.parametrize("region", [(0, 0, 40, 28), (11, 5, 30, 23), (39, 27, 40, 28)])
def test_a_border_is_a_part_of_the_whole(estimator, region, pictures):
    """The same bits in the region's pixels, down to a single one."""
    x0, y0, x1, y1 = region
    part = pictures.make(estimator, varied_scene(region=region), tile_px=8)
    whole = pictures.standard(estimator)
    _assert_same(part, {name: layer[y0:y1, x0:x1] for name, layer in whole.items()})


@BOTH
def test_two_renders_at_once_do_not_disturb_each_other(estimator, pictures):
    """A final render beside a viewport: two threads, two threads each."""
    results = [None, None]

    def work(k):
        results[k] = pictures.make(estimator, threads=2, tile_px=8)

    workers = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    for layers in results:
        _assert_same(layers, pictures.standard(estimator))


@BOTH
def test_a_used_cache_does_not_change_the_picture(estimator, pictures):
    """Neither the same scene again nor another world and mesh in between."""
    cache = RenderCache()
    _assert_same(pictures.make(estimator, cache=cache), pictures.standard(estimator))
    if estimator == "UNBIASED":
        other = make_scene(
            [box((-1, -1, 0), (1, 1, 1))], [diffuse()], constant_world(), camera_above()
        )
        pictures.make(estimator, other, cache)
    _assert_same(pictures.make(estimator, cache=cache), pictures.standard(estimator))


@BOTH
def test_seeds_differ_and_return(estimator, pictures):
    """Another seed, another noise but the same geometry; the first seed, the first picture."""
    first, second = (pictures.make(estimator, seed=seed) for seed in (0, 1))
    assert (first["visibility"] != second["visibility"]).any()
    np.testing.assert_array_equal(first["position"], second["position"])
    _assert_same(first, pictures.standard(estimator))


@BOTH
def test_without_decorrelation_all_pixels_share_their_points(estimator, table_dir):
    """The same place in 256 pixels: one value with NONE, many with PIXEL.

    One but for the last bit of the position, which PAPER's grid of normals stretches to 2e-4.
    """
    world = gradient_world()
    scene = make_scene(
        [floor(), box((0.2, -1, 0), (0.4, 1, 0.5))],
        [diffuse(), diffuse()],
        world,
        camera_above(half=1e-7),  # a tenth of a micrometre: float32 knows one position here
    )
    settings = {"estimator": estimator, "max_samples": 16, "stop_rule": "FIXED"}
    for decorrelation, one in (("NONE", True), ("PIXEL", False)):
        layers, _ = make_picture(
            scene, decorrelation=decorrelation, cache_dir=table_dir, **settings
        )
        spread = np.ptp(layers["combined"][..., 0]) / layers["combined"][..., 0].mean()
        assert spread < 1e-3 if one else spread > 1e-2


@BOTH
def test_no_layer_holds_nan_or_infinity(estimator, pictures):
    """Not even the error of pixels that saw nothing."""
    layers = pictures.standard(estimator)
    _assert_finite(layers)
    assert (layers["visibility"] <= 1.0).all() and (layers["combined"] >= 0.0).all()


def test_worker_count_is_the_setting_or_the_cores():
    """0 means all that this process may use."""
    assert worker_count(RenderSettings(threads=3)) == 3
    cores = worker_count(RenderSettings(threads=0))
    assert cores >= 1
    assert worker_count(RenderSettings(threads=1024)) == min(4 * cores, 1024)


def test_statistics_count_what_was_done(table_dir):
    """Pixels, rays and phases, as the command line prints them."""
    scene = varied_scene()
    layers, stats = make_picture(scene, max_samples=16, stop_rule="FIXED")
    shaded = int((layers["depth"] < 1e9).sum())
    assert (stats.width, stats.height) == (40, 28)
    assert stats.triangles == len(scene.mesh.triangles)
    assert stats.primary_rays == 40 * 28 and stats.shaded_pixels == shaded
    assert stats.samples_max == 16 and stats.samples_total == layers["samples"].sum()
    assert 0 < stats.shadow_rays <= stats.samples_total + shaded  # one ahead for each (scouts.py)
    assert not stats.cancelled and stats.warnings == []
    assert stats.seconds["sampling"] > 0.0


@pytest.mark.slow
def test_prepared_tables_are_those_of_the_render(table_dir, tmp_path):
    """A farm's first job: the render after it reads all and writes none."""
    scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above(4, 4))
    settings = RenderSettings(estimator="UNBIASED", cache_dir=str(tmp_path), threads=1)
    stats = prepare_tables(scene, settings, Film(scene.camera.region))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npz")}
    assert len(before) == 2 and stats.seconds["tables"] > 0.0  # the light's table, its quadtree
    render(scene, dataclasses.replace(settings, estimator="PAPER"), Film(scene.camera.region))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npz")} == before


def test_mesh_is_not_written_to():
    """Scenes are shared between renders."""
    scene = varied_scene()
    before = [array.copy() for array in (scene.mesh.vertices, scene.environment.radiance)]
    make_picture(scene, max_samples=8)
    for array, copy in zip((scene.mesh.vertices, scene.environment.radiance), before, strict=True):
        np.testing.assert_array_equal(array, copy)

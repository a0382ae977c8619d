"""core/render.py: the same picture whatever the threads, tiles, region and company."""

import dataclasses
import threading

import numpy as np
import pytest

from iwis.core.camera import camera_rays
from iwis.core.environment import eval_environment_many, make_lookup
from iwis.core.film import LAYERS, Film
from iwis.core.render import prepare_tables, render, tile_rects, worker_count
from iwis.core.render_cache import RenderCache
from iwis.core.scene import MaterialParams
from iwis.core.settings import RenderSettings
from support.scenes import (
    black,
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_materials,
    make_picture,
    make_scene,
    principled,
    sphere,
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
    """The same place in 256 pixels: one value with NONE, many with PIXEL."""
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
        values = np.unique(layers["combined"].reshape(-1, 4), axis=0)
        assert (len(values) == 1) == one


@BOTH
def test_no_layer_holds_nan_or_infinity(estimator, pictures):
    """Not even the error of pixels that saw nothing."""
    layers = pictures.standard(estimator)
    _assert_finite(layers)
    assert (layers["visibility"] <= 1.0).all() and (layers["combined"] >= 0.0).all()


@BOTH
def test_an_empty_mesh_is_a_picture_of_the_world(estimator, table_dir):
    """Every pixel is the world in its direction, without a sample."""
    world = gradient_world()
    camera = varied_scene().camera
    layers, stats = make_picture(
        make_scene([], [], world, camera), estimator=estimator, cache_dir=table_dir
    )
    _, directions = camera_rays(camera, 0, 0, camera.width, camera.height)
    expected = np.empty((len(directions), 3), np.float32)
    eval_environment_many(make_lookup(world), directions, expected)
    expected = expected.reshape(camera.height, camera.width, 3)
    np.testing.assert_array_equal(layers["combined"][..., :3], expected)
    np.testing.assert_array_equal(layers["environment"], expected)
    assert (layers["depth"] == 1e10).all() and (layers["combined"][..., 3] == 1.0).all()
    assert not layers["samples"].any()
    assert (stats.shaded_pixels, stats.samples_total, stats.shadow_rays) == (0, 0, 0)


@BOTH
def test_a_black_world_is_black_and_costs_nothing(estimator, table_dir):
    """No light: no sample, no ray, and emission is still seen."""
    scene = make_scene(
        [floor(), sphere(radius=0.3)],
        [principled(roughness=0.4), black(emission=(1.0, 2.0, 3.0))],
        constant_world((0.0, 0.0, 0.0)),
        camera_above(),
    )
    layers, stats = make_picture(scene, estimator=estimator, cache_dir=table_dir)
    _assert_finite(layers)
    assert not layers["samples"].any() and stats.shadow_rays == 0
    glowing = layers["object_index"][..., 0] == 21.0
    assert glowing.any() and stats.shaded_pixels == 256
    np.testing.assert_array_equal(layers["combined"][glowing][:, :3], layers["emission"][glowing])
    assert not layers["combined"][~glowing][:, :3].any()


def test_zero_strength_is_a_black_world():
    """As a user switches the light off."""
    world = gradient_world(strength=np.zeros(3, np.float32))
    layers, stats = make_picture(make_scene([floor()], [diffuse()], world, camera_above()))
    assert stats.samples_total == 0 and not layers["combined"][..., :3].any()


@BOTH
def test_bad_triangles_and_normals_leave_no_nan(estimator, table_dir):
    """Zero areas, NaN corners, corner normals that cancel, are NaN or point away."""
    vertices, triangles, _ = floor()
    broken = np.zeros((2, 3, 3))
    broken[1, 1] = np.nan
    turned = sphere((0, 0, 0.5), 0.3, rings=6, smooth=True)
    one, up = np.array([[0, 1, 2]]), np.ones((1, 3, 3))
    nan = np.array([[np.nan, 0, 1], [1, 0, 1], [0, 1, 1]]), one, up
    point = np.full((3, 3), 2.0), one, up
    scene = make_scene(
        [(vertices, triangles, broken), (*turned[:2], -turned[2]), nan, point],
        [principled(roughness=0.4), principled(roughness=0.4, metallic=1.0), *[diffuse()] * 2],
        gradient_world(),
        camera_above(),
    )
    layers, stats = make_picture(
        scene, estimator=estimator, cache_dir=table_dir, max_samples=16, coefficients=0.05
    )
    _assert_finite(layers)
    assert stats.shaded_pixels == 256


def test_parameters_out_of_range_leave_no_nan():
    """Roughness 0 and above 1, index 1 and 0, metallic 2, colours above 1 and below 0."""
    rows = [
        principled(roughness=0.0),
        principled(roughness=3.0, metallic=2.0),
        principled(ior=1.0),
        principled(ior=0.0, specular_level=9.0),
        principled(base_color=(-1.0, 2.0, 50.0), specular_tint=(9.0, 0.0, -1.0)),
    ]
    parts = [sphere((0.35 * k - 0.7, 0, 0.2), 0.17, rings=6) for k in range(5)]
    scene = make_scene(parts, rows, gradient_world(), camera_above())
    layers, _ = make_picture(scene, max_samples=32)
    _assert_finite(layers)


def test_one_row_of_materials_is_enough_for_nan_to_spread_no_further():
    """A NaN colour spoils its own pixels only."""
    materials = make_materials(diffuse(), diffuse((np.nan, 0.5, 0.5)))
    scene = make_scene(
        [floor(), box((0, 0, 0), (0.5, 0.5, 0.5))],
        [diffuse(), diffuse()],
        gradient_world(),
        camera_above(),
    )
    scene = dataclasses.replace(scene, materials=MaterialParams(*materials))
    layers, _ = make_picture(scene, max_samples=16)
    clean = layers["object_index"][..., 0] == 20.0
    assert clean.any() and np.isfinite(layers["combined"][clean]).all()


def test_tile_rects_cover_the_region_once():
    """Every pixel in one tile, none outside; those at the centre come first."""
    for region in ((0, 0, 40, 28), (3, 7, 4, 8), (5, 0, 37, 65)):
        x0, y0, x1, y1 = region
        for tile_px in (8, 32, 256):
            count = np.zeros((y1, x1), int)
            rects = tile_rects(region, tile_px)
            for x, y, width, height in rects:
                count[y : y + height, x : x + width] += 1
            assert (count[y0:y1, x0:x1] == 1).all() and count.sum() == (x1 - x0) * (y1 - y0)
            middle = [
                (x + w / 2 - (x0 + x1) / 2) ** 2 + (y + h / 2 - (y0 + y1) / 2) ** 2
                for x, y, w, h in rects
            ]
            assert middle == sorted(middle)


def test_worker_count_is_the_setting_or_the_cores():
    """0 means all that this process may use."""
    assert worker_count(RenderSettings(threads=3)) == 3
    assert worker_count(RenderSettings(threads=0)) >= 1


def test_statistics_count_what_was_done(table_dir):
    """Pixels, rays and phases, as the command line prints them."""
    scene = varied_scene()
    layers, stats = make_picture(scene, max_samples=16, stop_rule="FIXED")
    shaded = int((layers["depth"] < 1e9).sum())
    assert (stats.width, stats.height) == (40, 28)
    assert stats.triangles == len(scene.mesh.triangles)
    assert stats.primary_rays == 40 * 28 and stats.shaded_pixels == shaded
    assert stats.samples_max == 16 and stats.samples_total == layers["samples"].sum()
    assert 0 < stats.shadow_rays <= stats.samples_total
    assert not stats.cancelled and stats.warnings == []
    assert stats.seconds["sampling"] > 0.0


def test_prepared_tables_are_those_of_the_render(table_dir, tmp_path):
    """A farm's first job: the render after it reads all and writes none."""
    scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above(4, 4))
    settings = RenderSettings(estimator="UNBIASED", cache_dir=str(tmp_path), threads=1)
    stats = prepare_tables(scene, settings, Film(scene.camera.region))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npz")}
    assert len(before) == 1 and stats.seconds["tables"] > 0.0
    render(scene, dataclasses.replace(settings, estimator="PAPER"), Film(scene.camera.region))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npz")} == before


def test_mesh_is_not_written_to():
    """Scenes are shared between renders."""
    scene = varied_scene()
    before = [array.copy() for array in (scene.mesh.vertices, scene.environment.radiance)]
    make_picture(scene, max_samples=8)
    for array, copy in zip((scene.mesh.vertices, scene.environment.radiance), before, strict=True):
        np.testing.assert_array_equal(array, copy)

"""core/render.py: a picture, finite and right, from scenes that are empty, dark or broken."""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera.camera import camera_rays
from iwis.core.light.environment import eval_environment_many, make_lookup
from iwis.core.scene import MaterialParams
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


def _assert_finite(layers):
    for name, layer in layers.items():
        assert np.isfinite(layer).all(), name


@BOTH
def test_an_empty_mesh_is_a_picture_of_the_world(estimator, table_dir):
    """Every pixel is the world in its direction, without a sample."""
    world = gradient_world()
    camera = varied_scene().camera
    layers, stats = make_picture(
        make_scene([], [], world, camera), estimator=estimator, cache_dir=table_dir
    )
    _, directions, _ = camera_rays(camera, 0, 0, camera.width, camera.height)
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


def test_a_nan_colour_spoils_its_own_pixels_only():
    """Others in the same tile are as they should be."""
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

"""core/passes/develop.py: what each layer of a picture holds."""

import dataclasses

import numpy as np
import pytest

from support.scenes import (
    black,
    camera_above,
    constant_world,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_picture,
    make_scene,
    quad,
)

TILT = quad((-0.5, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 1.0))


def _scene(**fields):
    """A tilted quad that fills the middle of the picture, the world at its sides."""
    return make_scene(
        [TILT], [diffuse()], constant_world((0.2, 0.5, 1.0)), camera_above(), **fields
    )


def _shown(layers):
    return layers["depth"][..., 0] < 1e9


def test_geometry_layers_are_those_of_the_first_hit():
    """Depth along the axis, position and normal in the world, by the quad's equation."""
    layers, _ = make_picture(_scene(), max_samples=8)
    shown = _shown(layers)
    centres = (np.arange(16) + 0.5) / 16 * 1.8 - 0.9
    x, y = np.meshgrid(centres, centres)
    expected = np.stack([x, y, (y + 1.0) / 2.0], -1)
    np.testing.assert_array_equal(shown, np.abs(x) < 0.5)
    np.testing.assert_allclose(layers["position"][shown], expected[shown], atol=1e-6)  # float32
    depth = 10.0 - expected[..., 2]
    np.testing.assert_allclose(layers["depth"][..., 0][shown], depth[shown], rtol=1e-6)
    normal = np.array([0.0, -1.0, 2.0]) / np.sqrt(5.0)
    np.testing.assert_allclose(
        layers["normal"][shown], np.tile(normal, (shown.sum(), 1)), atol=1e-6
    )


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_all_that_is_seen_is_all_of_the_light(pixel_filter):
    """Nothing is in the way: visibility is 1 but for rounding, and never more."""
    layers, _ = make_picture(_scene(), max_samples=32, pixel_filter=pixel_filter)
    seen = layers["visibility"][..., 0][:, 6:10]  # the quad's, all of each pixel
    assert 0.999999 < seen.min() and layers["visibility"].max() <= 1.0


def test_index_layers_are_the_passes_values():
    """The values of the scene's tables, not row numbers; 0 where the world is seen."""
    scene = make_scene(
        [TILT, floor(0.2, z=2.0)], [diffuse(), glossy(0.3)], gradient_world(), camera_above()
    )
    layers, _ = make_picture(scene, max_samples=8)
    assert set(np.unique(layers["object_index"])) == {0.0, 20.0, 21.0}
    assert set(np.unique(layers["material_index"])) == {0.0, 10.0, 11.0}
    np.testing.assert_array_equal(layers["object_index"] > 0, layers["depth"] < 1e9)


def test_the_world_is_in_combined_and_environment():
    """And nowhere else; nothing of it where something is hit."""
    layers, _ = make_picture(_scene(), max_samples=8)
    sky = ~_shown(layers)
    expected = np.tile(np.float32([0.2, 0.5, 1.0]), (sky.sum(), 1))
    np.testing.assert_allclose(layers["environment"][sky], expected, rtol=1e-6)
    np.testing.assert_allclose(layers["combined"][sky][:, :3], expected, rtol=1e-6)
    assert (layers["combined"][..., 3] == 1.0).all() and not layers["environment"][~sky].any()
    assert (layers["depth"][sky] == 1e10).all()
    for name in ("position", "normal", "samples", "diffuse_color", "unoccluded"):
        assert not layers[name][sky].any(), name


def test_transparent_film_leaves_the_world_out():
    """Alpha 0 and black where the world is seen; the Environment pass keeps it, as in Cycles."""
    opaque, _ = make_picture(_scene(), max_samples=8)
    layers, _ = make_picture(_scene(transparent_film=True), max_samples=8)
    sky = ~_shown(layers)
    assert not layers["combined"][sky].any()
    np.testing.assert_array_equal(layers["combined"][~sky], opaque["combined"][~sky])
    np.testing.assert_array_equal(layers["environment"], opaque["environment"])


def test_worlds_hidden_from_the_camera_still_light():
    """Ray visibility: black behind, lit in front."""
    scene = _scene()
    world = dataclasses.replace(scene.environment, visible_to_camera=False)
    layers, _ = make_picture(dataclasses.replace(scene, environment=world), max_samples=8)
    sky = ~_shown(layers)
    assert not layers["combined"][sky][:, :3].any() and not layers["environment"].any()
    assert layers["combined"][~sky][:, :3].min() > 0.0


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_exposure_multiplies_light_only(pixel_filter):
    """Combined, light and I_s twice as bright, as in Cycles; colours, counts, errors unchanged."""
    one, _ = make_picture(_scene(), max_samples=16, pixel_filter=pixel_filter)
    two, _ = make_picture(_scene(exposure=2.0), max_samples=16, pixel_filter=pixel_filter)
    for name in ("diffuse_direct", "unoccluded", "glossy_direct", "emission", "environment"):
        np.testing.assert_allclose(two[name], 2.0 * one[name], rtol=1e-6, err_msg=name)  # float32
    np.testing.assert_allclose(two["combined"][..., :3], 2.0 * one["combined"][..., :3], rtol=1e-6)
    for name in ("diffuse_color", "samples", "error", "visibility", "depth"):
        np.testing.assert_array_equal(two[name], one[name], err_msg=name)


def test_emission_is_added():
    """A black emitter shows its radiance, in both layers."""
    scene = make_scene([TILT], [black(emission=(0.5, 2.0, 7.0))], constant_world(), camera_above())
    layers, _ = make_picture(scene)
    shown = _shown(layers)
    for layer in (layers["combined"][..., :3], layers["emission"]):
        np.testing.assert_array_equal(layer[shown], np.float32([[0.5, 2.0, 7.0]] * shown.sum()))


def test_black_colours_divide_to_zero():
    """Direct light without colour is not NaN where the colour is black in one channel."""
    scene = make_scene([TILT], [diffuse((0.0, 0.5, 1.0))], constant_world(), camera_above())
    layers, _ = make_picture(scene, max_samples=64)
    direct = layers["diffuse_direct"][_shown(layers)]
    assert not direct[:, 0].any()
    assert direct[:, 1:].mean() == pytest.approx(1.0, abs=0.02)  # 130 pixels x 64 samples


def test_hits_beyond_the_far_plane_are_not_seen():
    """clip_end cuts the picture, not the shadows."""
    scene = _scene()
    camera = dataclasses.replace(scene.camera, clip_end=9.5)
    layers, _ = make_picture(dataclasses.replace(scene, camera=camera), max_samples=8)
    shown = _shown(layers)
    assert shown.any() and layers["depth"][shown].max() <= 9.5
    whole, _ = make_picture(scene, max_samples=8)
    assert shown.sum() < _shown(whole).sum()


def test_hits_before_the_near_plane_are_looked_through():
    """A quad nearer than clip_start does not hide what is behind it."""
    near = floor(2.0, z=9.8)
    scene = make_scene([TILT, near], [diffuse(), diffuse()], constant_world(), camera_above())
    camera = dataclasses.replace(scene.camera, clip_start=0.5)
    layers, _ = make_picture(dataclasses.replace(scene, camera=camera), max_samples=8)
    assert set(np.unique(layers["object_index"])) == {0.0, 20.0}

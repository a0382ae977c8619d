"""Maps that trees of worlds are evaluated to: their texels, what is kept of them, what is told."""

import numpy as np
import pytest

from iwis.core.scene import EQUIRECTANGULAR
from iwis.core.surfaces.backdrop import Backdrop
from iwis.iwis_addon.export import ExportCache, ExportCancelled
from iwis.iwis_addon.export.worlds import world_picture
from support.world_render import (
    add,
    link,
    new_image,
    new_world,
    noisy_world,
    read,
    some_texels,
    textured_world,
)


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


@pytest.fixture(autouse=True)
def small_maps(monkeypatch):
    """Few rows: what is tested is where they come from."""
    monkeypatch.setattr(world_picture, "LEAST_HEIGHT", 64)


def test_nothing_is_evaluated_again_while_the_tree_is_the_same(scene, tree):
    """Whatever its strength; a changed node gives another map, and the backdrop with it."""
    noise, background = noisy_world(tree)
    cache = ExportCache().texels
    first, _ = read(cache)
    scene.frame_set(2)
    background.inputs["Strength"].default_value = 2.0
    second, _ = read(cache)
    assert second.light.radiance is first.light.radiance
    assert second.light.strength[0] == 2.0 == second.backdrop.strength[0]
    third, _ = read(cache)
    assert third.backdrop is second.backdrop
    noise.inputs["Scale"].default_value = 7.0
    fourth, _ = read(cache)
    assert (fourth.light.radiance != first.light.radiance).any()
    assert fourth.backdrop is not third.backdrop


def test_painted_images_of_a_tree_are_looked_at(tree, texels):
    texture, background = textured_world(tree, new_image(texels))
    factor = add(tree, "TexGradient")
    tree.links.new(
        factor.outputs["Factor" if "Factor" in factor.outputs else 0], background.inputs["Strength"]
    )
    cache = ExportCache().texels
    first, _ = read(cache)
    assert read(cache)[0].light.radiance is first.light.radiance
    texture.image.pixels.foreach_set(np.full(8 * 16 * 4, 0.3, np.float32))
    assert (read(cache)[0].light.radiance != first.light.radiance).any()


def test_large_images_are_averaged_with_a_warning(tree, texels, monkeypatch):
    monkeypatch.setattr(world_picture, "LEAST_HEIGHT", 2)
    monkeypatch.setattr(world_picture, "MOST_HEIGHT", 4)
    _, background = textured_world(tree, new_image(texels))
    tree.links.new(add(tree, "TexGradient").outputs[0], background.inputs["Strength"])
    world, warnings = read()
    assert world.light.radiance.shape == (4, 8, 3)
    assert len(warnings) == 1 and "8 x 4" in warnings[0] and '"World"' in warnings[0]


def test_light_below_zero_stays(tree):
    """1 - 3 z: negative above, in the map that lights and before the camera, as in Cycles."""
    z, math, background = add(tree, "SeparateXYZ"), add(tree, "Math"), add(tree, "Background")
    math.operation = "MULTIPLY_ADD"
    math.inputs[1].default_value, math.inputs[2].default_value = -3.0, 1.0
    tree.links.new(add(tree, "TexCoord").outputs["Generated"], z.inputs[0])
    tree.links.new(z.outputs["Z"], math.inputs[0])
    link(tree, math, background, add(tree, "OutputWorld"))
    world, warnings = read()
    assert world.light.radiance.min() < -1.9 and world.light.radiance.max() > 3.9
    assert warnings == []
    up = np.float32([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(Backdrop(world.backdrop).radiance(up), -2.0, rtol=1e-6)


def test_an_image_texture_without_a_vector_is_one_colour(tree, texels):
    background = add(tree, "Background")
    link(tree, add(tree, "TexImage", image=new_image(texels)), background, add(tree, "OutputWorld"))
    world, warnings = read()
    assert np.ptp(world.light.radiance, axis=(0, 1)).max() < 1e-6
    assert len(warnings) == 1 and "as in Cycles" in warnings[0]


def test_the_same_texture_twice_is_one(tree, texels):
    """Node and copy show one image alike: its texels stay, nodes over them are applied."""
    _, background = textured_world(tree, new_image(texels))
    copy = add(tree, "TexEnvironment", image=tree.nodes["Environment Texture"].image)
    both = add(tree, "AddShader")
    second = add(tree, "Background")
    link(tree, copy, second)
    link(tree, background, both, tree.nodes["World Output"])
    tree.links.new(second.outputs[0], both.inputs[1])
    world, _ = read()
    np.testing.assert_allclose(world.light.radiance, 2.0 * texels, rtol=1e-6)
    assert world.light.projection == EQUIRECTANGULAR


def test_evaluation_can_be_stopped(tree):
    noisy_world(tree)
    with pytest.raises(ExportCancelled):
        read(cancelled=lambda: True)


def noise_is_refined(tree, monkeypatch, **values):
    """Whether a world of noise is looked at more closely."""
    noise, _ = noisy_world(tree, **{"Detail": 1.0, **values})
    mapping = add(tree, "Mapping", Scale=(1.0, 2.0, 1.0))
    link(tree, add(tree, "TexCoord"), mapping, noise)
    found = []

    def evaluate(program, value, height, *, has_edges, **rest):
        found.append(has_edges)
        return np.ones((height, 2 * height, 3), np.float32)

    monkeypatch.setattr(world_picture, "evaluate_map", evaluate)
    read()
    return found == [True]


@pytest.mark.parametrize(("scale", "refined"), [(1.0, False), (50.0, True)])
def test_smooth_noise_is_not_looked_at_closely(tree, monkeypatch, scale, refined):
    """A texel of 64 rows is 0.05 radians; the last octave changes over 1 / (scale x 2 x 2)."""
    assert noise_is_refined(tree, monkeypatch, Scale=scale) == refined

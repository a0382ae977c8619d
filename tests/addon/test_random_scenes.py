"""Two random scenes (`make random-scenes` renders many), and what would be told of them."""

import bpy
import numpy as np
import pytest
from random_scenes import glowing
from random_scenes.beside import Finding, compare
from random_scenes.build import build
from random_scenes.dice import Dice


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])
def test_random_scene_agrees_with_cycles(scene, seed, tmp_path):
    """What differs is looked at again with more samples, by itself: beside.py has the limits."""
    scene, told = build(seed)
    found = compare(scene, tmp_path)
    assert not found.differs and not found.warnings, (str(found), told, found.warnings)


@pytest.mark.parametrize("seed", [2, 4, 7])
def test_what_glows_agrees_with_cycles(scene, seed, tmp_path):
    """Pixel by pixel: there is no noise. glowing.py has the limits."""
    scene, told = glowing.build(seed)
    found = glowing.compare(scene, tmp_path)
    assert found.cycles[..., :3].max() > 0.0
    assert not found.differs and not found.warnings, (str(found), told, found.warnings)


def test_what_glows_is_told_where_it_differs(scene, tmp_path, monkeypatch):
    """A material a tenth brighter in one of the pictures is found."""
    scene, _ = glowing.build(2)
    rendered = glowing.render_iwis
    brighter = lambda *given: {k: 1.1 * v for k, v in rendered(*given).items()}  # noqa: E731
    monkeypatch.setattr(glowing, "render_iwis", brighter)
    assert glowing.compare(scene, tmp_path).differs


def test_a_seed_is_a_scene(scene):
    """The same objects at the same places, other ones of another seed."""

    def places(seed):
        build(seed)
        return [(obj.name, *obj.matrix_world.translation) for obj in bpy.context.scene.objects]

    assert places(7) == places(7) != places(8)


def test_dice_stay_within_their_limits():
    """And the ends come up: nodes go wrong there."""
    dice = Dice(3)
    numbers = [dice.edge(0.25, 0.5) for _ in range(200)]
    assert min(numbers) == 0.25 and max(numbers) == 0.5
    assert 0.0 <= dice.pixels(4, 8).min() and dice.pixels(4, 8).shape == (4, 8, 4)


@pytest.mark.parametrize(
    "numbers, differs",
    [
        ({}, False),
        ({"bias": 0.02}, True),
        ({"bias": -0.02}, True),
        ({"bias": 0.02, "error": 0.01}, False),
        ({"difference": 0.2}, True),
        ({"alpha": -0.2}, True),
        ({"groups": 0.02}, True),
    ],
)
def test_what_noise_does_not_explain_differs(numbers, differs):
    """A bias counts by its error; blocks and alpha by themselves."""
    black = np.zeros((4, 4, 4), np.float32)
    values = {"bias": 0.0, "error": 0.001, "difference": 0.0, "alpha": 0.0} | numbers
    assert Finding(**values, warnings=[], ours=black, cycles=black).differs == differs

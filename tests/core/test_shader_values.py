"""AOVs: averages of what materials' nodes write, over a pixel's rays."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Aov, Op, Program, Ref, WorldProgram
from iwis.core.nodes.world import DIRECTION
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_RAYS
from support.programs import with_programs
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
)

PLACES = Program(ops=(Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}}),), closures=())
TINT = np.float32([0.5, -2.0, 1e4])
FILTERED = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 128}
CENTER = {"stop_rule": "FIXED", "max_samples": 8}


def told_scene(*aovs, **fields):
    """A floor of 1.2 m on the left, another on the right, half a metre of nothing between them."""
    left, right = floor(0.3), floor(0.3)
    left[0][:, 0] -= 0.5
    right[0][:, 0] += 0.5
    scene = make_scene(
        [left, right], [diffuse()] * 2, constant_world(), camera_above(18, 18), **fields
    )
    if not aovs:
        return scene
    scene = with_programs(scene, None, None)
    return dataclasses.replace(scene, shaders=dataclasses.replace(scene.shaders, aovs=aovs))


def of_left(value, program=PLACES, channels=4):
    """What the floor on the left alone writes."""
    return Aov("aov:told", channels, (program, None), (value, None))


@pytest.mark.parametrize("settings", [CENTER, FILTERED], ids=["center", "filtered"])
def test_places_are_written(settings):
    """Red is where a pixel's rays end, and alpha how many do; the other floor is black."""
    layers, _ = make_picture(told_scene(of_left(Ref(0, "Position"))), **settings)
    told = layers["aov:told"]
    assert told.shape == (18, 18, 4)
    x = (np.arange(18) + 0.5) / 18 * 1.8 - 0.9
    inside = np.abs(x + 0.5) < 0.25
    # The mean of 16 even places in a pixel of .1 m is off by less than a tenth of its side.
    np.testing.assert_allclose(told[9, inside, 0], x[inside], atol=0.01)
    np.testing.assert_array_equal(told[9, inside, 3], 1.0)
    assert not told[9, x > 0.0].any() and not told[0].any()


def test_alpha_is_the_share_of_an_edge():
    """Of a pixel that the floor half fills: half of its colour, and of 1."""
    scene = told_scene(of_left(TINT, Program(ops=(), closures=())))
    layers, _ = make_picture(scene, **FILTERED | {"max_samples": 512})
    told = layers["aov:told"][9]
    edge = told[(told[:, 3] > 0.0) & (told[:, 3] < 1.0)]
    np.testing.assert_allclose(told[:, :3], told[:, 3:] * TINT, rtol=1e-5)
    np.testing.assert_allclose(told[:, 3].sum() * 0.1, 0.6, atol=0.02)
    assert len(edge) <= 2


def test_numbers_have_one_channel_and_holdouts_write():
    """As in Cycles: a hole in the picture, but not in what its nodes write."""
    flags = np.array([HOLDOUT, 0], np.int32) | CAMERA_RAYS | SHADOW_RAYS
    aov = of_left(np.float32(3.5), Program(ops=(), closures=()), 1)
    layers, _ = make_picture(told_scene(aov, object_flags=flags), **CENTER)
    told = layers["aov:told"]
    assert told.shape == (18, 18, 1) and set(told[9, :, 0].tolist()) == {0.0, 3.5}
    assert not layers["combined"][told[..., 0] > 0.0].any()


@pytest.mark.parametrize("settings", [CENTER, FILTERED], ids=["center", "filtered"])
def test_asking_changes_no_pixel(settings):
    """Of what was there before, to the last bit."""
    asked, _ = make_picture(told_scene(of_left(Ref(0, "Position"))), **settings)
    plain, _ = make_picture(told_scene(), **settings)
    assert asked.keys() - plain.keys() == {"aov:told"}
    for name, pixels in plain.items():
        np.testing.assert_array_equal(pixels, asked[name])


def of_the_world(channels=4):
    """What the world alone writes: directions, or their z."""
    ops = (
        Op(DIRECTION, {}, {}),
        Op("ShaderNodeSeparateXYZ", {"Vector": Ref(0, "")}, {}),
    )
    value = Ref(0, "") if channels == 4 else Ref(1, "Z")
    world = WorldProgram(
        program=Program(ops=ops, closures=()), value=value, strength=np.zeros(3, np.float32)
    )
    return Aov("aov:told", channels, (None, None), (None, None), world)


@pytest.mark.parametrize("settings", [CENTER, FILTERED], ids=["center", "filtered"])
def test_a_world_writes_where_nothing_else_is(settings):
    """Directions, straight down, and 1; on the floors nothing, at their edges a share."""
    layers, _ = make_picture(told_scene(of_the_world()), **settings)
    told, free = layers["aov:told"], layers["depth"][..., 0] > 1e9
    whole = told[..., 3] == 1.0
    assert whole.any() and not told[9, 4].any()
    np.testing.assert_allclose(told[whole], np.tile([0.0, 0.0, -1.0, 1.0], (whole.sum(), 1)))
    if settings is CENTER:
        np.testing.assert_array_equal(whole, free)
    numbers, _ = make_picture(told_scene(of_the_world(1)), **settings)
    np.testing.assert_allclose(numbers["aov:told"][..., 0], -told[..., 3], atol=1e-6)


@pytest.mark.parametrize("settings", [CENTER, FILTERED], ids=["center", "filtered"])
@pytest.mark.parametrize("hidden", ["film", "camera"])
def test_a_world_that_is_not_seen_writes_nothing(settings, hidden):
    """With a transparent film, or hidden from the camera."""
    scene = told_scene(of_the_world(), transparent_film=hidden == "film")
    world = dataclasses.replace(scene.environment, visible_to_camera=hidden != "camera")
    layers, _ = make_picture(dataclasses.replace(scene, environment=world), **settings)
    assert not layers["aov:told"].any()

"""Maps of a world's program: what lies in a texel, edges, blocks, threads, what the camera sees."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Op, Program, Ref, WorldProgram
from iwis.core.nodes.world import DIRECTION
from iwis.core.nodes.world_map import evaluate_map, evaluate_texels, reached_ops
from support.scenes import camera_above, constant_world, diffuse, floor, make_picture, make_scene


def program(*ops) -> Program:
    """The direction, and operations on it."""
    return Program(ops=(Op(DIRECTION, {}, {}), *ops), closures=())


def above(height: float) -> Program:
    """1 where z is above a height, else 0."""
    return program(
        Op("ShaderNodeSeparateXYZ", {"Vector": Ref(0, "")}, {}),
        Op(
            "ShaderNodeMath",
            {"Value": Ref(1, "Z"), "Value_001": np.float32(height)},
            {"operation": "GREATER_THAN", "use_clamp": False},
        ),
        Op("convert", {"Value": Ref(2, "Value")}, {"source": "NUMBER", "target": "COLOR"}),
    )


def test_texels_hold_the_direction_through_their_centre():
    """Row 0 looks along -z; u = 1/2 is +x; y grows to the left, as environment.py looks it up."""
    texels = evaluate_map(program(), Ref(0, ""), 8, has_edges=False)
    i, j = np.mgrid[0:8, 0:16] + 0.5
    latitude, longitude = (i / 8 - 0.5) * np.pi, (0.5 - j / 16) * 2 * np.pi
    np.testing.assert_allclose(texels[..., 2], np.sin(latitude), atol=1e-6)
    np.testing.assert_allclose(texels[..., 0], np.cos(latitude) * np.cos(longitude), atol=1e-6)
    np.testing.assert_allclose(texels[..., 1], np.cos(latitude) * np.sin(longitude), atol=1e-6)


def test_an_edge_gives_a_texel_its_share():
    """A step a third into row 40 of 64: of the four rows of directions inside, three lie above."""
    step = np.sin((40 + 1 / 3 - 32) / 64 * np.pi)
    texels = evaluate_map(above(step), Ref(3, ""), 64, has_edges=True)
    plain = evaluate_map(above(step), Ref(3, ""), 64, has_edges=False)
    assert set(np.unique(plain)) == {0.0, 1.0}
    np.testing.assert_array_equal(texels[:40], 0.0)
    np.testing.assert_array_equal(texels[40], 0.75)
    np.testing.assert_array_equal(texels[41:], 1.0)


@pytest.mark.parametrize("threads", [1, 3])
def test_blocks_and_threads_change_nothing(threads, monkeypatch):
    whole = evaluate_map(above(0.3), Ref(3, ""), 32, has_edges=True)
    monkeypatch.setattr("iwis.core.nodes.world_map._BLOCK", 192)
    parts = evaluate_map(above(0.3), Ref(3, ""), 32, has_edges=True, threads=threads)
    np.testing.assert_array_equal(parts, whole)


@pytest.mark.parametrize("threads", [1, 3])
def test_pause_may_stop_it(threads, monkeypatch):
    monkeypatch.setattr("iwis.core.nodes.world_map._BLOCK", 192)

    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        evaluate_map(above(0.3), Ref(3, ""), 32, has_edges=True, threads=threads, pause=stop)


def test_only_what_a_value_needs_is_reached():
    assert set(reached_ops(above(0.0), Ref(1, "Z"))) == {0, 1}


def test_texels_of_images_go_through_the_program(rng):
    images = {k: rng.random((5, 7, 3), np.float32) for k in (0, 1)}
    ops = (
        Op("world_environment", {}, {}),
        Op("world_environment", {}, {}),
        Op("product", {"A": Ref(0, "Color"), "B": Ref(1, "Color")}, {}),
    )
    made = evaluate_texels(Program(ops=ops, closures=()), Ref(2, ""), images)
    np.testing.assert_array_equal(made, images[0] * images[1])


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("transparent", [False, True])
def test_the_camera_sees_the_backdrop_and_the_light_lights(pixel_filter, transparent):
    """Behind all, in Combined (unless the film is transparent) and in Environment."""
    scene = make_scene(
        [floor(half=0.5)],
        [diffuse()],
        constant_world(),
        camera_above(),
        transparent_film=transparent,
    )
    red = constant_world((2.0, 0.5, 0.0))
    tinted = WorldProgram(
        program=above(-0.5), value=Ref(3, ""), strength=np.float32([2.0, 0.5, 0.0])
    )
    plain, _ = make_picture(scene, max_samples=8, pixel_filter=pixel_filter)
    for backdrop, expected in ((red, (2.0, 0.5, 0.0)), (tinted, (0.0, 0.0, 0.0))):
        other = dataclasses.replace(scene, backdrop=backdrop)
        layers, _ = make_picture(other, max_samples=8, pixel_filter=pixel_filter)
        sky = layers["depth"][..., 0] > 1e9
        inner = layers["environment"][..., 0] == 0.0 if expected[0] else ~sky
        assert sky.any() and inner.any()
        np.testing.assert_allclose(layers["environment"][0, 0], expected)
        seen = (0.0, 0.0, 0.0) if transparent else expected
        np.testing.assert_allclose(layers["combined"][0, 0, :3], seen)
        np.testing.assert_array_equal(layers["combined"][inner], plain["combined"][inner])

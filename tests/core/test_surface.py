"""Materials that vary over a surface: programs at shading points."""

import dataclasses

import numpy as np
import pytest

from iwis.core.nodes.context import barycentric_of
from iwis.core.nodes.layers import under_coat
from iwis.core.program import Closure, Op, Program, Ref
from iwis.core.scene import DIFFUSE, GGX, GLOSSY
from iwis.core.surface import closure_layers, surface_lobes
from support.programs import with_programs
from support.samplers import pixel_points
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_picture,
    make_scene,
    principled,
)

_ONE = np.ones(3, np.float32)
_POSITION = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})


def _one_program(program, material):
    scene = make_scene([floor()], [material], constant_world(), camera_above(8, 6))
    return with_programs(scene, program)


def test_barycentric_coordinates_are_found_again():
    """A place made of a triangle's corners gives the weights that it was made with."""
    rng = np.random.default_rng(3)
    scene = make_scene([floor()], [diffuse()], constant_world(), camera_above())
    u, v = rng.uniform(0.0, 0.5, (2, 40))
    triangle = rng.integers(0, 2, 40)
    a, b, c = (scene.mesh.vertices[corner] for corner in scene.mesh.triangles[triangle].T)
    place = (1 - u - v)[:, None] * a + u[:, None] * b + v[:, None] * c
    found = barycentric_of(scene.mesh, triangle, place.astype(np.float32))
    np.testing.assert_allclose(found, np.stack([u, v], -1), atol=1e-6)  # float32 places


def test_program_of_constants_is_its_row():
    """A closure that says what the row says gives the row's lobes, to the last bit."""
    material = principled(base_color=(0.2, 0.5, 0.7), roughness=0.3)
    params = {"base_color": np.float32([0.2, 0.5, 0.7]), "roughness": np.float32(0.3)}
    seen = pixel_points(_one_program(None, material))
    closure = Closure(2, GGX, _ONE, params)
    closure = closure._replace(model=material["model"])
    scene = _one_program(Program(ops=(), closures=(closure,)), material)
    for ours, theirs in zip(surface_lobes(scene, seen.points), seen.lobes, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_color_varies_over_the_surface():
    """The place as colour: the Lambert lobe has it, and all of the picture's light."""
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": Ref(0, "Position")})
    scene = _one_program(Program(ops=(_POSITION,), closures=(closure,)), diffuse())
    points = pixel_points(scene).points
    expected = np.maximum(points.position, 0.0)
    np.testing.assert_allclose(surface_lobes(scene, points).diffuse, expected, atol=1e-6)


def test_heaviest_closure_of_each_point_is_shown():
    """Half of the floor weighs more to one side: there it is a mirror, elsewhere diffuse."""
    rough, matte = (
        Closure(GLOSSY, GGX, Ref(0, "Position"), {"base_color": _ONE}),
        Closure(DIFFUSE, GGX, np.float32([0.3] * 3), {"base_color": _ONE}),
    )
    scene = _one_program(Program(ops=(_POSITION,), closures=(rough, matte)), glossy(0.3))
    points = pixel_points(scene).points
    mirrors = np.maximum(points.position, 0.0).mean(1) >= 0.3
    lobes = surface_lobes(scene, points)
    assert 0 < mirrors.sum() < len(mirrors)
    np.testing.assert_array_equal(lobes.diffuse.any(axis=1), ~mirrors)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_mixture_is_the_sum_of_its_parts(pixel_filter):
    """.3 of paint and .7 of a mirror: the picture is .3 and .7 of theirs, at one share of samples.

    At pixel centres the samples are the same ones; a pass of a filtered pixel halves them.
    """
    part = {"base_color": np.float32([0.8, 0.3, 0.2]), "roughness": np.float32(0.4)}
    paint, mirror = (
        Closure(model, GGX, np.float32([share] * 3), part)
        for model, share in ((DIFFUSE, 0.3), (GLOSSY, 0.7))
    )
    settings = {"max_samples": 64, "stop_rule": "FIXED", "pixel_filter": pixel_filter}

    def picture(*closures):
        program = Program(ops=(), closures=closures)
        scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above(8, 6))
        return make_picture(with_programs(scene, program), **settings)[0]

    both, first, second = picture(paint, mirror), picture(paint), picture(mirror)
    for name in ("diffuse_color", "glossy_color", "unoccluded", "combined"):
        a, b, c = (layers[name][..., :3] for layers in (both, first, second))
        if pixel_filter == "CENTER":
            np.testing.assert_allclose(a, b + c, rtol=1e-5)
        else:  # 8 passes of 4 + 4 samples against 8 and 8: the noise of 48 pixels
            np.testing.assert_allclose(a.mean(), b.mean() + c.mean(), rtol=0.01)
    samples = 128 if pixel_filter == "CENTER" else 64
    assert (both["samples"] == samples).all()


def test_layers_hold_the_points_that_have_them():
    """The second closure is there where it weighs anything; what glows is in the first layer."""
    paint = Closure(DIFFUSE, GGX, np.float32([0.5] * 3), {})
    some = Closure(GLOSSY, GGX, Ref(0, "Position"), {})
    glow = np.float32([1.0, 2.0, 3.0])
    program = Program(ops=(_POSITION,), closures=(paint, some), emission=glow)
    scene = _one_program(program, diffuse())
    points = pixel_points(scene).points
    (first, paints), (second, mirrors) = closure_layers(scene, points)
    np.testing.assert_array_equal(first, np.arange(len(points.pixel)))
    np.testing.assert_array_equal(second, np.flatnonzero((points.position > 0.0).any(axis=1)))
    assert 0 < len(second) < len(first)
    np.testing.assert_array_equal(paints.emission, np.tile(glow, (len(first), 1)))
    assert not mirrors.emission.any()


def test_coat_takes_what_it_reflects():
    """Along the normal: 1 - F0 of its index, times its tint; no coat takes nothing."""
    up = np.float32([[0.0, 0.0, 1.0]])

    class Straight:
        wo = normal = geometric_normal = up

        def __len__(self):
            return 1

    inputs = {"Weight": np.float32([0.8] * 3), "IOR": np.float32(1.5), "Roughness": np.float32(0.1)}
    tint = np.float32([0.5, 1.0, 1.0])

    def left(share):
        return under_coat(Straight(), {}, inputs | {"Coat": np.float32(share), "Tint": tint})[""]

    np.testing.assert_allclose(left(0.0), [[0.8] * 3], rtol=1e-6)
    np.testing.assert_allclose(left(1.0)[0], 0.8 * 0.96 * tint, rtol=2e-3)  # a table of albedos
    np.testing.assert_allclose(left(0.5)[0], 0.8 * 0.98 * (0.5 + 0.5 * tint), rtol=2e-3)


@pytest.mark.slow  # tables
def test_paper_mode_shows_the_row_and_says_so():
    """Its tables are of a material as a whole."""
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": np.zeros(3, np.float32)})
    scene = _one_program(Program(ops=(), closures=(closure,)), diffuse())
    plain = dataclasses.replace(scene, shaders=None)
    small = {"estimator": "PAPER", "max_samples": 8, "stop_rule": "FIXED"}
    (ours, stats), (theirs, _) = (make_picture(s, **small) for s in (scene, plain))
    for name, layer in theirs.items():
        np.testing.assert_array_equal(ours[name], layer)
    assert any("PAPER" in line for line in stats.warnings)

"""Materials that vary over a surface: programs at shading points."""

import dataclasses

import numpy as np
import pytest

from iwis.core.nodes.context import barycentric_of
from iwis.core.program import Closure, Op, Program, Ref, Shaders, SurfaceData
from iwis.core.scene import DIFFUSE, GGX, GLOSSY
from iwis.core.surface import surface_lobes
from support.samplers import pixel_points
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    glossy,
    make_picture,
    make_scene,
    principled,
)

_ONE = np.ones(3, np.float32)
_POSITION = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})


def _with_program(program, material):
    scene = make_scene([floor()], [material], constant_world(), camera_above(8, 6))
    surface = SurfaceData(
        row=np.full(2, -1, np.int32),
        object_to_world=np.eye(4)[None],
        mirrored=np.zeros(1, bool),
        color=np.ones((1, 4), np.float32),
        random=np.zeros(1, np.float32),
        pass_index=np.zeros(1, np.float32),
    )
    shaders = Shaders(
        programs=(program,), surface=surface, material_pass_index=np.zeros(1, np.float32)
    )
    return dataclasses.replace(scene, shaders=shaders)


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
    seen = pixel_points(_with_program(None, material))
    closure = Closure(2, GGX, _ONE, params)
    closure = closure._replace(model=material["model"])
    scene = _with_program(Program(ops=(), closures=(closure,)), material)
    for ours, theirs in zip(surface_lobes(scene, seen.points), seen.lobes, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_color_varies_over_the_surface():
    """The place as colour: the Lambert lobe has it, and all of the picture's light."""
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": Ref(0, "Position")})
    scene = _with_program(Program(ops=(_POSITION,), closures=(closure,)), diffuse())
    points = pixel_points(scene).points
    expected = np.maximum(points.position, 0.0)
    np.testing.assert_allclose(surface_lobes(scene, points).diffuse, expected, atol=1e-6)


def test_heaviest_closure_of_each_point_is_shown():
    """Half of the floor weighs more to one side: there it is a mirror, elsewhere diffuse."""
    rough, matte = (
        Closure(GLOSSY, GGX, Ref(0, "Position"), {"base_color": _ONE}),
        Closure(DIFFUSE, GGX, np.float32([0.3] * 3), {"base_color": _ONE}),
    )
    scene = _with_program(Program(ops=(_POSITION,), closures=(rough, matte)), glossy(0.3))
    points = pixel_points(scene).points
    mirrors = np.maximum(points.position, 0.0).mean(1) >= 0.3
    lobes = surface_lobes(scene, points)
    assert 0 < mirrors.sum() < len(mirrors)
    np.testing.assert_array_equal(lobes.diffuse.any(axis=1), ~mirrors)


@pytest.mark.slow  # tables
def test_paper_mode_shows_the_row_and_says_so():
    """Its tables are of a material as a whole."""
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": np.zeros(3, np.float32)})
    scene = _with_program(Program(ops=(), closures=(closure,)), diffuse())
    plain = dataclasses.replace(scene, shaders=None)
    small = {"estimator": "PAPER", "max_samples": 8, "stop_rule": "FIXED"}
    (ours, stats), (theirs, _) = (make_picture(s, **small) for s in (scene, plain))
    for name, layer in theirs.items():
        np.testing.assert_array_equal(ours[name], layer)
    assert any("PAPER" in line for line in stats.warnings)

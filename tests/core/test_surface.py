"""Materials that vary over a surface: programs at shading points."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Op, Program, Ref
from iwis.core.nodes.context import ShadeContext, barycentric_of
from iwis.core.nodes.layers import through_glass
from iwis.core.scene import (
    DIFFUSE,
    GGX,
    GLOSSY,
    TOON,
    TRANSLUCENT,
    EnvironmentMap,
)
from iwis.core.surfaces.surface import closure_layers, surface_lobes
from support.brdf_points import evaluated, sphere_quadrature
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


def test_steps_of_a_bump_are_tangents(rng):
    """At right angles to the face and to each other; of a normal along (1, 1, 1), too."""

    class Faces:
        geometric_normal = rng.standard_normal((50, 3)).astype(np.float32)

    normal = Faces.geometric_normal
    normal[0] = 1.0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    length = rng.uniform(0.5, 2.0, 50).astype(np.float32)
    along, across = ShadeContext.tangents(Faces(), length)
    for step in (along, across):
        np.testing.assert_allclose(np.linalg.norm(step, axis=1), length, rtol=1e-6)
        np.testing.assert_allclose((step * normal).sum(1), 0.0, atol=1e-6)
    np.testing.assert_allclose((along * across).sum(1), 0.0, atol=1e-6)
    np.testing.assert_allclose(along[1:].sum(1), 0.0, atol=1e-6)  # as of (1, 1, 1) x normal


def test_program_of_constants_is_its_row():
    """A closure that says what the row says gives the row's lobes, to the last bit."""
    material = principled(base_color=(0.2, 0.5, 0.7), roughness=0.3)
    params = {"base_color": np.float32([0.2, 0.5, 0.7]), "roughness": np.float32(0.3)}
    seen = pixel_points(_one_program(None, material))
    closure = Closure(2, GGX, _ONE, params)
    closure = closure._replace(model=material["model"])
    scene = _one_program(Program(ops=(), closures=(closure,)), material)
    for ours, theirs in zip(surface_lobes(scene, seen.points)[1], seen.lobes, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_color_varies_over_the_surface():
    """The place as colour: the Lambert lobe has it, and all of the picture's light."""
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": Ref(0, "Position")})
    scene = _one_program(Program(ops=(_POSITION,), closures=(closure,)), diffuse())
    points = pixel_points(scene).points
    expected = np.maximum(points.position, 0.0)
    np.testing.assert_allclose(surface_lobes(scene, points)[1].diffuse, expected, atol=1e-6)


@pytest.mark.parametrize("corrects", (True, False))
def test_turned_normal_is_corrected_or_not(corrects):
    """So flat that the mirrored view would go into the floor: corrected, it does not, and light
    is shadowed; otherwise both lobes follow the normal as it is."""
    flat = np.float32([0.8, 0.0, 0.6])
    closure = Closure(GLOSSY, GGX, _ONE, {"base_color": _ONE}, flat)
    program = Program(ops=(), closures=(closure,), corrects_bumps=corrects)
    scene = _one_program(program, glossy(0.3))
    lobes = surface_lobes(scene, pixel_points(scene).points)[1]
    turned = np.abs(lobes.glossy_normal - lobes.normal).max(axis=1) > 1e-3
    assert turned.any() == corrects
    assert lobes.bump.any() == corrects


def test_gloss_does_not_know_from_how_far_its_normal_was_turned_back():
    """As in Cycles: one reflection for all normals beyond the last that mirrors the view out."""
    wi, _ = sphere_quadrature()
    found = []
    for degrees in (60.0, 85.0):
        turn = np.radians(degrees)
        normal = np.float32([np.sin(turn), 0.0, np.cos(turn)])
        closure = Closure(GLOSSY, GGX, _ONE, {"base_color": _ONE}, normal)
        scene = _one_program(Program(ops=(), closures=(closure,)), glossy(0.4))
        lobes = surface_lobes(scene, pixel_points(scene).points)[1]
        k = int(np.argmin(lobes.wo[:, 0]))  # seen from the other side: both are turned back
        assert lobes.glossy_normal[k, 2] > normal[2] + 0.01
        found.append(evaluated(lobes, k, wi)[:, 3])
    assert found[0].max() > 0.01
    np.testing.assert_allclose(found[0], found[1], rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("corrects", (True, False))
@pytest.mark.parametrize("height", (0.1, -0.1))
def test_normal_into_the_surface_reflects_no_diffuse_light(height, corrects):
    """As in Cycles: light and viewer are above the surface, and the normal below it."""
    side = np.float32([np.sqrt(1.0 - height * height), 0.0, height])
    closure = Closure(DIFFUSE, GGX, _ONE, {"base_color": _ONE}, side)
    program = Program(ops=(), closures=(closure,), corrects_bumps=corrects)
    scene = _one_program(program, diffuse())
    lobes = surface_lobes(scene, pixel_points(scene).points)[1]
    np.testing.assert_array_equal(lobes.diffuse, np.full_like(lobes.diffuse, height > 0.0))


def test_heaviest_closure_of_each_point_is_shown():
    """Half of the floor weighs more to one side: there it is a mirror, elsewhere diffuse."""
    rough, matte = (
        Closure(GLOSSY, GGX, Ref(0, "Position"), {"base_color": _ONE}),
        Closure(DIFFUSE, GGX, np.float32([0.3] * 3), {"base_color": _ONE}),
    )
    scene = _one_program(Program(ops=(_POSITION,), closures=(rough, matte)), glossy(0.3))
    points = pixel_points(scene).points
    mirrors = np.maximum(points.position, 0.0).mean(1) >= 0.3
    lobes = surface_lobes(scene, points)[1]
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
    (first, _, paints, _), (second, _, mirrors, _) = closure_layers(scene, points)
    np.testing.assert_array_equal(first, np.arange(len(points.pixel)))
    np.testing.assert_array_equal(second, np.flatnonzero((points.position > 0.0).any(axis=1)))
    assert 0 < len(second) < len(first)
    np.testing.assert_array_equal(paints.emission, np.tile(glow, (len(first), 1)))
    assert not mirrors.emission.any()


_LEAF = Closure(TRANSLUCENT, GGX, np.float32([0.5] * 3), {"base_color": np.float32([0.8] * 3)})


def _half_sky(up=1.0, down=0.25):
    """A world of one radiance above and another below."""
    rows = np.repeat(np.float32([down, up]), 64)[:, None, None]
    return EnvironmentMap(radiance=np.ascontiguousarray(np.broadcast_to(rows, (128, 256, 3))))


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("others", [(), (Closure(DIFFUSE, GGX, np.float32([0.5] * 3), {}),)])
def test_translucent_surface_shows_the_light_behind_it(pixel_filter, others):
    """A leaf under a bright sky over dark ground: its weight and colour times the ground's light,
    and nothing over a lid; the normal pass has the side that is seen."""
    program = Program(ops=(), closures=(_LEAF, *others))
    settings = {"max_samples": 256, "stop_rule": "FIXED", "pixel_filter": pixel_filter}
    parts, materials = [floor(), floor(50.0, -0.1)], [diffuse(), diffuse()]

    def picture(n):
        scene = make_scene(parts[:n], materials[:n], _half_sky(), camera_above(8, 6, half=0.5))
        return make_picture(with_programs(scene, *[program, None][:n]), **settings)[0]

    above = len(others) * 0.5 * 0.8 * 1.0
    # A pixel has 32 to 256 samples of a sky with an edge at the horizon: 2 % in the mean of 48.
    assert abs(picture(1)["combined"][..., :3].mean() - above - 0.5 * 0.8 * 0.25) < 0.01
    over_a_lid = picture(2)
    assert abs(over_a_lid["combined"][..., :3].mean() - above) < 0.01 * max(above, 0.1)
    np.testing.assert_allclose(over_a_lid["normal"][..., 2], 1.0, atol=1e-5)


def test_glass_shares_its_weight_between_reflection_and_what_is_behind():
    """Along the normal F0 is reflected; from inside all goes through; a shadow ray is not asked
    where it comes from."""
    up = np.float32([[0.0, 0.0, 1.0]])

    class Seen:
        normal = geometric_normal = up

        def __init__(self, wo, backfacing, shadow=False):
            self.wo, self.backfacing, self.shadow = np.float32([wo]), backfacing, shadow

        def __len__(self):
            return 1

    inputs = {"Weight": np.float32([0.8] * 3), "Tint": np.float32([0.5, 1.0, 1.0])}
    inputs |= {"IOR": np.float32(1.5), "Roughness": np.float32(0.05)}
    straight, grazing = (0.0, 0.0, 1.0), (0.995, 0.0, 0.0999)

    def parts(*context):
        found = through_glass(Seen(*context), {}, inputs)
        return found[""][0], found["reflected"][0]

    through, reflected = parts(straight, 0.0)
    np.testing.assert_allclose(through, np.float32([0.4, 0.8, 0.8]) * 0.96, rtol=2e-3)
    np.testing.assert_allclose(reflected, 0.8)
    assert parts(grazing, 0.0)[0][1] < 0.5
    through, reflected = parts(grazing, 1.0)
    np.testing.assert_allclose(through, [0.4, 0.8, 0.8], rtol=1e-6)
    assert not reflected.any()
    shadow = [parts(wo, 0.0, True)[0] for wo in (straight, grazing)]
    np.testing.assert_array_equal(*shadow)


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


@pytest.mark.slow  # tables
def test_paper_mode_says_that_it_has_no_toon():
    """And says nothing of it where there is none."""
    params = {"base_color": _ONE, "roughness": np.float32(0.3)}
    for model in (DIFFUSE, TOON):
        closure = Closure(model, GGX, _ONE, params | {"diffuse_roughness": np.float32(0.0)})
        scene = _one_program(Program(ops=(), closures=(closure,)), diffuse())
        small = {"estimator": "PAPER", "max_samples": 8, "stop_rule": "FIXED"}
        told = [line for line in make_picture(scene, **small)[1].warnings if "Toon" in line]
        assert len(told) == (model == TOON)

"""Light from under surfaces: subsurface.py, random_walk.py and what a render makes of them."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Program, Subsurface
from iwis.core.embree.accel import Accel
from iwis.core.film import Film
from iwis.core.geometry.shading import shading_points
from iwis.core.render import render
from iwis.core.scene import (
    BLACK,
    CAMERA_RAYS,
    DIFFUSE,
    GGX,
    PRINCIPLED,
    ROUND,
    SHADOW_RAYS,
    EnvironmentMap,
)
from iwis.core.settings import RenderSettings
from iwis.core.walks.random_walk import walk
from iwis.core.walks.subsurface import LEGACY, SKIN, VAN_DE_HULST, Media, medium_of, walked
from support import scenes
from support.programs import with_programs
from support.strands import cone_mesh

WALKS = 40_000
_ONE = np.ones(3, np.float32)


def _media(n=1, color=0.5, radius=0.01, g=0.0, ior=1.4, roughness=1.0, method=LEGACY) -> Media:
    def vectors(value):
        return np.broadcast_to(np.float32(value), (n, 3)).copy()

    numbers = (np.full(n, value, np.float32) for value in (g, ior, roughness))
    return Media(vectors(color), vectors(radius), *numbers, np.full(n, method, np.int8))


def _scene(parts, **fields):
    materials = [scenes.diffuse()] * len(parts)
    return scenes.make_scene(
        parts, materials, scenes.constant_world(), scenes.camera_above(), **fields
    )


def _looked_at(scene, directions, origin):
    """(Accel, points) of rays from one place, of which all hit."""
    accel = Accel(scene.mesh)
    origins = np.tile(np.float32(origin), (len(directions), 1))
    hits = accel.intersect(origins, directions)
    points = shading_points(scene.mesh, *hits, directions)
    assert len(points.pixel) == len(directions)
    return accel, points


def _down(n=WALKS):
    return np.tile(np.float32([0.0, 0.0, -1.0]), (n, 1))


def _walk(scene, accel, points, media, seed=0, first=0):
    n = first + np.arange(len(points.pixel), dtype=np.int64)
    return walk(scene, accel, points, points.normal, media, (n, 0 * n, 0 * n), seed)


# What Cycles shows of a box, so large that it is a half space, under an even white world: the mean
# of 16 x 16 pixels of 2048 samples, direct light only, seen from above by a camera of 39.6 degrees.
# Blender 5.2, LEGACY: 4.5; the Subsurface Scattering node with a roughness of 1.
CYCLES = [
    (VAN_DE_HULST, 0.0, 1.4, (0.1, 0.3, 0.5), (0.08296, 0.25902, 0.45070)),
    (VAN_DE_HULST, 0.0, 1.4, (0.7, 0.8, 0.9), (0.65873, 0.76735, 0.86326)),
    (VAN_DE_HULST, 0.5, 1.4, (0.1, 0.3, 0.5), (0.06534, 0.23564, 0.43401)),
    (VAN_DE_HULST, 0.5, 1.4, (0.7, 0.8, 0.9), (0.65142, 0.76416, 0.86247)),
    (LEGACY, 0.0, 1.4, (0.1, 0.3, 0.5), (0.08227, 0.25976, 0.45362)),
    (LEGACY, 0.0, 1.4, (0.7, 0.8, 0.9), (0.66385, 0.77708, 0.88430)),
    (LEGACY, 0.5, 1.4, (0.1, 0.3, 0.5), (0.06653, 0.23800, 0.43900)),
    (LEGACY, 0.5, 1.4, (0.7, 0.8, 0.9), (0.66596, 0.80336, 0.89571)),
    (SKIN, 0.0, 1.1, (0.1, 0.3, 0.5), (0.09086, 0.27940, 0.47695)),
    (SKIN, 0.0, 2.0, (0.1, 0.3, 0.5), (0.09355, 0.28561, 0.48510)),
    (SKIN, 0.5, 1.4, (0.7, 0.8, 0.9), (0.69028, 0.81439, 0.89173)),
]


@pytest.mark.parametrize("method, g, ior, color, expected", CYCLES)
def test_a_half_space_reflects_as_in_cycles(rng, method, g, ior, color, expected):
    """Within three standard errors, and .5 % for Cycles' own error."""
    scene = _scene([scenes.box((-40.0, -40.0, -80.0), (40.0, 40.0, 0.0))])
    aim = np.ones((WALKS, 3)) * -1.0
    aim[:, :2] = rng.uniform(-0.36, 0.36, (WALKS, 2))
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    accel, points = _looked_at(scene, aim.astype(np.float32), (0.0, 0.0, 5.0))
    exits = _walk(scene, accel, points, _media(WALKS, color, 0.01, g, ior, 1.0, method))
    gain = np.zeros((WALKS, 3))
    gain[exits.of] = exits.gain
    error = gain.std(axis=0) / np.sqrt(WALKS)
    assert (np.abs(gain.mean(axis=0) - expected) < 3.0 * error + 0.005 * np.array(expected)).all()


def test_light_goes_as_far_as_the_radius_says():
    """The distance between entry and exit grows with the radius, and with how bright it is."""
    scene = _scene([scenes.box((-40.0, -40.0, -80.0), (40.0, 40.0, 0.0))])
    accel, points = _looked_at(scene, _down(5000), (0.1, 0.05, 9.0))

    def far(**fields):
        exits = _walk(scene, accel, points, _media(5000, method=VAN_DE_HULST, **fields))
        return np.median(np.linalg.norm(exits.points.position - points.position[exits.of], axis=1))

    assert far(radius=0.02) == pytest.approx(2.0 * far(radius=0.01), rel=0.01)  # the same numbers
    assert far(color=0.9) > 1.2 * far(color=0.3)


def test_walks_end_on_the_outside_of_their_own_object():
    """Whatever is inside, or cuts through."""
    ball = scenes.sphere(radius=1.0)
    parts = [ball, scenes.sphere(radius=0.4), scenes.box((-0.1, -3.0, -0.1), (0.1, 3.0, 0.1))]
    scene, plain = _scene(parts), _scene([ball])
    found = []
    for own in (scene, plain):
        accel, points = _looked_at(own, _down(4000), (0.2, 0.5, 3.0))
        exits = _walk(own, accel, points, _media(4000, 0.8, 0.3, method=VAN_DE_HULST))
        ends = exits.points
        assert (own.mesh.object_index[ends.triangle] == 0).all()
        outward = np.einsum("ij,ij->i", ends.geometric_normal, ends.position)
        assert (outward > 0.9).all()
        assert (np.einsum("ij,ij->i", ends.normal, ends.geometric_normal) > 0.9).all()
        np.testing.assert_array_equal(ends.pixel, points.pixel[exits.of])
        found.append(exits)
    # But for roundings: a walk is the same where nothing is in the way, and where something is.
    same = np.intersect1d(found[0].of, found[1].of)
    assert len(same) > 0.999 * max(len(found[0].of), len(found[1].of))
    first, second = (own.gain[np.searchsorted(own.of, same)] for own in found)
    assert (np.abs(first - second).max(axis=1) < 1e-3).mean() > 0.999


def test_walks_that_would_start_outwards_are_none():
    """Under a normal that is far off the surface some first directions lead out of it: they would
    end at a ceiling of the same object. Inwards is nothing, for so far that none scatters."""
    room = scenes.join_parts([scenes.floor(1.0), scenes.floor(50.0, 1.0)])
    scene, n = _scene([room]), 4000
    accel, points = _looked_at(scene, _down(n), (0.1, 0.05, 0.5))
    tilted = np.tile(np.float32([np.sin(1.3), 0.0, np.cos(1.3)]), (n, 1))
    media = _media(n, 0.9, 1e12, method=SKIN)
    assert not len(_walk(scene, accel, points._replace(normal=tilted), media).of)


def test_a_walk_depends_on_its_pixel_pass_and_seed_alone():
    scene = _scene([scenes.sphere()])
    accel, points = _looked_at(scene, _down(300), (0.2, 0.3, 3.0))
    media = _media(300, 0.7, 0.2)
    whole = _walk(scene, accel, points, media)
    part = _walk(scene, accel, points.at(slice(100, 200)), media.at(slice(100, 200)), first=100)
    of = whole.of[(whole.of >= 100) & (whole.of < 200)]
    np.testing.assert_array_equal(part.of + 100, of)
    np.testing.assert_array_equal(part.gain, whole.gain[np.isin(whole.of, of)])
    other = _walk(scene, accel, points, media, seed=1)
    assert not np.array_equal(other.gain[:20], whole.gain[:20])


def test_odd_media_are_finite():
    """No radius, no color, more than white, beyond the limits of index and anisotropy."""
    scene = _scene([scenes.sphere()])
    accel, points = _looked_at(scene, _down(400), (0.2, 0.3, 3.0))
    for fields in (
        {"radius": 0.0},
        {"color": 0.0},
        {"color": 5.0},
        {"g": 2.0, "ior": 0.0, "roughness": 7.0},
        {"g": -0.5},
        {"radius": 1e8},
        {"radius": (1.0, 1e-12, 1e12)},
    ):
        for method in (VAN_DE_HULST, LEGACY, SKIN):
            media = _media(400, **{"method": method, **fields})
            medium = medium_of(media)
            assert all(np.isfinite(column).all() for column in medium)
            exits = _walk(scene, accel, points, media)
            assert np.isfinite(exits.gain).all() and (exits.gain >= 0.0).all()
    np.testing.assert_array_equal(walked(np.float32([0.0, 1e-9, 1e-3])), [0.0, 0.0, 1.0])


def test_one_sided_surfaces_let_light_go():
    """A floor: no walk comes back, and the render does not mind."""
    scene = _scene([scenes.floor()])
    accel, points = _looked_at(scene, _down(50), (0.2, 0.3, 3.0))
    assert len(_walk(scene, accel, points, _media(50, 0.8, 0.5, method=VAN_DE_HULST)).of) < 50
    nothing = _walk(scene, accel, points.at(slice(0)), _media(0))
    assert len(nothing.of) == 0 and nothing.gain.shape == (0, 3)


def _program(closure=DIFFUSE, share=1.0, radius=0.2, emission=None, normal=None):
    under = Subsurface(
        np.float32(share),
        np.full(3, radius, np.float32),
        *(np.float32(value) for value in (0.0, 1.4, 1.0)),
        VAN_DE_HULST,
    )
    params = {"base_color": np.float32([0.8, 0.5, 0.2])}
    made = Closure(closure, GGX, _ONE, params, normal, subsurface=under)
    return Program(ops=(), closures=(made,), emission=emission)


def _picture(program, world=None, **settings):
    scene = scenes.make_scene(
        [scenes.sphere(smooth=True)],
        [scenes.principled(base_color=(0.8, 0.5, 0.2), roughness=0.4)],
        world or scenes.gradient_world(),
        scenes.camera_at((0.0, -6.0, 2.0), (0.0, 0.0, 0.0), half=0.15),
    )
    given = {"stop_rule": "FIXED", "max_samples": 128, "pixel_filter": "BOX"} | settings
    layers, _ = scenes.make_picture(with_programs(scene, program), **given)
    return layers


def test_a_share_of_nothing_is_the_surface_itself():
    plain = _program(PRINCIPLED)
    plain = dataclasses.replace(plain, closures=(plain.closures[0]._replace(subsurface=None),))
    expected = _picture(plain)["combined"]
    np.testing.assert_array_equal(_picture(_program(PRINCIPLED, 0.0))["combined"], expected)


def test_gloss_stays_on_the_surface():
    """Only the Lambert lobe's light goes under it; the colors of the passes stay."""
    matte, walks = (_picture(_program(PRINCIPLED, s), max_samples=1024) for s in (0.0, 1.0))
    for name in ("glossy_color", "diffuse_color", "normal", "depth"):
        np.testing.assert_allclose(walks[name], matte[name], rtol=0.02, atol=0.01)
    # Other samples of the same lobe: 1024 a pixel and 256 pixels leave less than a percent.
    gloss = [own["glossy_direct"] * own["glossy_color"] for own in (walks, matte)]
    assert gloss[0].mean() == pytest.approx(gloss[1].mean(), rel=0.01)
    assert np.abs(walks["diffuse_direct"] - matte["diffuse_direct"]).mean() > 0.02


def test_light_comes_through_to_the_dark_side():
    """A sky above a black ground: the ball's lower side gets its light through the ball."""
    sky = np.zeros((32, 64, 3), np.float32)
    sky[16:] = 1.0
    world = EnvironmentMap(radiance=sky)
    walks = _picture(_program(radius=0.3), world)["combined"]
    matte = _picture(dataclasses.replace(_program(), closures=_lambert()), world)["combined"]
    below = slice(1, 3), slice(6, 10)
    assert walks[below][..., :3].mean() > 1.1 * matte[below][..., :3].mean() > 0.0


@pytest.mark.parametrize("thing", ["strand", "point"])
def test_walks_of_strands_find_no_end(thing):
    """As in Cycles; a point is a ball of triangles to them."""
    camera = scenes.camera_at((0.0, -6.0, 1.0), (0.0, 0.0, 1.0), half=0.03)
    parts, materials = [scenes.sphere((0.0, 0.0, 1.0), smooth=True)], [scenes.diffuse()]
    scene = scenes.make_scene(parts, materials, scenes.constant_world(), camera)
    if thing == "strand":
        scene = dataclasses.replace(scene, mesh=cone_mesh())
    scene = dataclasses.replace(scene, terminator_offset=np.float32([ROUND]))
    under, half = (with_programs(scene, _program(share=share)) for share in (1.0, 0.5))
    settings = {"max_samples": 64, "pixel_filter": "BOX"}
    whole, part = (scenes.make_picture(s, **settings)[0]["combined"] for s in (under, half))
    assert (whole[..., :3].max() > 0.1) == (thing == "point")
    assert part[..., :3].min() > 0.05


def _lambert():
    return (_program().closures[0]._replace(subsurface=None),)


def test_a_tinted_pane_tints_once():
    """What is seen of a ball behind it."""
    tint = np.float32([0.5, 0.8, 0.2])
    pane = Program(ops=(), closures=(Closure(BLACK, GGX, _ONE, {}),), transparent=tint)
    scene = scenes.make_scene(
        [scenes.sphere(), scenes.floor(3.0, 2.0)],
        [scenes.diffuse(), scenes.black()],
        scenes.constant_world(),
        scenes.camera_above(8, 8, half=0.5),
        object_flags=np.uint8([CAMERA_RAYS | SHADOW_RAYS, CAMERA_RAYS]),
    )
    open_pane = dataclasses.replace(pane, transparent=_ONE)
    given = {"stop_rule": "FIXED", "max_samples": 512, "pixel_filter": "BOX"}
    clear, tinted = (
        scenes.make_picture(with_programs(scene, _program(), own), **given)[0]["combined"]
        for own in (open_pane, pane)
    )
    found = tinted[..., :3].mean(axis=(0, 1)) / clear[..., :3].mean(axis=(0, 1))
    np.testing.assert_allclose(found, tint, rtol=0.02)  # other walks: the shares drawn differ


def test_center_is_told_and_matte():
    """One point a pixel has no walks; a render without them is that of a Lambert surface."""
    program = _program()
    settings = {"pixel_filter": "CENTER", "max_samples": 64}
    expected = _picture(dataclasses.replace(program, closures=_lambert()), **settings)
    found = _picture(program, **settings)
    np.testing.assert_allclose(found["combined"], expected["combined"], rtol=0.02, atol=0.02)
    scene = scenes.make_scene(
        [scenes.sphere()], [scenes.diffuse()], scenes.constant_world(), scenes.camera_above(4, 4)
    )
    scene = with_programs(scene, program)
    for kind, told in (("CENTER", True), ("BOX", False)):
        stats = render(scene, RenderSettings(pixel_filter=kind, max_samples=8), Film((0, 0, 4, 4)))
        assert any("goes under surfaces" in line for line in stats.warnings) == told

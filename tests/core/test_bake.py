"""Points of surfaces in place of a camera's rays, and what a bake makes of their layers."""

import dataclasses

import numpy as np
import pytest

from iwis.core.bake import LIT, UNLIT, Wish, bake
from iwis.core.camera.bake_rays import bake_hits, bake_rays
from iwis.core.data.bake_points import BakePoints
from iwis.core.data.lamps import SPHERE, make_lamps
from iwis.core.film import Film
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_RAYS
from iwis.core.settings import RenderSettings
from support import scenes

SETTINGS = RenderSettings(max_samples=64, stop_rule="FIXED", threads=1)
SIZE = 8  # texels of the image's side


def _points(scene, **fields) -> BakePoints:
    """The floor's first triangle, corner 0 at the image's lower left and 1 at its lower right; the
    upper row shows nothing."""
    x, y = np.meshgrid(*((np.arange(SIZE) + 0.5) / SIZE,) * 2)
    x = x * (1.0 - y)  # so that all texels are inside
    triangle = np.zeros((SIZE, SIZE), np.int32)
    triangle[-1] = -1
    steps = np.zeros((SIZE, SIZE, 4), np.float32)
    steps[..., 0], steps[..., 2] = -1.0 / SIZE, 1.0 / SIZE
    weights = np.stack([1.0 - x - y, x], -1).astype(np.float32)
    return BakePoints(scene.mesh, triangle, weights, steps)._replace(**fields)


@pytest.fixture
def open_floor():
    """A floor of 2 x 2 metres under an even world of (1, 2, 3)."""
    world = scenes.constant_world((1.0, 2.0, 3.0))
    material = scenes.diffuse((0.5, 0.25, 0.8), emission=(0.1, 0.2, 0.3))
    return scenes.make_scene([scenes.floor()], [material], world, scenes.camera_above())


def _bake(scene, kind, points=None, settings=SETTINGS, **fields):
    points = _points(scene) if points is None else points
    picture, stats = bake(scene, points, Wish(kind, **fields), settings, Film((0, 0, 1, 1)))
    assert not stats.cancelled
    return picture


def test_the_centre_of_a_texel_is_where_its_weights_say(open_floor):
    """u and v are the weights of the second and the third corner; the other way round where the
    winding was turned round."""
    points = _points(open_floor)
    x, y = np.array([2.5, 4.5]), np.array([1.5, 3.5])
    triangle, u, v = bake_hits(points, x, y)
    weights = points.weights[[1, 3], [2, 4]]
    np.testing.assert_array_equal(triangle, 0)
    np.testing.assert_allclose(u, weights[:, 1], atol=1e-6)  # float32
    np.testing.assert_allclose(v, 1.0 - weights.sum(axis=1), atol=1e-6)
    _, turned_u, turned_v = bake_hits(points._replace(mirrored=True), x, y)
    np.testing.assert_array_equal([turned_u, turned_v], [v, u])


def test_places_of_a_texel_stay_on_its_triangle(open_floor, rng):
    """However far a step leads, weights are from 0 to 1 and add up to 1."""
    points = _points(open_floor)
    points.steps[:] = rng.normal(0.0, 3.0, points.steps.shape)
    x, y = rng.uniform(0.0, SIZE, (2, 1000))
    triangle, u, v = bake_hits(points, x, y)
    assert u.min() >= 0.0 and v.min() >= 0.0
    assert (u + v).max() <= 1.0 + 1e-5  # float32
    assert (triangle[y >= SIZE - 1] == -1).all() and (triangle[y < SIZE - 1] == 0).all()


@pytest.mark.parametrize("place", [(-0.5, 3.0), (3.0, -0.5), (SIZE + 0.5, 3.0), (3.0, SIZE + 0.5)])
def test_outside_of_the_image_nothing_is_hit(open_floor, place):
    """Pixels around a tile look there."""
    assert bake_hits(_points(open_floor), *np.array(place)[:, None])[0] == -1


def test_corners_start_no_ray_in_their_neighbours(open_floor):
    """A point at a corner lies in every face that meets there: it moves a thousandth inward."""
    points = _points(open_floor)
    points.weights[:], points.steps[:] = (1.0, 0.0), 0.0
    _, u, v = bake_hits(points, np.array([0.5]), np.array([0.5]))
    assert 0.0 < u < 1e-3 and 0.0 < v < 1e-3


def test_points_are_seen_from_above(open_floor):
    """Along the normal, from 1 m; where a texel shows nothing there is no direction."""
    _, directions, reach, hits = bake_rays(
        _points(open_floor), open_floor.camera, np.array([3.5, 3.5]), np.array([2.5, SIZE - 0.5])
    )
    np.testing.assert_allclose(directions, [[0, 0, -1], [0, 0, 0]], atol=1e-6)
    assert reach[0] == np.inf and reach[1] == 0.0 and hits[0].tolist() == [0, -1]


@pytest.mark.parametrize("z, cosine", [(1.0, 0.8), (0.02, 0.196), (-1.0, 0.196)])
def test_a_camera_sees_points_from_above_its_horizon(open_floor, z, cosine):
    """From where it is; near the horizon and below it from a cosine of .2 at the least, as Cycles
    does it: (1, .2), made a unit vector."""
    x, y = np.array([3.5]), np.array([2.5])
    origins, directions, _, _ = bake_rays(_points(open_floor), open_floor.camera, x, y)
    place = origins[0] + directions[0]  # on the floor
    eye = np.eye(4)
    eye[:3, 3] = place + np.array([0.75, 0.0, z])
    camera = dataclasses.replace(scenes.camera_at((0, -1, 3), (0, 0, 0)), camera_to_world=eye)
    seen = -bake_rays(_points(open_floor, from_camera=True), camera, x, y)[1][0]
    np.testing.assert_allclose(np.linalg.norm(seen), 1.0, atol=1e-5)
    assert seen[0] > 0.0 and abs(seen[1]) < 1e-5
    assert seen[2] >= cosine - 1e-3


def test_even_light_is_baked_as_it_is(open_floor):
    """An open floor gets all of an even world's light: its radiance; the product with the color,
    and emission in COMBINED alone. 64 samples whose weights vary by .2: 2.5 % a texel, .3 of all.
    """
    light = _bake(open_floor, "DIFFUSE", parts=frozenset({"DIRECT"}))
    there = _points(open_floor).triangle >= 0
    np.testing.assert_allclose(light[there][:, :3], [[1.0, 2.0, 3.0]] * there.sum(), rtol=0.1)
    np.testing.assert_allclose(light[there][:, :3].mean(axis=0), [1.0, 2.0, 3.0], rtol=0.01)
    both = _bake(open_floor, "DIFFUSE")
    np.testing.assert_allclose(both[there][:, :3], light[there][:, :3] * [0.5, 0.25, 0.8], 1e-5)
    whole = _bake(open_floor, "COMBINED")
    expected = both[there][:, :3] + [0.1, 0.2, 0.3]
    np.testing.assert_allclose(whole[there][:, :3], expected, rtol=1e-4)
    assert (whole[there][:, 3] == 1.0).all()


@pytest.mark.parametrize("kind", [kind for kind in LIT + UNLIT if kind != "UV"])
def test_texels_without_a_face_are_black(open_floor, kind):
    """Whatever is baked: Blender fills margins by their mask. (The scene here has no map of UV.)"""
    asked = open_floor.asked._replace(occlusion_distance=1.0)
    scene = dataclasses.replace(open_floor, asked=asked)
    picture = _bake(scene, kind)
    assert not picture[-1].any() and picture[:-1, :, 3].all()


@pytest.mark.parametrize(
    "kind, parts, expected",
    [
        ("COMBINED", {"EMIT"}, (0.1, 0.2, 0.3)),
        ("COMBINED", {"DIRECT"}, (0.0, 0.0, 0.0)),
        ("COMBINED", {"DIRECT", "GLOSSY"}, (0.0, 0.0, 0.0)),
        ("DIFFUSE", {"COLOR"}, (0.5, 0.25, 0.8)),
        ("DIFFUSE", set(), (0.0, 0.0, 0.0)),
        ("GLOSSY", {"DIRECT", "COLOR"}, (0.0, 0.0, 0.0)),
        ("EMIT", set(), (0.1, 0.2, 0.3)),
        ("NORMAL", set(), (0.0, 0.0, 1.0)),
        ("ROUGHNESS", set(), (1.0, 1.0, 1.0)),
        ("SHADOW", set(), (1.0, 1.0, 1.0)),
    ],
)
def test_parts_are_what_they_are_called(open_floor, kind, parts, expected):
    """Of a matte floor that shines."""
    picture = _bake(open_floor, kind, parts=frozenset(parts))
    np.testing.assert_allclose(
        picture[:-1, :, :3], np.broadcast_to(expected, (SIZE - 1, SIZE, 3)), atol=1e-5
    )


def test_gloss_has_its_roughness(open_floor):
    """Also beside a lobe without one."""
    scene = dataclasses.replace(
        open_floor, materials=scenes.make_materials(scenes.principled(roughness=0.3))
    )
    np.testing.assert_allclose(_bake(scene, "ROUGHNESS")[:-1, :, 0], 0.3, rtol=1e-4)


def test_shadow_is_the_share_of_light_that_arrives(open_floor):
    """Under a lid half a metre above, as far as lamps' light too: with both taken away by hand."""
    lamp = {"kind": SPHERE, "position": (0.9, 0.2, 0.4), "size": (0.1, 0.1)}
    lamps = make_lamps([lamp | {"radiance": (50.0, 50.0, 50.0)}])
    lid = scenes.quad((-0.6, -0.6, 0.2), (0.0, 1.2, 0.0), (1.2, 0.0, 0.0))
    scene = scenes.make_scene(
        [scenes.floor(), lid],
        [scenes.diffuse()] * 2,
        scenes.constant_world(),
        scenes.camera_above(),
    )
    scene = dataclasses.replace(scene, lamps=lamps)
    flags = np.array([CAMERA_RAYS | SHADOW_RAYS, CAMERA_RAYS], np.uint8)
    open_scene = dataclasses.replace(scene, object_flags=flags)
    lit, whole = (_bake(s, "DIFFUSE", parts=frozenset({"DIRECT"})) for s in (scene, open_scene))
    share = lit[:-1, :, :3] / whole[:-1, :, :3]
    assert share.min() < 0.5 and share.max() > 0.7
    # 64 samples of a texel that sees half of its light: two thousandths of variance each way
    np.testing.assert_allclose(_bake(scene, "SHADOW")[:-1, :, :3], share, atol=0.08)


def test_environment_is_the_world_behind_each_place(open_floor):
    """Seen from the origin, as in Cycles: its colour, however the floor is."""
    picture = _bake(open_floor, "ENVIRONMENT")
    expected = np.broadcast_to([1.0, 2.0, 3.0], (SIZE - 1, SIZE, 3))
    np.testing.assert_allclose(picture[:-1, :, :3], expected, rtol=1e-6)


def test_a_hidden_object_and_a_hole_are_baked_all_the_same(open_floor):
    """What the camera does not see has texels: only a hole shows nothing of itself."""
    flags = np.array([SHADOW_RAYS], np.uint8)
    hidden = dataclasses.replace(open_floor, object_flags=flags)
    np.testing.assert_array_equal(_bake(hidden, "EMIT"), _bake(open_floor, "EMIT"))
    hole = dataclasses.replace(open_floor, object_flags=flags | np.uint8(HOLDOUT))
    assert not _bake(hole, "EMIT")[..., :3].any()


def test_the_same_bake_twice_is_the_same(open_floor):
    """To the last bit, whatever the threads."""
    world = scenes.gradient_world()
    scene = dataclasses.replace(open_floor, environment=world)
    two = dataclasses.replace(SETTINGS, threads=2, tile_px=8)
    np.testing.assert_array_equal(_bake(scene, "COMBINED"), _bake(scene, "COMBINED", settings=two))


def test_a_cancelled_bake_is_told(open_floor):
    """It ends, and says so."""

    class Impatient(Film):
        def cancelled(self):
            return True

    own = _points(open_floor), Wish("SHADOW"), SETTINGS, Impatient((0, 0, 1, 1))
    picture, stats = bake(open_floor, *own)
    assert stats.cancelled and picture.shape == (SIZE, SIZE, 4)

"""Rays where objects have moved since the hierarchy was built, without building it anew."""

import dataclasses

import numpy as np
import pytest

from iwis.core import render_cache
from iwis.core.data.program import Closure, Program
from iwis.core.embree import moved_accel
from iwis.core.embree.accel import Accel
from iwis.core.embree.moved_accel import MovedAccel, moved, moves_between, settled
from iwis.core.machine.watch import Cancelled, StopFlag
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CAMERA_RAYS, DIFFUSE, GGX, SHADOW_RAYS
from iwis.core.see_through import ray_masks
from iwis.core.see_through.scene_rays import SceneRays
from iwis.core.settings import RenderSettings
from iwis.core.windows.coarse_pictures import Pace
from iwis.core.windows.progressive import render_progressive
from support.programs import with_programs
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_scene,
    varied_scene,
)


def matrix_of(angle, shift, size=1.0):
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    matrix[:3, :3] *= size
    matrix[:3, 3] = shift
    return matrix


def with_moves(scene, matrices):
    """The scene with objects moved, by a matrix each, as a window's export does it."""
    mesh, places = scene.mesh, scene.object_to_world.copy()
    vertices = mesh.vertices.copy()
    for row, matrix in matrices.items():
        which = np.unique(mesh.triangles[mesh.object_index == row])
        vertices[which] = mesh.vertices[which] @ matrix[:3, :3].T + matrix[:3, 3]
        places[row] = matrix @ places[row]
    mesh = dataclasses.replace(mesh, vertices=vertices)
    return dataclasses.replace(scene, mesh=mesh, object_to_world=places)


@pytest.fixture
def room():
    """Three objects and more, whose places are told."""
    scene = varied_scene()
    places = np.tile(np.eye(4), (len(scene.object_pass_index), 1, 1))
    places[:, :3, 3] = np.arange(3 * len(places)).reshape(-1, 3)
    return dataclasses.replace(scene, object_to_world=places)


def assert_same_rays(found, mesh, rng):
    """Hits and occlusion are those of a hierarchy that was built for the mesh."""
    wanted = Accel(mesh)
    n = 6000
    origins = np.tile(np.float32([0.2, -0.3, 3.0]), (n, 1))
    directions = (rng.standard_normal((n, 3)) * (0.4, 0.4, 0.1) - (0.0, 0.0, 1.0)).astype("f4")
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hit, u, v = found.intersect(origins, directions)
    expected = wanted.intersect(origins, directions)
    same = hit == expected[0]
    assert same.mean() > 0.998  # rays through edges may see either side
    assert len(np.unique(mesh.object_index[hit[hit >= 0]])) >= 3
    np.testing.assert_allclose(u[same], expected[1][same], atol=3e-4)
    np.testing.assert_allclose(v[same], expected[2][same], atol=3e-4)
    starts = rng.uniform(-1.5, 1.5, (n, 3)).astype(np.float32) + np.float32([0.0, 0.0, 1.2])
    ways = rng.standard_normal((n, 3)).astype(np.float32)
    blocked = wanted.occluded(starts, ways)
    assert 0.05 < blocked.mean() < 0.95
    assert (found.occluded(starts, ways) == blocked).mean() > 0.998
    reach = rng.uniform(0.1, 1.0, n).astype(np.float32)
    agree = found.occluded(starts, ways, reach=reach) == wanted.occluded(starts, ways, reach=reach)
    assert agree.mean() > 0.998


MOVES = {
    "one": {1: matrix_of(0.7, (0.2, 0.1, 0.3))},
    "two": {1: matrix_of(0.7, (0.2, 0.1, 0.3)), 2: matrix_of(-0.4, (-0.3, 0.2, 0.1), 1.3)},
    "the largest": {0: matrix_of(0.3, (0.1, -0.1, -0.2), 0.9)},
}


@pytest.mark.parametrize("large", [False, True], ids=["own hierarchies", "instances"])
def test_a_moved_roof_throws_its_colored_shadow(monkeypatch, large):
    """Each color as often as the roof lets it through; beside it, all of them."""
    monkeypatch.setattr(moved_accel, "_LARGE", 0 if large else 1 << 30)
    scene = make_scene(
        [floor(), floor(0.2, 1.0)], [diffuse()] * 2, constant_world(), camera_above()
    )
    places = np.tile(np.eye(4), (2, 1, 1))
    places[:, 0, 3] = 0.0, 1.0
    closure = Closure(DIFFUSE, GGX, np.ones(3, np.float32), {})
    tint = np.float32([0.8, 0.4, 0.2])
    program = Program(ops=(), closures=(closure,), transparent=tint)
    scene = dataclasses.replace(with_programs(scene, None, program), object_to_world=places)
    cache = RenderCache()
    assert cache.rays(scene).traversal.colored
    rays = cache.rays(with_moves(scene, {1: matrix_of(0.2, (5.0, 0.0, 0.0))}), quick=True)
    n = 10_000
    up = np.tile(np.float32([0.0, 0.0, 1.0]), (n, 1))
    under = np.random.default_rng(2).uniform(-0.1, 0.1, (n, 3)).astype(np.float32)
    under[:, 2] = 0.5
    assert not rays.occluded(under, up, np.empty(n, np.uint8)).any()
    under[:, 0] += 5.0
    blocked = rays.occluded(under, up, np.empty(n, np.uint8))
    shares = [1.0 - ((blocked >> k) & 1).mean() for k in range(3)]
    np.testing.assert_allclose(shares, tint, atol=0.02)  # four standard errors


@pytest.mark.parametrize("large", [False, True], ids=["own hierarchies", "instances"])
@pytest.mark.parametrize("name", MOVES)
def test_moved_objects_are_met_where_they_are(room, rng, monkeypatch, name, large):
    monkeypatch.setattr(moved_accel, "_LARGE", 0 if large else 1 << 30)
    now = with_moves(room, MOVES[name])
    base = Accel(room.mesh)
    moves = moves_between(room.object_to_world, now.object_to_world)
    assert list(moves.objects) == list(MOVES[name])
    assert_same_rays(moved(base, now.mesh, moves), now.mesh, rng)
    settled(base)
    assert_same_rays(base, room.mesh, rng)


def test_an_object_without_size_is_not_moved(room):
    places = room.object_to_world.copy()
    places[1, 0, 0] = 0.0
    assert moves_between(places, room.object_to_world) is None


def test_a_window_gets_quick_rays_and_then_the_best(room, rng):
    """Quick ones from the hierarchy that is there, in whatever order objects are moved."""
    cache = RenderCache()
    first = cache.rays(room, quick=True)
    assert type(first) is Accel
    near = with_moves(room, MOVES["one"])
    far = with_moves(near, MOVES["two"])
    for now in (near, far, with_moves(far, MOVES["the largest"])):
        quick = cache.rays(now, quick=True)
        assert type(quick) is MovedAccel
        assert_same_rays(quick, now.mesh, rng)

    def stopped():
        return True

    with pytest.raises(Cancelled):
        cache.rays(now, stopped)
    assert_same_rays(cache.rays(near, quick=True), near.mesh, rng)  # what was there is kept
    best = cache.rays(now)
    assert type(best) is Accel and best.mesh is now.mesh
    assert cache.rays(now, quick=True) is best
    assert cache.rays(room, quick=True).mesh is room.mesh


def test_other_triangles_get_a_hierarchy_of_their_own(room):
    cache = RenderCache()
    cache.rays(room)
    mesh = dataclasses.replace(room.mesh, triangles=room.mesh.triangles.copy())
    other = dataclasses.replace(room, mesh=mesh)
    assert type(cache.rays(other, quick=True)) is Accel


def test_hidden_objects_stay_hidden_where_others_move(room, rng):
    """Rays that differ in what they see: a box without shadow moves, a floor is unseen."""
    flags = np.full(len(room.object_pass_index), CAMERA_RAYS | SHADOW_RAYS, np.uint8)
    flags[1], flags[2] = CAMERA_RAYS, SHADOW_RAYS
    room = dataclasses.replace(room, object_flags=flags)
    cache = RenderCache()
    cache.rays(room)
    now = with_moves(room, MOVES["two"])
    quick, best = cache.rays(now, quick=True), RenderCache().rays(now)
    assert type(quick) is SceneRays
    assert type(quick._parts.camera.accel) is MovedAccel
    n = 5000
    starts = rng.uniform(-1.5, 1.5, (n, 3)).astype(np.float32) + np.float32([0.0, 0.0, 1.2])
    ways = rng.standard_normal((n, 3)).astype(np.float32)
    hit, wanted = (rays.intersect(starts, ways)[0] for rays in (quick, best))
    assert (hit == wanted).mean() > 0.998
    blocked, expected = (rays.occluded(starts, ways) for rays in (quick, best))
    assert (blocked == expected).mean() > 0.998


def test_the_picture_after_a_move_is_that_of_the_scene(room):
    """Coarse pictures from quick rays, the last one as of a scene that nobody moved."""
    settings = RenderSettings(stop_rule="FIXED", pixel_filter="CENTER", max_samples=16, tile_px=16)
    now = with_moves(room, MOVES["two"])

    def pictures(cache):
        shown = []
        own = cache, Pace(), StopFlag(), StopFlag()
        render_progressive(now, settings, lambda p: shown.append((p.step, copied(p))), *own)
        return shown

    cache = RenderCache()
    cache.rays(room)
    after, fresh = pictures(cache), pictures(RenderCache())
    np.testing.assert_array_equal(after[-1][1], fresh[-1][1])
    step, coarse = after[0]
    assert step == fresh[0][0] > 1
    np.testing.assert_allclose(coarse.mean(), fresh[0][1].mean(), rtol=0.02)


def copied(picture):
    return picture.layers["combined"].copy()


def test_warm_up_traces_rays_of_both_kinds(monkeypatch):
    """So that a window compiles nothing at the first drag: both meet the triangle that they are
    aimed at, through the hierarchies of what has moved."""
    traced = {}

    class Watched(MovedAccel):
        def intersect(self, origins, directions):
            traced["intersect"] = hits = super().intersect(origins, directions)
            return hits

        def occluded(self, origins, directions):
            traced["occluded"] = blocked = super().occluded(origins, directions)
            return blocked

    monkeypatch.setattr(moved_accel, "MovedAccel", Watched)
    moved_accel.warm_up()
    assert traced["intersect"][0].tolist() == [0]
    assert traced["occluded"].tolist() == [True]


@pytest.mark.parametrize("large", [False, True], ids=["own hierarchies", "instances"])
@pytest.mark.parametrize("able", [False, True], ids=["hit by hit", "by Embree's filter"])
def test_a_cut_out_lets_rays_through_where_it_has_moved_to(monkeypatch, rng, large, able):
    """Half of them, and nowhere else; its grid is not baked anew for it."""
    monkeypatch.setattr(moved_accel, "_LARGE", 0 if large else 1 << 30)
    monkeypatch.setattr(ray_masks, "can_filter", lambda: able)
    closure = Closure(DIFFUSE, GGX, np.full(3, 0.5, np.float32), {})
    half = Program(ops=(), closures=(closure,), transparent=np.full(3, 0.5, np.float32))
    camera = camera_above(4, 4)
    parts = [floor(5.0, -1.0), floor(1.0, 1.0)]
    scene = make_scene(parts, [diffuse(), diffuse()], constant_world(), camera)
    scene = with_programs(scene, None, half)
    scene = dataclasses.replace(scene, object_to_world=np.tile(np.eye(4), (2, 1, 1)))
    cache = RenderCache()
    cache.rays(scene)
    monkeypatch.setattr(render_cache, "ray_masks", None)
    quick = cache.rays(with_moves(scene, {1: matrix_of(0.0, (3.0, 0.0, 0.5))}), quick=True)
    assert quick.by_rays is not able
    assert type(quick._parts.camera.accel) is MovedAccel
    starts = np.zeros((4000, 3), np.float32)
    starts[:, 0] = rng.uniform(-4.0, 4.0, 4000)
    ways = rng.uniform(-0.05, 0.05, (4000, 3)).astype(np.float32)
    ways[:, 2] += 1.0
    blocked, x = quick.occluded(starts, ways), starts[:, 0]
    under, beside = (x > 2.1) & (x < 3.9), x < 1.9
    assert abs(blocked[under].mean() - 0.5) < 0.07  # four standard errors of some 900 rays
    assert not blocked[beside].any()

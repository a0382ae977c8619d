"""Looks that go on behind clear surfaces meet what lies just behind them, or in their very plane
(docs/decisions/0049-rays-that-go-on.md): embree_hits.py, embree_filter.pass_on, cutouts.py."""

import dataclasses

import numpy as np
import pytest

import iwis.core.embree.accel as accel_module
import iwis.core.see_through.ray_masks as ray_masks
from iwis.core.data.copies import Copies
from iwis.core.data.object_motion import ObjectMotion
from iwis.core.data.program import Closure, Program
from iwis.core.embree import moved_accel
from iwis.core.embree.accel import Accel, EmbreexScene
from iwis.core.embree.copied_accel import CopiedAccel
from iwis.core.embree.embree_hits import begin_rays
from iwis.core.embree.moved_accel import MovedAccel
from iwis.core.embree.moving_accel import MovingAccel
from iwis.core.embree.moving_copies import MovingCopies
from iwis.core.render_cache import RenderCache, with_rows
from iwis.core.scene import DIFFUSE, GGX
from iwis.core.see_through.cutouts import points_through
from iwis.core.settings import RenderSettings
from support.programs import pane, with_programs
from support.scenes import box, camera_at, constant_world, diffuse, floor, make_mesh, make_scene

_HALF = np.full(3, 0.5, np.float32)
# 18 steps of float32 at 5 metres from the eye; an offset of rays from a floor of 7.3 m is 1.4e-5.
_HAIR = np.float32(1e-6)
# Planes at these heights are rounded otherwise, and so are the rays' distances.
_HEIGHTS = [0.0, 0.37, -1.3]


def _scene(*parts, height=0.0):
    """A floor, and parts that let half of the light through: object 0, and 1, 2 ..."""
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.01, 0.0), 4, 4, 0.4)
    materials = [diffuse() for _ in range(1 + len(parts))]
    scene = make_scene([floor(7.3, height), *parts], materials, constant_world(), camera)
    places = np.tile(np.eye(4), (len(materials), 1, 1))
    clear = [pane(_HALF) for _ in parts]
    return dataclasses.replace(with_programs(scene, None, *clear), object_to_world=places)


def _looks(rng, n=4000, height=0.0):
    """From a place above to the middle of the floor."""
    to = np.concatenate([rng.uniform(-0.6, 0.6, (n, 2)), np.full((n, 1), height)], axis=1)
    origins = np.tile(np.float32([3.1, -5.2, height + 3.9]), (n, 1))
    directions = (to - origins).astype(np.float32)
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _seen(scene, accel, rays, most=8):
    """(object that each ray ends at, what it brings of that)."""
    n = len(rays[0])
    tints, far = np.ones((n, 3), np.float32), np.full(n, np.inf, np.float32)
    points = points_through(scene, accel, *rays, far, None, most, tints)
    seen = np.full(n, -1)
    seen[points.pixel] = scene.mesh.object_index[points.triangle]
    return seen, tints


@pytest.mark.parametrize("grids", [True, False], ids=["grids", "hit by hit"])
@pytest.mark.parametrize("height", [*_HEIGHTS, 1000.0])
@pytest.mark.parametrize("lift", [0.0, _HAIR, 3 * _HAIR])
def test_a_floor_is_seen_through_a_clear_box_that_stands_on_it(
    rng, monkeypatch, lift, height, grids
):
    """Every ray ends at the floor, with the tints of both sides of the box that it passes.

    Where the box stands in the floor, half of the rays meet that first: before its lower side.
    """
    monkeypatch.setattr(ray_masks, "can_filter", lambda: grids)
    z = np.float32(height) + np.float32(lift)
    lift = z - np.float32(height)
    scene = _scene(box((-0.9, -0.9, z), (0.9, 0.9, z + 0.4)), height=height)
    seen, tints = _seen(scene, RenderCache().rays(scene), _looks(rng, height=height))
    assert (seen == 0).all()
    passed = np.round(np.log2(tints[:, 0])).astype(int)
    assert set(passed) <= ({-2} if lift else {-1, -2})


@pytest.mark.parametrize("height", _HEIGHTS)
def test_a_floor_just_behind_is_seen_without_filters_too(rng, monkeypatch, height):
    """Where Embree asks no filter, a ray goes on from just behind the face: each side once."""
    monkeypatch.setattr(accel_module, "can_filter", lambda: False)
    monkeypatch.setattr(ray_masks, "can_filter", lambda: False)
    z = np.float32(height) + 3 * _HAIR
    scene = _scene(box((-0.9, -0.9, z), (0.9, 0.9, z + 0.4)), height=height)
    seen, tints = _seen(scene, RenderCache().rays(scene), _looks(rng, height=height))
    assert (seen == 0).all() and (tints == 0.25).all()


def test_panes_in_one_plane_are_passed_once_each(rng):
    """Two bodies, one on the other: a ray does not go to and fro between what touches."""
    low, top = np.float32(0.4), np.float32(0.8)
    lower, upper = box((-0.9, -0.9, 0.0), (0.9, 0.9, low)), box((-0.8, -0.8, low), (0.8, 0.8, top))
    scene = _scene(lower, upper, height=-1.0)
    seen, tints = _seen(scene, RenderCache().rays(scene), _looks(rng))
    assert (seen == 0).all()
    # A pane that is met just before the other one, and rounded behind it, is not met any more.
    through = np.round(np.log2(tints[:, 0])).astype(int)
    assert set(through) <= {-4, -3, -2} and (through == -4).mean() > 0.4


@pytest.mark.parametrize("grids", [True, False], ids=["grids", "hit by hit"])
def test_a_pane_is_passed_once_along_its_diagonal(monkeypatch, grids):
    """A ray there meets both of its triangles, as far away."""
    monkeypatch.setattr(ray_masks, "can_filter", lambda: grids)
    scene = _scene(floor(1.0, 0.5))
    t = np.linspace(-0.99, 0.99, 2001, dtype=np.float32)
    origins = np.stack([t, t, np.full_like(t, 5.0)], axis=1)
    down = np.tile(np.float32([0.0, 0.0, -1.0]), (len(t), 1))
    mirrored = origins * np.float32([1.0, -1.0, 1.0])
    looks = np.concatenate([origins, mirrored]), np.concatenate([down, down])
    seen, tints = _seen(scene, RenderCache().rays(scene), looks)
    assert (seen == 0).all() and (tints == 0.5).all()


def _shown(scene, kind):
    """Rays of a scene by some kind of hierarchy, in which the floor and the box are two parts."""
    mesh = scene.mesh
    first = np.flatnonzero(mesh.object_index == 1)[0]
    aside = np.eye(3, 4, dtype=np.float32)[None]
    aside[0, 0, 3] = 2.0  # one more, beside the box itself
    copies = Copies(
        np.int64([first]),
        np.int64([len(mesh.triangles)]),
        np.int32([0]),
        np.int32([2]),
        aside,
        np.eye(3, 4, dtype=np.float32)[None],
        np.zeros(1, np.bool_),
    )
    times = np.linspace(0.0, 1.0, 2)
    motion = ObjectMotion(np.int32([0]), times, np.tile(np.eye(4), (2, 1, 1, 1)))
    if "copies" in kind:
        indices = np.arange(3, dtype=np.float32)
        scene = dataclasses.replace(scene, copies=copies, object_pass_index=indices)
    if "moving" in kind:
        scene = dataclasses.replace(scene, motion=motion)
    rays = RenderCache().rays(scene)
    return with_rows(scene, rays, RenderSettings(), 1)


@pytest.mark.parametrize(
    ("kind", "hierarchy"),
    [
        ("copies", CopiedAccel),
        ("moving", MovingAccel),
        ("moving copies", MovingCopies),
    ],
)
def test_faces_of_two_parts_lie_in_one_plane(rng, kind, hierarchy):
    """Parts count their faces each from 0: a face of one is not taken for another's."""
    scene, rays = _shown(_scene(floor(0.9, 0.0)), kind)
    assert type(rays._parts.camera.accel) is hierarchy
    seen, _ = _seen(scene, rays, _looks(rng))
    assert (seen == 0).all()


@pytest.mark.parametrize("large", [False, True], ids=["own hierarchies", "instances"])
def test_a_moved_pane_lies_in_the_plane_of_the_floor(rng, monkeypatch, large):
    """By the hierarchies of what has moved, and again once they are settled."""
    monkeypatch.setattr(moved_accel, "_LARGE", 0 if large else 1 << 30)
    cache, there = RenderCache(), _scene(floor(0.9, 0.0))
    away = there.mesh.vertices + np.float32([0.0, 0.0, 1.0]) * (np.arange(8) >= 4)[:, None]
    places = there.object_to_world.copy()
    places[1, 2, 3] = 1.0
    mesh = dataclasses.replace(there.mesh, vertices=away)
    before = dataclasses.replace(there, mesh=mesh, object_to_world=places)
    cache.rays(before)
    quick = cache.rays(there, quick=True)
    assert type(quick._parts.camera.accel) is MovedAccel
    assert (_seen(there, quick, _looks(rng))[0] == 0).all()
    settled = cache.rays(there)
    assert (_seen(there, settled, _looks(rng))[0] == 0).all()


def test_shadow_rays_hit_by_hit_meet_what_is_just_behind(rng, monkeypatch):
    """A clear card a hair before one that blocks: nothing comes through, whatever the offset."""
    monkeypatch.setattr(ray_masks, "can_filter", lambda: False)
    black = Closure(DIFFUSE, GGX, np.ones(3, np.float32), {})
    blocks = Program(ops=(), closures=(black,), transparent=np.zeros(3, np.float32))
    parts = [floor(7.3, -1.0), floor(0.9, 3 * _HAIR), floor(0.9, 0.0)]
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.01, 0.0), 4, 4, 0.4)
    scene = make_scene(parts, [diffuse() for _ in parts], constant_world(), camera)
    scene = with_programs(scene, None, pane(np.ones(3, np.float32)), blocks)
    rays = RenderCache().rays(scene)
    assert rays.by_rays and rays.offset > 3 * _HAIR
    origins, directions = _looks(rng)
    far = np.full(len(origins), 9.0, np.float32)
    short = np.full(len(origins), 5.0, np.float32)
    assert rays.occluded(origins, directions, reach=far).all()
    assert not rays.occluded(origins, directions, reach=short).any()


def test_embreex_goes_on_behind_a_face_as_well(rng):
    """The slow way: from one floor to the next below it, and to none after that."""
    vertices, triangles = (
        np.concatenate([floor(7.3, 1.0)[0], floor(7.3, 0.0)[0]]).astype(np.float32),
        np.concatenate([floor()[1], 4 + floor()[1]]).astype(np.int32),
    )
    slow = EmbreexScene(vertices, triangles)
    slow.commit(lambda: False)
    accel = Accel(make_mesh(floor(7.3, 1.0), floor(7.3, 0.0)))
    accel.pairs, accel.traversal = None, slow.traversal()
    origins, directions = _looks(rng, 200)
    gone = begin_rays(200)
    hits = [accel.intersect(origins, directions, gone=gone)[0] // 2 for _ in range(3)]
    assert (hits[0] == 0).all() and (hits[1] == 1).all() and (hits[2] < 0).all()

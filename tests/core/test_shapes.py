"""Meshes that change their shape while the shutter is open: rays, and the shapes of hits."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Shaders, SurfaceData
from iwis.core.embree.accel import Accel
from iwis.core.embree.moving_accel import MovingAccel
from iwis.core.geometry.poses import points_at_rest, posed_points
from iwis.core.geometry.shading import shading_points
from iwis.core.geometry.shapes import shaped
from iwis.core.nodes import ShadeContext
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CAMERA_RAYS, SHADOW_RAYS
from iwis.core.tiles.time_slices import scene_at
from support.scenes import box, floor, make_mesh, varied_scene
from support.shapes import bent, mesh_at, shapes_of, shift, standing

BOTH = CAMERA_RAYS | SHADOW_RAYS


@pytest.fixture(scope="module")
def room():
    """The varied scene, of which a box bends and moves and a sphere bends, in other steps."""
    scene = varied_scene()
    shapes = shapes_of(scene.mesh, [1], bent), shapes_of(scene.mesh, [2], bent, steps=3)
    return dataclasses.replace(scene, motion=standing(shapes, [1], [shift]))


def looks(rng, n=6000):
    origins = np.tile(np.float32([-0.15, 0.0, 2.5]), (n, 1))
    directions = rng.standard_normal((n, 3)) * (0.2, 0.15, 0.1) - np.array([0.0, 0.0, 1.0])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return origins, directions.astype(np.float32)


@pytest.mark.parametrize("number", [0, 13, 32, 63])
def test_a_slice_is_the_scene_in_its_shape(room, rng, number):
    """Hits, places, normals and occlusion are those of a mesh whose vertices were moved."""
    scene, still = scene_at(room, number), Accel(mesh_at(room, number))
    rays = RenderCache().rays(room).at(number, scene)
    origins, directions = looks(rng)
    hit, u, _ = rays.intersect(origins, directions)
    wanted, wanted_u, wanted_v = still.intersect(origins, directions)
    same = hit == wanted
    assert same.mean() > 0.998  # rays through edges may see either side
    assert np.isin(scene.mesh.object_index[hit[hit >= 0]], [1, 2]).mean() > 0.2
    np.testing.assert_allclose(u[same], wanted_u[same], atol=2e-4)
    hit = np.where(same, hit, -1).astype(np.int32)
    found = posed_points(scene.pose, scene.mesh, hit, wanted_u, wanted_v, directions)
    points = shading_points(still.mesh, hit, wanted_u, wanted_v, directions)
    np.testing.assert_array_equal(found.triangle, points.triangle)
    for name in ("position", "wo", "geometric_normal", "normal", "lift"):
        np.testing.assert_allclose(getattr(found, name), getattr(points, name), atol=2e-5)
    starts = points.position + np.float32(1e-3) * points.geometric_normal
    ways = rng.standard_normal(starts.shape).astype(np.float32)
    agree = rays.occluded(starts, ways) == still.occluded(starts, ways)
    assert agree.mean() > 0.998


def test_at_rest_it_is_the_mesh_table(room, rng):
    """The middle, of which Depth and Position are, meets what an Accel meets."""
    origins, directions = looks(rng, 1000)
    found = MovingAccel(room.mesh, room.motion).intersect(origins, directions)
    wanted = Accel(room.mesh).intersect(origins, directions)
    assert (found[0] == wanted[0]).mean() > 0.995


@pytest.mark.parametrize("hidden", [0, 1, 2])
def test_objects_that_the_camera_does_not_see_change_their_shape_too(room, rng, hidden):
    """Hierarchies of some of the triangles know shapes by their own rows."""
    flags = np.full(5, BOTH, np.uint8)
    flags[hidden] = SHADOW_RAYS
    scene, number = dataclasses.replace(room, object_flags=flags), 7
    rays = RenderCache().rays(scene).at(number, scene_at(scene, number))
    mesh = mesh_at(room, number)
    kept = np.flatnonzero(mesh.object_index != hidden)
    still = Accel(
        dataclasses.replace(
            mesh,
            triangles=mesh.triangles[kept],
            corner_normals=mesh.corner_normals[kept],
            material_index=mesh.material_index[kept],
            object_index=mesh.object_index[kept],
        )
    )
    origins, directions = looks(rng)
    hit, wanted = rays.intersect(origins, directions)[0], still.intersect(origins, directions)[0]
    wanted = np.where(wanted >= 0, kept[wanted], -1)
    assert (hit == wanted).mean() > 0.998  # edges, as above
    ways = rng.standard_normal(origins.shape).astype(np.float32)
    agree = rays.occluded(origins, ways) == Accel(mesh).occluded(origins, ways)
    assert agree.mean() > 0.998


def test_shapes_among_some_rows_are_those():
    """Rows that are gone are gone, the others count anew."""
    mesh = make_mesh(floor(), box((0, 0, 1), (1, 1, 2)))
    shapes = shapes_of(mesh, [1], bent)
    rows = np.array([0, 3, 4, 13])
    some = shapes.among(rows)
    np.testing.assert_array_equal(rows[some.triangle], [3, 4, 13])
    np.testing.assert_array_equal(some.corners, shapes.corners[[1, 2, 11]])
    np.testing.assert_array_equal(some.normal_index, shapes.normal_index[[1, 2, 11]])
    assert len(shapes.among(np.zeros(0, int)).triangle) == 0


def test_between_two_steps_corners_go_straight(room):
    """At a step there, half way between two at their mean, at the ends within: float32's 1e-6."""
    shapes, mesh, pose = room.motion.shapes[0], room.mesh, scene_at(room, 0).pose
    last = len(shapes.positions) - 1

    def corners(time):
        own, faces = shaped(pose._replace(time=time), mesh, shapes.triangle)
        return own.vertices[own.triangles[faces]]

    for step in range(last):
        expected = shapes.positions[step][shapes.corners]
        np.testing.assert_allclose(corners(step / last), expected, atol=1e-6)
        mean = 0.5 * (expected + shapes.positions[step + 1][shapes.corners])
        np.testing.assert_allclose(corners((step + 0.5) / last), mean, atol=1e-6)
    end = shapes.positions[last][shapes.corners]
    np.testing.assert_allclose(corners(1.0), end, atol=1e-6)


def test_what_keeps_its_shape_is_not_copied(room):
    """Triangles of the floor alone: the mesh table itself, and so of scenes without motion."""
    rows = np.flatnonzero(room.mesh.object_index == 0).astype(np.int32)
    pose = scene_at(room, 3).pose
    for own in (pose, pose._replace(shapes=()), None):
        mesh, faces = shaped(own, room.mesh, rows)
        assert mesh is room.mesh and faces is rows


def test_rays_start_as_far_off_as_the_farthest_shape_asks():
    """A box that is 1000 m away at the first step, and another one that moves from there."""
    mesh = make_mesh(floor(), box((0, 0, 1), (1, 1, 2)))
    far = shapes_of(mesh, [1], lambda p, t: p + np.array([2000.0 * t, 0.0, 0.0]))
    near = MovingAccel(mesh, standing([shapes_of(mesh, [1], bent)])).offset
    assert MovingAccel(mesh, standing([far])).offset == pytest.approx(1001 * 2.0**-18, rel=0.01)
    moved = MovingAccel(mesh, standing([far], [1], [shift])).offset
    assert moved > 1000 * 2.0**-18 > 100 * near


def test_nodes_know_where_points_lie_on_what_has_changed(room, rng):
    """Weights of corners are those of the hit; a step aside in the face's plane adds to them."""
    number = 5
    scene = scene_at(room, number)
    surface = SurfaceData(**dict.fromkeys(SurfaceData.__dataclass_fields__))
    shaders = Shaders(programs=(), surface=surface, material_pass_index=np.zeros(5, np.float32))
    object.__setattr__(scene, "shaders", shaders)
    origins, directions = looks(rng)
    hit, u, v = RenderCache().rays(room).at(number, scene).intersect(origins, directions)
    points = posed_points(scene.pose, scene.mesh, hit, u, v, directions)
    context = ShadeContext.of_points(scene, points_at_rest(scene.pose, scene.mesh, points))
    own = np.isin(scene.mesh.object_index[points.triangle], [1, 2])
    assert own.sum() > 500
    weights = np.stack([u, v], -1)[points.pixel]
    np.testing.assert_allclose(context.barycentric[own], weights[own], atol=2e-4)
    mesh, faces = shaped(scene.pose, scene.mesh, points.triangle)
    a, b, _ = (mesh.vertices[mesh.triangles[faces, k]] for k in range(3))
    moved = context.moved((0.25 * (b - a)).astype(np.float32))
    np.testing.assert_allclose(moved.barycentric[:, 0] - 0.25, context.barycentric[:, 0], atol=2e-3)
    np.testing.assert_allclose(moved.barycentric[:, 1], context.barycentric[:, 1], atol=2e-3)

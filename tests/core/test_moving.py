"""Objects that move while the shutter is open: slices of time, poses, Embree's instances."""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera.pass_rays import pass_slices
from iwis.core.data.asked_passes import AskedPasses, UvMaps
from iwis.core.data.object_motion import ObjectMotion
from iwis.core.embree.accel import Accel
from iwis.core.embree.moving_accel import MovingAccel
from iwis.core.geometry.poses import posed_points
from iwis.core.geometry.shading import shading_points
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CameraMotion
from iwis.core.settings import RenderSettings
from iwis.core.tiles.time_slices import scene_at
from support.scenes import (
    black,
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_mesh,
    make_picture,
    make_scene,
    quad,
    varied_scene,
)

SLICES = 64
TIMES = (np.arange(SLICES) + 0.5) / SLICES


def turn_and_shift(angle, shift):
    """About z, then along."""
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    matrix[:3, 3] = shift
    return matrix


def motion_of(objects, matrices_of_time) -> ObjectMotion:
    """matrices_of_time: for each object, a function of -0.5 ... 0.5."""
    matrices = [[f(t - 0.5) for f in matrices_of_time] for t in TIMES]
    return ObjectMotion(np.array(objects, np.int32), TIMES, np.array(matrices))


def standing_camera(camera):
    motion = CameraMotion(
        camera.camera_to_world[None], np.array([camera.window]), np.linspace(0.0, 1.0, 2)
    )
    return dataclasses.replace(camera, motion=motion)


def moved_mesh(scene, number):
    """The mesh table with the moving objects where they are in a slice: the slow way."""
    mesh, motion = scene.mesh, scene.motion
    vertices, normals = mesh.vertices.copy(), mesh.corner_normals.copy()
    for k, row in enumerate(motion.objects):
        matrix = motion.matrices[number, k]
        own = mesh.object_index == row
        which = np.unique(mesh.triangles[own])
        vertices[which] = mesh.vertices[which] @ matrix[:3, :3].T + matrix[:3, 3]
        turned = normals[own] @ np.linalg.inv(matrix[:3, :3])
        normals[own] = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    return dataclasses.replace(mesh, vertices=vertices, corner_normals=normals)


@pytest.fixture(scope="module")
def moving_room():
    """The varied scene, of which a box turns and a sphere grows."""

    def grow(t):
        matrix = np.diag([1.0 + t, 1.0 + t, 1.0 + t, 1.0])
        matrix[:3, 3] = (0.4 * t, 0.2 * t, 0.0)
        return matrix

    motion = motion_of([1, 2], [lambda t: turn_and_shift(0.8 * t, (0.3 * t, 0.0, 0.2 * t)), grow])
    return dataclasses.replace(varied_scene(), motion=motion)


@pytest.mark.parametrize("number", [0, 31, 63])
def test_a_slice_is_the_scene_with_its_objects_moved(moving_room, rng, number):
    """Hits, places, normals and occlusion are those of a mesh whose vertices were moved."""
    moving = MovingAccel(moving_room.mesh, moving_room.motion)
    scene = scene_at(moving_room, number)
    rays = RenderCache().rays(moving_room).at(number, scene)
    still = Accel(moved_mesh(moving_room, number))
    origins = np.tile(np.float32([0.2, -0.3, 3.0]), (4000, 1))
    directions = rng.standard_normal((4000, 3)).astype(np.float32) * (0.3, 0.3, 0.1)
    directions = (directions - np.array([0.0, 0.0, 1.0])).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hit, u, _ = moving.at(number).intersect(origins, directions)
    wanted, wanted_u, wanted_v = still.intersect(origins, directions)
    same = hit == wanted
    assert same.mean() > 0.998  # rays through edges may see either side
    np.testing.assert_allclose(u[same], wanted_u[same], atol=2e-4)
    hit = np.where(same, hit, -1).astype(np.int32)
    found = posed_points(scene.pose, scene.mesh, hit, wanted_u, wanted_v, directions)
    points = shading_points(still.mesh, hit, wanted_u, wanted_v, directions)
    for name in ("position", "wo", "geometric_normal", "normal", "lift"):
        np.testing.assert_allclose(getattr(found, name), getattr(points, name), atol=2e-5)
    starts = points.position + np.float32(1e-3) * points.geometric_normal
    ways = rng.standard_normal(starts.shape).astype(np.float32)
    agree = rays.occluded(starts, ways) == still.occluded(starts, ways)
    assert agree.mean() > 0.998


def test_at_rest_it_is_the_mesh_table(moving_room, rng):
    """The middle pose, of which Depth and Position are, meets what an Accel meets."""
    origins = rng.uniform(-1.0, 1.0, (500, 3)).astype(np.float32) + np.float32([0.0, 0.0, 3.0])
    directions = np.tile(np.float32([0.0, 0.0, -1.0]), (500, 1))
    found = MovingAccel(moving_room.mesh, moving_room.motion).intersect(origins, directions)
    wanted = Accel(moving_room.mesh).intersect(origins, directions)
    assert (found[0] == wanted[0]).mean() > 0.995


def test_pixels_see_every_part_of_the_time():
    """In 4 passes each quarter once, in 64 every slice once; four passes show 8 slices."""
    columns, rows = (a.ravel().astype(np.int64) for a in np.meshgrid(range(32), range(32)))
    seen = np.array([pass_slices(RenderSettings(), columns, rows, k, SLICES) for k in range(64)])
    for k in range(0, 64, 4):
        assert (np.sort(seen[k : k + 4] // 16, axis=0) == np.arange(4)[:, None]).all()
        assert len(np.unique(seen[k : k + 4])) == 8
    assert (np.sort(seen, axis=0) == np.arange(SLICES)[:, None]).all()
    number = np.arange(len(columns)) % 64  # each pixel at a pass of its own
    own = pass_slices(RenderSettings(), columns, rows, number, SLICES)
    np.testing.assert_array_equal(own, seen[number, np.arange(len(columns))])


@pytest.mark.parametrize("slices", [8, 16, SLICES])
@pytest.mark.parametrize("passes", [4, 8, 12])
def test_few_passes_see_the_middle_of_the_time(slices, passes):
    """Pixels that end after a few show what moves where it is on average, not where it was."""
    columns, rows = (a.ravel().astype(np.int64) for a in np.meshgrid(range(64), range(64)))
    own = RenderSettings(), columns, rows
    seen = np.mean([pass_slices(*own, k, slices) for k in range(passes)], axis=0)
    assert abs(seen.mean() - (slices - 1) / 2) <= 4.0 * seen.std() / 64.0
    assert seen.std() < slices / 12.0


@pytest.mark.slow
def test_uv_moves_with_its_object():
    """A floor that goes 1.2 m along x: the mean place on its map lies .6 m behind."""
    camera = standing_camera(camera_above(16, 8))
    motion = motion_of([0], [lambda t: turn_and_shift(0.0, (1.2 * (t + 0.5), 0.0, 0.0))])
    scene = make_scene([floor(4.0)], [diffuse()], constant_world(), camera)
    corners = scene.mesh.vertices[scene.mesh.triangles][..., :2].astype(np.float32)
    maps = UvMaps(np.arange(len(corners), dtype=np.int32), corners, np.array([False]))
    asked = AskedPasses(uv=maps)
    scene = dataclasses.replace(scene, motion=motion, asked=asked)
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 128}
    uv = make_picture(scene, **settings)[0]["uv"]
    middle = (np.arange(16) + 0.5) / 16 * 1.8 - 0.9
    # 8 x 16 passes at drawn times in sixteenths of the shutter's: .35 m / 16 / sqrt(8) and less.
    np.testing.assert_allclose(uv[..., 0].mean(axis=0), middle - 0.6, atol=0.03)
    np.testing.assert_allclose(uv[..., 2], 1.0, atol=1e-6)


@pytest.mark.slow
def test_a_bright_square_that_passes_is_spread_as_its_time():
    """A glowing square of width .3 that goes 1.2 m: the share of the time that it is in a pixel."""
    camera = standing_camera(camera_above(48, 8))
    square = quad((-0.15, -2.0, 0.0), (0.3, 0.0, 0.0), (0.0, 4.0, 0.0))
    motion = motion_of([0], [lambda t: turn_and_shift(0.0, (1.2 * t, 0.0, 0.0))])
    scene = make_scene([square], [black(emission=(1.0,) * 3)], constant_world((0.0,) * 3), camera)
    scene = dataclasses.replace(scene, motion=motion)
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 512}
    layers, _ = make_picture(scene, **settings)
    x = np.linspace(-0.9, 0.9, 49)
    middle = 0.5 * (x[1:] + x[:-1])
    # The square's edges pass the place within the shutter's time of 1.2 m.
    wanted = np.clip(
        (np.minimum(middle + 0.15, 0.6) - np.maximum(middle - 0.15, -0.6)) / 1.2, 0.0, 0.25
    )
    found = layers["combined"][..., 0].mean(axis=0)
    assert found.sum() == pytest.approx(wanted.sum(), rel=0.01)
    # A slice of 64 more or less is .016; a column's 8 x 128 passes have a standard error of .0135.
    np.testing.assert_allclose(found, wanted, atol=0.05)
    assert np.abs(found - wanted).mean() < 0.0135


@pytest.mark.slow
def test_shadows_of_moving_objects_are_the_mean_over_the_time():
    """The floor under a moving box has the mean of the pictures of boxes that stand in slices."""
    camera = standing_camera(camera_above(24, 24))
    motion = motion_of([1], [lambda t: turn_and_shift(1.0 * t, (0.5 * t, 0.0, 0.0))])
    parts = [floor(1.2), box((-0.2, -0.2, 0.3), (0.2, 0.2, 0.6))]
    still = make_scene(parts, [diffuse(), diffuse()], constant_world(), camera)
    scene = dataclasses.replace(still, motion=motion)
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "threads": 2}
    found = make_picture(scene, max_samples=1024, **settings)[0]["combined"]
    wanted = 0.0
    for number in range(2, SLICES, 4):
        mesh = moved_mesh(scene, number)
        one = dataclasses.replace(still, mesh=mesh)
        wanted = wanted + make_picture(one, max_samples=128, **settings)[0]["combined"] / 16.0
    difference = (found - wanted)[..., 0]
    assert abs(difference.mean()) < 0.003 * wanted[..., 0].mean()
    # 16 places of .03 m in the second mean, .075 m a pixel; and the noise of 1024 samples.
    assert np.abs(difference).mean() < 0.015


def test_pictures_do_not_depend_on_tiles_or_threads(moving_room):
    """To the last bit, as without motion."""
    room = dataclasses.replace(moving_room, camera=standing_camera(moving_room.camera))
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 16}
    one = make_picture(room, tile_px=64, **settings)[0]["combined"]
    two = make_picture(room, tile_px=8, **{**settings, "threads": 2})[0]["combined"]
    np.testing.assert_array_equal(one, two)


def test_center_stays_sharp_and_says_so(moving_room):
    """One point a pixel: the middle pose, with the warning."""
    layers, stats = make_picture(moving_room, max_samples=8, stop_rule="FIXED")
    still = dataclasses.replace(moving_room, motion=None)
    np.testing.assert_array_equal(
        layers["combined"], make_picture(still, max_samples=8, stop_rule="FIXED")[0]["combined"]
    )
    assert any("no motion blur" in line for line in stats.warnings)


def test_moving_objects_without_a_triangle_are_no_trouble():
    """All that moves may have been left out, and all that there is may move."""
    mesh = make_mesh(floor())
    shift = motion_of([0, 1], [lambda t: turn_and_shift(0.0, (t, 0.0, 0.0))] * 2)
    origins, directions = np.float32([[0, 0, 1]]), np.float32([[0, 0, -1]])
    assert MovingAccel(mesh, shift).at(3).intersect(origins, directions)[0][0] >= 0
    gone = shift._replace(objects=np.array([5, 6], np.int32))
    assert MovingAccel(mesh, gone).at(3).intersect(origins, directions)[0][0] >= 0


def test_objects_that_no_ray_sees_may_move_alone(moving_room):
    """The camera sees no triangle, and lamps' shadow rays none either: both are empty parts."""
    flags = np.zeros(len(moving_room.object_pass_index), np.uint8)
    layers, _ = make_picture(
        dataclasses.replace(moving_room, object_flags=flags),
        max_samples=8,
        pixel_filter="BLACKMAN_HARRIS",
    )
    assert not layers["samples"].any()

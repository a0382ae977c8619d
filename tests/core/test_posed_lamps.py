"""Faces that shine on objects that move or change their shape: where their light comes from."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.lamps import MESH, SPHERE
from iwis.core.lamplight import posed_lamps
from iwis.core.lamplight.emitters import with_emitters
from iwis.core.tiles.time_slices import scene_at
from support.scenes import (
    black,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    quad,
    sphere,
)
from support.shapes import SLICES, shapes_of, shift, standing, standing_camera

DARK = constant_world((0.0,) * 3)


def widened(vertices, t):
    return vertices * np.array([1.0 + t, 1.0 - 0.5 * t, 1.0])


def shining(parts, materials, moves, change, **fields):
    """A scene of which object 1 shines; it moves, or changes its shape, or both."""
    camera = standing_camera(camera_above(16, 16, half=1.2))
    scene = make_scene(parts, materials, DARK, camera)
    lamps = with_emitters(fields.get("rows", []), scene.mesh, scene.materials.emission, scene)
    shapes = [shapes_of(scene.mesh, [1], change, steps=3)] if change else []
    motion = standing(shapes, [1] if moves else [], [shift])
    return dataclasses.replace(scene, lamps=lamps, motion=motion)


def still_at(scene, number):
    """The scene with the table as it is in a slice, and lamps made of that: the slow way."""
    mesh, motion, time = scene.mesh, scene.motion, scene.motion.times[number]
    own, vertices = mesh.object_index == 1, mesh.vertices.copy()
    which = np.unique(mesh.triangles[own])
    if motion.shapes:
        vertices[which] = widened(vertices[which], time - 0.5)
    if len(motion.objects):
        matrix = motion.matrices[number, 0]
        vertices[which] = vertices[which] @ matrix[:3, :3].T + matrix[:3, 3]
    mesh = dataclasses.replace(mesh, vertices=vertices.astype(np.float32))
    lamps = with_emitters([], mesh, scene.materials.emission, scene)
    return dataclasses.replace(scene, mesh=mesh, lamps=lamps, motion=None)


def sorted_corners(lamps):
    there = lamps.faces.power[:, 0] > 0.0
    corners = np.round(lamps.faces.corners[there].reshape(-1, 9), 4)
    return corners[np.lexsort(corners.T)]


BALL = [floor(1.2), sphere((0.1, 0.0, 0.8), 0.3, rings=8)], [diffuse(), black(emission=(3.0,) * 3)]


@pytest.mark.parametrize(("moves", "change"), [(True, None), (False, widened), (True, widened)])
@pytest.mark.parametrize("number", [0, 40, 63])
def test_lamps_of_a_slice_are_those_of_its_mesh(moves, change, number):
    """Faces, powers and boxes; a ball around each."""
    scene = shining(*BALL, moves, change)
    found = scene_at(scene, number).lamps
    wanted = still_at(scene, number).lamps
    np.testing.assert_allclose(sorted_corners(found), sorted_corners(wanted), atol=1.1e-4)
    assert found.faces.power.sum() == pytest.approx(wanted.faces.power.sum(), rel=1e-5)
    for row in np.flatnonzero(found.kind == MESH):
        first, end, root = found.span[row]
        corners, node = found.faces.corners[first:end], found.faces.nodes[root]
        assert (node[:3] <= corners.min((0, 1))).all() and (node[3:6] >= corners.max((0, 1))).all()
        assert node[6] == pytest.approx(found.faces.power[first:end].mean(1).sum(), rel=1e-5)
        away = np.linalg.norm(corners - found.position[row], axis=-1).max()
        assert away <= 0.5 * found.size[row, 0] * (1.0 + 1e-5)


def test_lamps_that_stand_are_shared():
    """Where nothing that shines moves, and lamps that are no meshes: the same table, or rows."""
    scene = shining([floor(), BALL[0][1]], [black(emission=(1.0,) * 3), diffuse()], True, widened)
    assert scene_at(scene, 3).lamps is scene.lamps
    rows = [{"kind": SPHERE, "position": (0, 0, 3), "size": (0.1, 0), "radiance": (1, 1, 1)}]
    scene = shining(*BALL, True, None, rows=rows)
    found = scene_at(scene, 3).lamps
    np.testing.assert_array_equal(found.position[0], scene.lamps.position[0])
    assert not np.array_equal(found.position[1:], scene.lamps.position[1:])


def test_too_many_faces_shine_from_the_middle_and_say_so(monkeypatch):
    """By one line; of faces that stand none."""
    monkeypatch.setattr(posed_lamps, "_MOST_FACES", 1000)
    scene = shining(*BALL, True, None)
    assert scene_at(scene, 3).lamps is scene.lamps
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "max_samples": 4}
    stats = make_picture(scene, **settings)[1]
    assert sum("faces shine" in line for line in stats.warnings) == 1
    motion = scene.motion._replace(objects=np.array([0], np.int32))
    stats = make_picture(dataclasses.replace(scene, motion=motion), **settings)[1]
    assert not [line for line in stats.warnings if "faces shine" in line]


@pytest.mark.slow
@pytest.mark.parametrize(("moves", "change"), [(True, None), (False, widened)])
def test_light_of_faces_in_motion_is_the_mean_over_the_time(moves, change):
    """The floor under a square that shines: the mean of the pictures of squares that stand."""
    square = quad((-0.2, -0.2, 0.3), (0, 0.4, 0), (0.4, 0, 0))
    scene = shining([floor(1.2), square], [diffuse(), black(emission=(5.0,) * 3)], moves, change)
    settings = {"pixel_filter": "BOX", "stop_rule": "FIXED", "threads": 2}
    found = make_picture(scene, max_samples=1024, **settings)[0]["combined"]
    wanted = 0.0
    for number in range(2, SLICES, 4):
        still = still_at(scene, number)
        wanted = wanted + make_picture(still, max_samples=128, **settings)[0]["combined"] / 16.0
    # Not where the square itself is seen: of that there are 16 places in the second mean.
    lit = np.abs(wanted[..., 0] - found[..., 0]) < 1.0
    lit &= (wanted[..., 0] > 0.0) & (np.hypot(*np.mgrid[-8:8, -8:8]) > 5)
    assert lit.sum() > 100
    difference = (found - wanted)[..., 0][lit]
    assert abs(difference.mean()) < 0.01 * wanted[..., 0][lit].mean()
    assert np.abs(difference).mean() < 0.05 * wanted[..., 0][lit].mean()  # noise of 1024 samples

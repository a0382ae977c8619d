"""Strands, points and meshes with velocities at other times: where their vertices go."""

import numpy as np
from parity.element_cases import add_curves, add_particle_hair, add_points, bent_strands
from parity.movers import by_keys, lean, with_velocity

from iwis.iwis_addon.export.meshes.strand_tubes import Strands, choose_shape
from support.frames import exported_in_motion, objects_of


def leaning(middle, t):
    """Where parity.movers.lean has places at a time from the frame."""
    return middle + np.float32([0.6 * t, 0.0, 0.0]) * middle[..., 2:]


def test_strands_bend_with_their_keys(parts):
    """Rings of tubes go where the nodes have their keys, round, and turned alike."""
    scene, *_, floor = parts
    places, radii = bent_strands(24, 5), np.full((24, 5), 0.05, np.float32)
    lean(add_curves(floor.data.materials[0], places, radii))
    scene.cycles_curves.shape = "THICK"
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and objects_of(found, shapes) == {3}
    keys = np.concatenate([places, radii[..., None]], axis=-1).reshape(-1, 4)
    sides = choose_shape(Strands(keys, np.arange(0, 121, 5)), 16, False).sides
    rings = shapes.positions.reshape(3, -1, sides, 3)
    middles = rings[1].mean(axis=1)
    for step, t in ((0, -0.5), (2, 0.5)):  # a spline of keys that lean leans as they do
        np.testing.assert_allclose(rings[step].mean(axis=1), leaning(middles, t), atol=2e-6)
    away = np.linalg.norm(rings - rings.mean(axis=2, keepdims=True), axis=-1)
    np.testing.assert_allclose(away, away[0, 0, 0], rtol=1e-4)
    # The strands lean by 17 degrees; corners that were turned by a side more would be at .3.
    moved = np.einsum("kni,kni->kn", shapes.normals[[0, 2]], shapes.normals[[1, 1]])
    assert moved.min() > 0.9


def test_points_move_with_their_spheres(parts):
    """Centres go where the nodes have them; normals stay."""
    *_, floor = parts
    places = np.random.default_rng(2).uniform(-1.0, 1.0, (20, 3)).astype(np.float32)
    radii = np.linspace(0.05, 0.2, 20, dtype=np.float32)
    lean(add_points(floor.data.materials[0], places, radii))
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == []
    shift = shapes.positions - shapes.positions[1]
    assert np.abs(shift[..., 1:]).max() < 1e-6
    for step, t in ((0, -0.5), (2, 0.5)):
        wanted = np.sort(0.6 * t * places[:, 2])
        rounded = np.unique(np.round(shift[step, :, 0], 5))
        np.testing.assert_allclose(rounded, wanted, atol=2e-5)
        np.testing.assert_array_equal(shapes.normals[step], shapes.normals[1])


def test_hair_goes_along_with_what_it_grows_on(parts):
    """Particle hair of a sphere with a shape key: both change."""
    _, sphere, *_ = parts
    by_keys(sphere)
    add_particle_hair(sphere, 30, radius_scale=0.02)
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(objects_of(found, shapes)) == 2
    for row in objects_of(found, shapes):
        own = np.unique(shapes.corners[found.mesh.object_index[shapes.triangle] == row])
        shift = shapes.positions[:, own] - shapes.positions[1, own]
        assert 0.1 < np.abs(shift[0]).max() < 1.0
        np.testing.assert_allclose(shift[0], -shift[2], atol=0.1)  # roots go straight


def test_meshes_go_along_velocities(parts):
    """Half a shutter's time to either side, in three times, whatever the object's steps are."""
    scene, sphere, *_ = parts
    sphere.cycles.motion_steps = 3
    scene.render.fps, scene.render.motion_blur_shutter = 10, 0.5
    with_velocity(sphere, size=4.0)
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(shapes.positions) == 3
    middle = shapes.positions[1]
    for step, seconds in ((0, -0.025), (2, 0.025)):
        wanted = middle + np.float32([4.0 * seconds, 0.0, 0.0]) * middle[:, 2:]
        np.testing.assert_allclose(shapes.positions[step], wanted, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(shapes.normals, axis=-1), 1.0, atol=1e-6)
    # The normal (x, y, z) of what is sheared by s becomes (x, y, z - s x), made unit.
    x, _, z = shapes.normals[1].T
    leans = shapes.normals[2, :, 2] - shapes.normals[0, :, 2]
    np.testing.assert_allclose(leans, -0.2 * x * (1.0 - z**2), atol=0.01)  # s squared
    sphere.cycles.use_deform_motion = False
    assert exported_in_motion()[0].motion is None

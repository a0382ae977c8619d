"""core/geometry/shading.py: what is known of a point that a ray hit."""

import numpy as np
import pytest

from iwis.core.embree.accel import Accel
from iwis.core.geometry.shading import params_at, shading_points
from support.scenes import diffuse, floor, glossy, make_materials, make_mesh, sphere


def _points(mesh, origins, targets):
    directions = targets - origins
    directions = (directions / np.linalg.norm(directions, axis=-1, keepdims=True)).astype(
        np.float32
    )
    hit, u, v = Accel(mesh).intersect(origins.astype(np.float32), directions)
    return shading_points(mesh, hit, u, v, directions), directions


def _round_sphere(rng, n=300, smooth=True):
    """Rays from outside to points inside a ball of radius 1, some of which miss."""
    origins = rng.standard_normal((n, 3))
    origins *= 4.0 / np.linalg.norm(origins, axis=-1, keepdims=True)
    targets = rng.uniform(-0.8, 0.8, (n, 3))
    mesh = make_mesh(sphere(rings=32, smooth=smooth))
    points, directions = _points(mesh, origins, targets)
    return mesh, points, origins[points.pixel], directions[points.pixel]


def test_points_are_those_of_the_rays_that_hit(rng):
    """In the order of the rays, on their triangle's plane and on the ray."""
    mesh, points, origins, directions = _round_sphere(rng)
    assert (np.diff(points.pixel) > 0).all() and len(points.pixel) > 200
    corner = mesh.vertices[mesh.triangles[points.triangle, 0]]
    height = ((points.position - corner) * points.geometric_normal).sum(-1)
    np.testing.assert_allclose(height, 0.0, atol=1e-6)  # float32, coordinates to 1
    off = np.cross(points.position - origins, directions)
    np.testing.assert_allclose(off, 0.0, atol=5e-6)  # float32, 4 m from the origin


def test_normals_are_unit_and_face_the_camera(rng):
    """wo is the ray turned round; geometric normals look to its side, shading normals are unit."""
    _, points, _, directions = _round_sphere(rng)
    np.testing.assert_array_equal(points.wo, -directions)
    assert ((points.geometric_normal * points.wo).sum(-1) > 0.0).all()
    for normal in (points.geometric_normal, points.normal):
        np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=3e-7)  # float32


def test_smooth_normals_are_interpolated(rng):
    """A smooth ball's shading normal points away from its centre; a flat one's is the face's."""
    _, points, _, _ = _round_sphere(rng)
    outward = points.position / np.linalg.norm(points.position, axis=-1, keepdims=True)
    # 5.6 degrees a face: interpolation is good to the square of half of it over 2.
    np.testing.assert_allclose(points.normal, outward, atol=3e-3)
    _, flat, _, _ = _round_sphere(rng, smooth=False)
    np.testing.assert_allclose(
        flat.normal, flat.geometric_normal, atol=1e-5
    )  # slivers at the poles


def test_back_faces_are_seen_with_both_normals_turned():
    """From below, a floor that looks up has normals that look down."""
    mesh = make_mesh(floor())
    points, _ = _points(mesh, np.array([[0.1, 0.2, -3.0]]), np.array([[0.3, 0.1, 0.0]]))
    for normal in (points.geometric_normal, points.normal):
        np.testing.assert_allclose(normal, [[0, 0, -1]], atol=2e-7)  # float32


@pytest.mark.parametrize("normals", [0.0, np.nan])
def test_missing_corner_normals_fall_back_to_the_face(normals):
    """Corner normals that cancel, or are NaN, give the geometric one, not a NaN."""
    vertices, triangles, corner_normals = floor()
    mesh = make_mesh((vertices, triangles, np.full_like(corner_normals, normals)))
    points, _ = _points(mesh, np.array([[0.1, 0.2, 3.0]]), np.array([[0.3, 0.1, 0.0]]))
    np.testing.assert_allclose(points.normal, [[0, 0, 1]], atol=2e-7)  # float32


def test_params_are_taken_row_by_row():
    """Each point has its material's row, C-contiguous as kernels want it."""
    materials = make_materials(diffuse((0.1, 0.2, 0.3)), glossy(0.25, (0.7, 0.8, 0.9)))
    params = params_at(materials, np.int32([1, 0, 1]))
    np.testing.assert_array_equal(params.base_color[:, 0], np.float32([0.7, 0.1, 0.7]))
    np.testing.assert_array_equal(params.roughness, np.float32([0.5, 0.5, 0.5]))
    assert all(column.flags.c_contiguous for column in params)


def test_what_is_behind_a_smooth_face_is_lit_from_its_own_side_alone():
    """Those of a mask have their normals turned and no patch over them: rays that start on one
    bring light from below the face. The others stay as they are."""
    mesh = make_mesh(sphere(rings=12, smooth=True))
    hit = np.arange(60, 68, dtype=np.int32)
    third, down = np.full(8, 1.0 / 3.0, np.float32), np.tile(np.float32([0, 0, -1]), (8, 1))
    points = shading_points(mesh, hit, third, third, down, np.float32([0.1]))
    assert (points.lift_below > 0.0).all()
    which = np.arange(8) % 2 == 0
    turned = points.from_behind(which)
    side = np.where(which, -1.0, 1.0)[:, None]
    np.testing.assert_array_equal(turned.normal, points.normal * side)
    np.testing.assert_array_equal(turned.geometric_normal, points.geometric_normal * side)
    np.testing.assert_array_equal(turned.lift_below, np.where(which, 0.0, points.lift_below))
    assert not turned.lift[which].any() and (turned.lift[~which] == points.lift[~which]).all()

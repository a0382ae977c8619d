"""element_places.py: where points are on triangles, and in the space of their objects."""

import numpy as np
import pytest

from iwis.core.geometry import element_places

N = 200


@pytest.fixture
def triangles(rng):
    """(vertices, triangles, triangle of each point, weights of its second and third corner,
    position)"""
    vertices = rng.uniform(-5.0, 5.0, (60, 3)).astype(np.float32)
    corners = rng.permutation(60).reshape(20, 3).astype(np.int32)
    which = rng.integers(0, 20, N).astype(np.int32)
    u = rng.uniform(0.0, 1.0, (N, 2))
    u = np.where(u.sum(1, keepdims=True) > 1.0, 1.0 - u, u).astype(np.float32)
    a, b, c = np.moveaxis(vertices[corners[which]].astype(np.float64), 1, 0)
    position = (a + u[:, :1] * (b - a) + u[:, 1:] * (c - a)).astype(np.float32)
    return vertices, corners, which, u, position


@pytest.fixture
def matrices(rng):
    """float64 (4, 4, 4): turned, stretched, mirrored, moved."""
    found = np.tile(np.eye(4), (4, 1, 1))
    found[:, :3] += rng.uniform(-0.6, 0.6, (4, 3, 4))
    found[1, :3, 0] *= -1.0
    return found


def test_weights_are_found_again(triangles):
    vertices, corners, which, weights, position = triangles
    found = np.empty((N, 2), np.float32)
    element_places.barycentric_at(vertices, corners, which, position, found)
    np.testing.assert_allclose(found, weights, atol=2e-5)  # thin triangles of float32 places


def test_a_triangle_without_an_area_has_its_first_corner(triangles):
    vertices, corners, which, _, position = triangles
    corners[:] = corners[:, :1]
    found = np.full((N, 2), np.nan, np.float32)
    element_places.barycentric_at(vertices, corners, which, position, found)
    np.testing.assert_array_equal(found, 0.0)


def test_steps_in_the_plane_move_weights(triangles, rng):
    vertices, corners, which, weights, _ = triangles
    a, b, c = np.moveaxis(vertices[corners[which]].astype(np.float64), 1, 0)
    by = rng.uniform(-0.3, 0.3, (N, 2))
    offset = (by[:, :1] * (b - a) + by[:, 1:] * (c - a)).astype(np.float32)
    moved = weights.copy()
    element_places.move_barycentric(vertices, corners, which, offset, moved)
    np.testing.assert_allclose(moved - weights, by, atol=2e-5)


@pytest.mark.parametrize("width", [1, 2, 4])
def test_values_of_corners_are_interpolated(width, triangles, rng):
    _, corners, which, weights, _ = triangles
    table = rng.uniform(-1.0, 1.0, (7, 3, width)).astype(np.float32)
    row = rng.integers(-1, 7, len(corners)).astype(np.int32)
    flipped = rng.random(N) < 0.5
    found = np.empty((N, width), np.float32)
    element_places.interpolate(table, row, which, flipped, weights, found)
    u, v = weights.T[..., None]
    u, v = np.where(flipped[:, None], v, u), np.where(flipped[:, None], u, v)
    a, b, c = np.moveaxis(table[row[which]], 1, 0)
    expected = np.where(row[which, None] < 0, 0.0, (1.0 - u - v) * a + u * b + v * c)
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_only_the_matrices_that_are_asked_for_are_inverted(matrices):
    which, done = np.int32([2, 0, 2, 0]), np.zeros(4, np.bool_)
    found = np.full_like(matrices, 7.0)
    element_places.invert(matrices, which, done, found)
    np.testing.assert_allclose(found[[0, 2]], np.linalg.inv(matrices[[0, 2]]), atol=1e-12)
    np.testing.assert_array_equal(found[[1, 3]], 7.0)
    np.testing.assert_array_equal(done, [True, False, True, False])


def test_a_matrix_without_an_inverse_changes_nothing():
    flat = np.diag([1.0, 1.0, 0.0, 1.0])[None]
    flat[0, :3, 3] = 5.0
    found = np.empty_like(flat)
    element_places.invert(flat, np.int32([0]), np.zeros(1, np.bool_), found)
    np.testing.assert_array_equal(found[0], np.eye(4))


@pytest.mark.parametrize("unit", [False, True])
@pytest.mark.parametrize("transposed", [False, True])
def test_vectors_are_turned(transposed, unit, matrices, rng):
    which = rng.integers(0, 4, N).astype(np.int32)
    vectors = rng.standard_normal((N, 3)).astype(np.float32)
    vectors[0] = 0.0
    found = np.empty_like(vectors)
    element_places.turn(matrices, which, vectors, transposed, unit, found)
    turns = matrices[which, :3, :3]
    turns = np.swapaxes(turns, 1, 2) if transposed else turns
    expected = np.einsum("nij,nj->ni", turns, vectors)
    if unit:
        expected[1:] /= np.linalg.norm(expected[1:], axis=1, keepdims=True)
    np.testing.assert_allclose(found, expected, atol=2e-6)


def test_places_are_moved_too(matrices, rng):
    which = rng.integers(0, 4, N).astype(np.int32)
    places = rng.standard_normal((N, 3)).astype(np.float32)
    found = np.empty_like(places)
    element_places.place(matrices, which, places, found)
    expected = np.einsum("nij,nj->ni", matrices[which, :3, :3], places) + matrices[which, :3, 3]
    np.testing.assert_allclose(found, expected, atol=2e-6)


def test_normals_of_corners_are_turned_before_they_are_interpolated(triangles, matrices, rng):
    _, corners, which, weights, _ = triangles
    normals = rng.standard_normal((len(corners), 3, 3)).astype(np.float32)
    objects = rng.integers(0, 4, N).astype(np.int32)
    found = np.empty((N, 3), np.float32)
    element_places.corner_normals_at(normals, which, weights, matrices, objects, found)
    turned = np.einsum("nji,ncj->nci", matrices[objects, :3, :3], normals[which])
    turned /= np.linalg.norm(turned, axis=2, keepdims=True)
    share = np.column_stack([1.0 - weights.sum(1), weights])
    np.testing.assert_allclose(found, np.einsum("nc,nci->ni", share, turned), atol=2e-6)

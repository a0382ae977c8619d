"""core/embree/accel.py: Embree finds what a loop over all triangles finds."""

import threading

import numpy as np
import pytest

from iwis.core.embree.accel import MISS, Accel, ray_offset
from support.naive import hits_triangles
from support.scenes import box, floor, make_mesh, quad, sphere


def _soup(rng, n=200):
    """Triangles of all sizes and directions round the origin."""
    corners = rng.standard_normal((n, 1, 3)) + rng.random((n, 1, 1)) * rng.standard_normal(
        (n, 3, 3)
    )
    part = corners.reshape(-1, 3), np.arange(3 * n).reshape(n, 3), np.ones((n, 3, 3))
    return make_mesh(part)


def _rays(rng, n=500):
    origins = 3.0 * rng.standard_normal((n, 3))
    directions = rng.standard_normal((n, 3)) - origins
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return origins.astype(np.float32), directions.astype(np.float32)


def test_nearest_hits_equal_the_naive_ones(rng):
    """Triangle and weights; a ray that passes an edge within rounding may fall on either side."""
    mesh = _soup(rng)
    origins, directions = _rays(rng)
    triangle, u, v = Accel(mesh).intersect(origins, directions)
    distance, expected = hits_triangles(
        mesh, origins.astype(np.float64), directions.astype(np.float64)
    )
    same = triangle == expected
    assert same.mean() >= 0.998 and (triangle >= 0).mean() > 0.2
    hit = same & (triangle >= 0)
    corners = mesh.vertices[mesh.triangles[triangle[hit]]].astype(np.float64)
    weights = np.stack([1.0 - u - v, u, v], -1)[hit]
    points = np.einsum("nc,nca->na", weights, corners)
    along = origins + distance[:, None] * directions
    np.testing.assert_allclose(points, along[hit], atol=2e-4)  # float32, slivers of large triangles


def _camera_rays(side=90):
    """Those of a camera over the origin, row by row."""
    x, y = np.meshgrid(*[np.linspace(-0.4, 0.4, side)] * 2)
    directions = np.stack([x, y, np.full_like(x, -1.0)], -1).reshape(-1, 3).astype(np.float32)
    return np.tile(np.float32([0.1, -0.2, 4.0]), (side * side, 1)), directions


@pytest.mark.parametrize(
    "mesh", [make_mesh(sphere(rings=40)), make_mesh(sphere(rings=40), floor())]
)
def test_nearest_hits_do_not_depend_on_the_rays_beside(rng, mesh):
    """To the bit, whichever eight go together; alone a ray meets the same, u and v are rounded."""
    accel, (origins, directions) = Accel(mesh), _camera_rays()
    found = accel.intersect(origins, directions)
    assert 0.1 < (found[0] >= 0).mean() and len(np.unique(found[0])) > 100
    order = rng.permutation(len(origins))
    for a, b in zip(accel.intersect(origins[order], directions[order]), found, strict=True):
        np.testing.assert_array_equal(a, b[order])
    for a, b in zip(accel.intersect(origins[3:], directions[3:]), found, strict=True):
        np.testing.assert_array_equal(a, b[3:])
    accel.traversal = accel.traversal._replace(intersect8=0)
    triangle, *weights = accel.intersect(origins, directions)
    np.testing.assert_array_equal(triangle, found[0])
    np.testing.assert_allclose(weights, found[1:], atol=1e-4)  # triangles seen edge-on: 2e-5


def test_occlusion_equals_the_naive_one(rng):
    """A ray is occluded where anything is hit."""
    mesh = _soup(rng)
    origins, directions = _rays(rng)
    _, hit = hits_triangles(mesh, origins.astype(np.float64), directions.astype(np.float64))
    assert (Accel(mesh).occluded(origins, directions) == (hit >= 0)).mean() >= 0.998


def test_an_empty_mesh_is_never_hit(rng):
    """No triangle, no error."""
    accel = Accel(make_mesh())
    origins, directions = _rays(rng, 5)
    assert (accel.intersect(origins, directions)[0] == MISS).all()
    assert not accel.occluded(origins, directions).any()


def test_no_rays_are_no_error():
    """A tile that sees nothing asks for nothing."""
    accel = Accel(make_mesh(floor()))
    none = np.zeros((0, 3), np.float32)
    assert len(accel.occluded(none, none)) == len(accel.intersect(none, none)[0]) == 0


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 1e6])
def test_offset_clears_the_surface_and_not_more(size, rng):
    """Rays that leave a box's faces from the offset are free, and those that start as far inside
    are blocked, for boxes far from the origin too; the offset is under 1e-5 of the largest
    coordinate.
    """
    mesh = make_mesh(box((size / 2,) * 3, (size,) * 3))
    accel = Accel(mesh)
    assert accel.offset <= 1e-5 * size or size < 1e-2
    n = 2000
    pick = rng.integers(len(mesh.triangles), size=n)
    weights = rng.dirichlet((1.0, 1.0, 1.0), n).astype(np.float32)
    positions = np.einsum("nc,nca->na", weights, mesh.vertices[mesh.triangles[pick]])
    normals = mesh.corner_normals[pick, 0]
    directions = rng.standard_normal((n, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    directions *= np.sign((directions * normals).sum(-1, keepdims=True))
    offset = np.float32(accel.offset)
    assert not accel.occluded(positions + offset * normals, directions).any()
    assert accel.occluded(positions - offset * normals, directions).all()


def test_offset_of_nothing_is_zero():
    """No vertices, and all vertices at the origin."""
    assert ray_offset(np.zeros((0, 3), np.float32)) == 0.0
    assert ray_offset(np.zeros((3, 3), np.float32)) > 0.0


def test_degenerate_triangles_are_never_hit(rng):
    """Zero area, repeated corners, NaN and infinite corners: the rest is hit as before."""
    good = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    bad = np.array(
        [
            [[0, 0, 1]] * 3,
            [[-1, 0, 1], [0, 0, 1], [1, 0, 1]],
            [[np.nan, 0, 1], [1, 0, 1], [0, 1, 1]],
        ]
    )
    part = bad.reshape(-1, 3), np.arange(9).reshape(3, 3), np.ones((3, 3, 3))
    mesh = make_mesh(good, part)
    origins = np.float32(rng.uniform(-0.9, 0.9, (100, 3))) * np.float32([1, 1, 0]) + np.float32(
        [0, 0, 5]
    )
    directions = np.tile(np.float32([0, 0, -1]), (100, 1))
    triangle, _, _ = Accel(mesh).intersect(origins, directions)
    assert set(triangle) <= {0, 1}


def test_threads_get_the_same_answers(rng):
    """The scene is committed before threads ask."""
    mesh = make_mesh(sphere(rings=16))
    origins, directions = _rays(rng, 4000)
    accel = Accel(mesh)
    expected = accel.occluded(origins, directions)
    answers = [None] * 4

    def ask(k):
        answers[k] = accel.occluded(origins, directions)

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for answer in answers:
        np.testing.assert_array_equal(answer, expected)

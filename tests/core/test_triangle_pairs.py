"""core/embree/triangle_pairs.py: triangles two by two are the same triangles."""

import dataclasses

import numpy as np
import pytest

from iwis.core.embree.accel import Accel
from iwis.core.embree.opacity_grids import Opacity
from iwis.core.embree.triangle_pairs import count_as_triangles, paired
from support.scenes import make_mesh, sphere

N = 4000


def _turned(triangles, rng):
    """The same triangles, each from another of its corners on."""
    start = rng.integers(3, size=(len(triangles), 1))
    return np.take_along_axis(triangles, (np.arange(3) + start) % 3, axis=1)


@pytest.fixture
def bumpy(rng):
    """A ball of quads that are not plane, and of single triangles at its poles."""
    vertices, *faces = sphere(rings=24)
    mesh = make_mesh((vertices * rng.uniform(0.9, 1.0, (len(vertices), 1)), *faces))
    return dataclasses.replace(mesh, triangles=_turned(mesh.triangles, rng))


def _rays(rng):
    targets = rng.uniform(-1.1, 1.1, (N, 3))
    origins = (2.0 * rng.standard_normal((N, 3))).astype(np.float32)
    return origins, (targets - origins).astype(np.float32)


def _point(mesh, hit, u, v):
    corners = mesh.vertices[mesh.triangles[hit]].astype(np.float64)
    edges = corners[:, 1:] - corners[:, :1]
    return corners[:, 0] + u[:, None] * edges[:, 0] + v[:, None] * edges[:, 1]


def test_every_triangle_is_in_one_quad(bumpy):
    """With its corners in their order, around the quad's diagonal."""
    pairs = paired(bumpy.triangles)
    a, b, c, d = pairs.corners.T
    alone = pairs.turn == 9
    assert 0 < alone.sum() < 0.1 * len(alone)
    np.testing.assert_array_equal(c[alone], d[alone])
    made = np.full_like(bumpy.triangles, -1)
    made[pairs.first] = np.stack([a, b, d], -1)
    made[pairs.first[~alone] + 1] = np.stack([c, d, b], -1)[~alone]
    turns = [np.roll(made, k, axis=1) for k in range(3)]
    same = [(turn == bumpy.triangles).all(axis=1) for turn in turns]
    assert np.any(same, axis=0).all()
    assert min(one.sum() for one in same) > 0.1 * len(made)  # all turns are tried


def test_hits_are_those_of_triangles(bumpy, rng, monkeypatch):
    """Triangle, place on it and shadow, as without pairs; where rays do not meet an edge."""
    rays = _rays(rng)
    accel = Accel(bumpy)
    assert accel.pairs is not None
    found, blocked = accel.intersect(*rays), accel.occluded(*rays)
    monkeypatch.setattr("iwis.core.embree.accel.paired", lambda _: None)
    alone = Accel(bumpy)
    assert alone.pairs is None
    expected = alone.intersect(*rays)
    same = found[0] == expected[0]
    assert same.mean() > 0.999
    assert 0.3 < (expected[0] >= 0).mean() < 0.9
    np.testing.assert_allclose(found[1][same], expected[1][same], atol=2e-4)
    np.testing.assert_allclose(found[2][same], expected[2][same], atol=2e-4)
    np.testing.assert_array_equal(blocked, alone.occluded(*rays))
    hit = found[0] >= 0
    place = _point(bumpy, *(array[hit] for array in found))
    ways = rays[1][hit] / np.linalg.norm(rays[1][hit], axis=1, keepdims=True)
    off = np.linalg.norm(np.cross(place - rays[0][hit], ways), axis=1)
    assert off.max() < 1e-5  # some roundings of float32


def test_both_triangles_of_a_quad_are_hit(bumpy, rng):
    """Each triangle is found by a ray at its middle, at equal weights."""
    middle = bumpy.vertices[bumpy.triangles].mean(axis=1)
    origins = (middle * 1.5).astype(np.float32)
    hit, u, v = Accel(bumpy).intersect(origins, (middle - origins).astype(np.float32))
    seen = hit == np.arange(len(hit))
    assert seen.mean() > 0.95  # a dent may lie behind its neighbours
    np.testing.assert_allclose(u[seen], 1.0 / 3.0, atol=1e-3)
    np.testing.assert_allclose(v[seen], 1.0 / 3.0, atol=1e-3)


def test_an_edge_of_a_single_triangle_is_its_own():
    """Rounded beyond its third edge, a hit is none of the next triangle's."""
    first, turn = np.int32([0, 1]), np.uint8([9, 9])
    hit, u, v = np.int32([0, -1]), np.float32([0.6, 0.0]), np.float32([0.4000001, 0.0])
    count_as_triangles(first, turn, hit, u, v)
    assert list(hit) == [0, -1]


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_triangles_that_share_nothing_stay_alone(n):
    assert paired(np.arange(3 * n, dtype=np.int32).reshape(n, 3)) is None


def test_edges_of_one_side_make_no_pair():
    """Two triangles that lie on each other, or turn other ways round."""
    assert paired(np.int32([[0, 1, 2], [0, 1, 2]])) is None
    assert paired(np.int32([[0, 1, 2], [1, 2, 3]])) is None
    assert paired(np.int32([[0, 1, 2], [2, 1, 3]])) is not None


def test_surfaces_drawn_by_chance_keep_their_triangles(bumpy):
    """Embree's filter is asked for one triangle at a time (embree_filter.py)."""
    none = np.full(len(bumpy.triangles), -1, np.int32)
    grids = np.zeros(0, np.int64), np.zeros(0, np.int32), np.zeros(1, np.uint8)
    grids += np.zeros(0, np.uint8), np.zeros((0, 3, 3), np.float32)
    assert Accel(bumpy, opacity=Opacity(none, *grids)).pairs is None


def test_a_corner_that_is_nowhere_takes_no_whole_quad(bumpy):
    """Embree never hits a face with such a corner: the quad's other triangle is still there."""
    lost = int(bumpy.triangles[100, 0])
    vertices = bumpy.vertices.copy()
    vertices[lost] = np.nan
    middle = bumpy.vertices[bumpy.triangles].mean(axis=1)
    origins = (middle * 1.5).astype(np.float32)
    rays = origins, (middle - origins).astype(np.float32)
    before, _, _ = Accel(bumpy).intersect(*rays)
    after, _, _ = Accel(dataclasses.replace(bumpy, vertices=vertices)).intersect(*rays)
    kept = (bumpy.triangles != lost).all(axis=1)
    own = kept & (before == np.arange(len(before)))  # what is seen of itself, without the others
    np.testing.assert_array_equal(after[own], before[own])

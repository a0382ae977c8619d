"""Spheres of points: closed, of the right size, and finer where they are larger."""

import numpy as np
import pytest

from iwis.iwis_addon.export.meshes.point_spheres import (
    ball,
    count_triangles,
    divisions,
    make_spheres,
)


def corners_of(spheres):
    return spheres.positions[spheres.triangles].astype(np.float64)


@pytest.mark.parametrize("divided", range(5))
def test_ball_is_closed_and_looks_out(divided):
    """Each edge has two triangles, one in each direction; all wind counterclockwise from outside;
    a fourth of the surface, what a convex body covers on the mean, is that of the unit disk."""
    made = ball(divided)
    edges = made.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert len(made.faces) == 20 * 4**divided
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    a, b, c = (made.corners[k].astype(np.float64) * made.scale for k in made.faces.T)
    areas = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", areas, a) > 0.0).all()
    # 1e-6: float32 corners
    np.testing.assert_allclose(np.linalg.norm(areas, axis=1).sum() / 8.0, np.pi, rtol=1e-6)


def test_spheres_stand_at_their_points():
    """Every corner is at the scaled radius around the point that its triangle names, and its normal
    looks away from there."""
    rng = np.random.default_rng(1)
    centers = rng.uniform(-3, 3, (50, 3)).astype(np.float32)
    radii = rng.uniform(0.01, 0.5, 50).astype(np.float32)
    divided = divisions(radii)
    made = make_spheres(centers, radii, divided)
    assert len(made.triangles) == count_triangles(divided)
    assert made.triangles.max() == len(made.positions) - 1
    away = corners_of(made) - centers[made.point][:, None]
    scale = np.array([ball(int(d)).scale for d in divided])[made.point]
    size = np.linalg.norm(away, axis=2)
    # 1e-5: float32 positions, 3 m from the origin, of radii down to .01 m
    np.testing.assert_allclose(size, (radii[made.point] * scale)[:, None] * np.ones(3), atol=1e-5)
    normals = made.normals[made.normal_index]
    np.testing.assert_allclose(away / size[..., None], normals, atol=1e-3)


def test_larger_spheres_are_finer():
    """By their share of the surface; a million of them have the fewest triangles."""
    assert divisions(np.float32([1.0, 1.0])).tolist() == [4, 4]
    mixed = divisions(np.concatenate([np.full(100_000, 0.001), [1.0]]).astype(np.float32))
    assert mixed[-1] == 4 and set(mixed[:-1]) == {0}
    assert count_triangles(divisions(np.ones(1_000_000, np.float32))) == 20_000_000
    assert divisions(np.float32([np.inf, 1.0])).tolist() == [0, 0]

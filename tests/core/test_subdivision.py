"""Catmull-Clark subdivision and the patches of its limit."""

import numpy as np
import pytest

from iwis.core.fine_meshes.bezier_patches import flat_patches, smooth_patches
from iwis.core.fine_meshes.subdivision import FOR_EVER, make_control, refined, with_sharp_corners
from support.control_meshes import cube, grid, quads_of

_WEIGHTS = np.array([1.0, 4.0, 1.0]) / 6.0


def _at(patches, u, v):
    """(f, d): places on all patches."""

    def bernstein(t):
        return np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3])

    return np.einsum("j,i,fjid->fd", bernstein(v), bernstein(u), patches)


def test_a_step_has_a_quad_for_each_corner():
    """Of a triangle and a quad that share an edge; linear steps move nothing."""
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [4, 1, 0]], np.float64)
    corners = np.array([0, 1, 2, 3, 1, 4, 2], np.int32)
    control = make_control(points, corners, np.array([0, 4, 7], np.int32))
    assert len(control.ends) == 6 and np.isfinite(control.sharp).sum() == 1
    made = refined(control, linear=True)
    assert len(made.corners) == 4 * 7 and np.array_equal(made.points[:5], points)
    center = made.points[quads_of(made)[4:]][:, 2]
    np.testing.assert_allclose(center, [[8 / 3, 1, 0]] * 3)
    edges = np.sort(made.ends[made.edge_of], axis=1)
    around = np.stack([made.corners.reshape(-1, 4), np.roll(made.corners.reshape(-1, 4), -1, 1)])
    np.testing.assert_array_equal(edges, np.sort(around.reshape(2, -1).T, axis=1))


def test_regular_patches_are_b_splines():
    """Their corners are what the masks 1, 4, 1 give, and a step more changes no place."""
    control = grid(6, lambda x, y: np.sin(1.3 * x) * np.cos(0.7 * y))
    patches = smooth_patches(control)
    points = control.points.reshape(7, 7, 3)
    limit = np.einsum("j,i,jid->d", _WEIGHTS, _WEIGHTS, points[2:5, 2:5])
    middle = 3 * 6 + 3  # its corner 0 is point (3, 3)
    np.testing.assert_allclose(patches[middle][0, 0], limit, atol=1e-6)
    finer = smooth_patches(refined(control)).reshape(36, 4, 4, 4, 3)
    for corner, (u, v) in enumerate(((0.15, 0.2), (0.8, 0.2), (0.8, 0.85), (0.15, 0.85))):
        # In the part at a corner u leads to the next corner, v to the one before.
        along, across = (u if u < 0.5 else 1 - u) * 2, (v if v < 0.5 else 1 - v) * 2
        own = (along, across) if corner % 2 == 0 else (across, along)
        np.testing.assert_allclose(
            _at(finer[:, corner], *own)[middle], _at(patches, u, v)[middle], atol=1e-6
        )


def test_other_points_have_their_limit():
    """Of a cube's corners: (n v + 4 mean of edges + mean of opposites) / (n + 5), n = 3, [Loop08];
    more steps lead there."""
    control = cube()
    corner = smooth_patches(control)[0, 0, 0]
    np.testing.assert_allclose(np.abs(corner), 0.5, atol=1e-6)  # (3 + 4/3 - 1/3) / 8
    finer = control
    for _ in range(6):
        finer = refined(finer)
    np.testing.assert_allclose(np.abs(finer.points[control.corners[0]]), np.abs(corner), atol=2e-3)


def test_patches_meet_in_their_edges():
    """Whatever meets there: the control points of shared edges are the same numbers."""
    control = refined(cube())
    patches, quads = smooth_patches(control), quads_of(control)
    sides = [patches[:, 0], patches[:, :, 3], patches[:, 3, ::-1], patches[:, ::-1, 0]]
    known = {}
    for k, side in enumerate(sides):
        for face, points in enumerate(side):
            ends = quads[face, k], quads[face, (k + 1) % 4]
            own = points if ends[0] < ends[1] else points[::-1]
            np.testing.assert_array_equal(known.setdefault(tuple(sorted(ends)), own), own)
    assert len(known) == len(control.ends)


@pytest.mark.parametrize("sharpness", [0.0, 0.4, 1.0, 2.5, FOR_EVER])
def test_creases_fade(sharpness):
    """Edge points of a fold: in its middle the sharper, the nearer; sharp ones lose 1 a step."""
    control = grid(2, lambda x, y: np.abs(x))
    fold = np.abs(control.points[control.ends][..., 0]).max(axis=1) == 0.0
    control = control._replace(
        sharp=np.where(fold & np.isfinite(control.sharp), sharpness, control.sharp).astype(
            np.float32
        )
    )
    made = refined(control)
    row = len(control.points) + np.flatnonzero(fold)[0]
    share = 1.0 - min(sharpness, 1.0)
    np.testing.assert_allclose(made.points[row, 2], share * 0.5)  # faces beside it: 1
    halves = made.sharp[: 2 * len(fold)][np.repeat(fold, 2)]
    np.testing.assert_array_equal(halves, max(sharpness - 1.0, 0.0))


def test_boundaries_and_corners():
    """A square's boundary is a curve of its own; corners stay only where they are told to."""
    control = grid(1, lambda x, y: 0 * x)
    rounded = smooth_patches(control)[0]
    np.testing.assert_allclose(rounded[0, 0, :2], [-2 / 3, -2 / 3], atol=1e-6)
    kept = smooth_patches(with_sharp_corners(control))[0]
    np.testing.assert_allclose(kept, flat_patches(control.points[quads_of(control)])[0], atol=1e-6)

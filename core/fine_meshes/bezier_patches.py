"""Bicubic Bezier patches of a control mesh of quads.

Of regular quads they are the Catmull-Clark limit surface, around other points they are near it and
meet in its points [Loop08].
"""

from __future__ import annotations

import numpy as np

from .subdivision import Control, kinds_of, sharp_neighbours, sums

# What is left of a crease after some steps counts as sharp from here on.
_SHARP = 0.5


def smooth_patches(control: Control) -> np.ndarray:
    """float32 (f, 4, 4, d): [v][u], corner 0 at (0, 0), corner 1 at u = 1, corner 3 at v = 1.

    control: of quads alone, of points that are no two dimensions alone (d is free)
    """
    sharp = np.where(control.sharp > _SHARP, np.float32(1.0), np.float32(0.0))
    count, others = sharp_neighbours(control, sharp)
    kind = kinds_of(count, np.where(control.sharp_points > _SHARP, 1.0, 0.0))
    inner = _inner_points(control, kind)
    limits = _limit_points(control, kind, others, inner)
    after, before = _edge_points(control, sharp, inner)
    quads = control.corners.reshape(-1, 4)
    points = np.empty((len(quads), 4, 4, control.points.shape[1]), np.float32)
    places = ((0, 0), (0, 3), (3, 3), (3, 0))  # of corners
    for k, (row, column) in enumerate(places):
        down, right = (1 if row == 0 else -1), (1 if column == 0 else -1)
        points[:, row, column] = limits[quads[:, k]]
        points[:, row + down, column + right] = inner[:, k]
        along_u, along_v = (after, before) if k % 2 == 0 else (before, after)
        points[:, row, column + right] = along_u[:, k]
        points[:, row + down, column] = along_v[:, k]
    return points


def flat_patches(corners: np.ndarray) -> np.ndarray:
    """float32 (f, 4, 4, d), as of smooth_patches, of float (f, 4, d): bilinear between corners."""
    steps = np.arange(4) / 3.0
    u, v = np.meshgrid(steps, steps)
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], -1)
    return np.einsum("jik,fkd->fjid", weights, corners).astype(np.float32)


def _inner_points(control: Control, kind) -> np.ndarray:
    """float64 (f, 4, d), of each corner of a quad."""
    quads = control.corners.reshape(-1, 4)
    valence = np.bincount(control.corners, minlength=len(control.points))
    # On a crease as in the middle of a regular mesh, which is exact for one face or two beside it.
    n = np.where(kind[:, 0] == 0, valence, 4).astype(np.float64)[quads][..., None]
    own, next_, opposite, last = (control.points[np.roll(quads, -k, axis=1)] for k in range(4))
    return (n * own + 2.0 * (next_ + last) + opposite) / (n + 5.0)


def _limit_points(control: Control, kind, others, inner) -> np.ndarray:
    """float64 (n, d): where the points go in the limit."""
    n, own = len(control.points), control.points
    valence = np.maximum(np.bincount(control.corners, minlength=n), 1)[:, None]
    smooth = sums(control.corners, inner.reshape(-1, inner.shape[-1]), n) / valence
    return np.where(kind == 0, smooth, np.where(kind == 1, (4.0 * own + others) / 6.0, own))


def _edge_points(control: Control, sharp, inner) -> tuple[np.ndarray, np.ndarray]:
    """float64 (f, 4, d) each: beside each corner, on the edge to the next one and to the last."""
    quads, edges = (a.reshape(-1, 4) for a in (control.corners, control.edge_of))
    last = np.roll(edges, 1, axis=1)
    flat = inner.reshape(-1, inner.shape[-1])
    ends = [2 * e + (control.ends[e, 1] == quads) for e in (edges, last)]
    rows = np.concatenate([end.ravel() for end in ends])
    count = 2 * len(control.ends)
    total = sums(rows, np.concatenate([flat, flat]), count)
    total /= np.maximum(np.bincount(rows, minlength=count), 1)[:, None]
    first, other = (
        control.points[control.ends.ravel()],
        control.points[control.ends[:, ::-1].ravel()],
    )
    total = np.where(np.repeat(sharp > 0.0, 2)[:, None], (2.0 * first + other) / 3.0, total)
    return total[ends[0]], total[ends[1]]

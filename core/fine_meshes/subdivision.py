"""Catmull-Clark subdivision of a control mesh [Catmull78], with sharp edges as OpenSubdiv's.

A face with n corners becomes n quads, corner by corner: (corner, edge, face, edge before). Edges of
sharpness s are sharp for s steps, and of a fraction blend; boundaries, and edges with more than two
faces, are sharp for ever. Linear subdivision has the same quads, and moves nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

FOR_EVER = np.float32(np.inf)


class Control(NamedTuple):
    """A mesh of faces of any number of corners, in the order of its faces.

    points: float64 (n, d); corners: int32 (c,), the point of each corner
    starts: int32 (f + 1,), the first corner of each face, and c
    edge_of: int32 (c,), the edge from a corner to the next one of its face
    ends: int32 (e, 2), points of edges; sharp: float32 (e,), of edges; sharp_points: float32 (n,)
    """

    points: np.ndarray
    corners: np.ndarray
    starts: np.ndarray
    edge_of: np.ndarray
    ends: np.ndarray
    sharp: np.ndarray
    sharp_points: np.ndarray

    @property
    def face_of(self) -> np.ndarray:
        """int32 (c,): the face of each corner."""
        return np.repeat(np.arange(len(self.starts) - 1, dtype=np.int32), np.diff(self.starts))


def around(starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """int32 (c,) each: the corner after, and the corner before each one in its face."""
    after = np.arange(1, starts[-1] + 1, dtype=np.int32)
    before = np.arange(-1, starts[-1] - 1, dtype=np.int32)
    after[starts[1:] - 1], before[starts[:-1]] = starts[:-1], starts[1:] - 1
    return after, before


def make_control(points, corners, starts, creases=None, sharp_points=None) -> Control:
    """Find the edges of faces that all have a corner at least.

    creases: (int32 (k, 2), float32 (k,)), points of edges and how sharp they are; None: none is
    sharp_points: float32 (n,); None: none is
    """
    points = np.asarray(points, np.float64)
    n = np.int64(max(len(points), 1))
    after, _ = around(starts)
    pairs = np.sort(np.stack([corners, corners[after]], -1).astype(np.int64), axis=1)
    keys, edge_of = np.unique(pairs @ [n, 1], return_inverse=True)
    edge_of = edge_of.reshape(-1).astype(np.int32)
    sharp = np.zeros(len(keys), np.float32)
    if creases is not None and len(keys):
        wanted = np.sort(creases[0].astype(np.int64), axis=1) @ [n, 1]
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        known = keys[place] == wanted
        sharp[place[known]] = creases[1][known]
    sharp[np.bincount(edge_of, minlength=len(keys)) != 2] = FOR_EVER
    if sharp_points is None:
        sharp_points = np.zeros(len(points), np.float32)
    ends = np.stack([keys // n, keys % n], -1).astype(np.int32)
    return Control(points, corners, starts, edge_of, ends, sharp, sharp_points)


def with_sharp_corners(control: Control) -> Control:
    """The same with points of one face alone sharp for ever."""
    alone = np.bincount(control.corners, minlength=len(control.points)) == 1
    return control._replace(sharp_points=np.where(alone, FOR_EVER, control.sharp_points))


def refined(control: Control, linear: bool = False) -> Control:
    """One step. Points come in the order: of points, of edges, of faces."""
    faces, edges, n = len(control.starts) - 1, len(control.ends), len(control.points)
    middles = control.points[control.ends].mean(axis=1)
    centers = mean_of_faces(control.points[control.corners], control.starts)
    moved, on_edges = control.points, middles
    if not linear:
        on_edges = _edge_points(control, middles, centers)
        moved = _moved_points(control, middles, centers)
    _, before = around(control.starts)
    own, edge = control.corners, control.edge_of
    quads = np.stack([own, n + edge, n + edges + control.face_of, n + edge[before]], -1)
    halves = [2 * e + (control.ends[e, 1] == own) for e in (edge, edge[before])]
    inner = 2 * edges + np.arange(len(own))
    edge_of = np.stack([halves[0], inner, inner[before], halves[1]], -1)
    ends = np.empty((2 * edges + len(own), 2), np.int32)
    ends[: 2 * edges, 0], ends[: 2 * edges, 1] = (
        control.ends.ravel(),
        np.repeat(np.arange(n, n + edges), 2),
    )
    ends[2 * edges :] = np.stack([n + edge, n + edges + control.face_of], -1)
    sharp = np.zeros(len(ends), np.float32)
    sharp[: 2 * edges] = np.repeat(_less(control.sharp), 2)
    sharp_points = np.zeros(n + edges + faces, np.float32)
    sharp_points[:n] = _less(control.sharp_points)
    return Control(
        np.concatenate([moved, on_edges, centers]),
        quads.astype(np.int32).ravel(),
        np.arange(0, 4 * len(own) + 1, 4, dtype=np.int32),
        edge_of.astype(np.int32).ravel(),
        ends,
        sharp,
        sharp_points,
    )


def mean_of_faces(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """(f, ...): the means of values of corners, (c, ...)."""
    if len(starts) == 1:
        return values[:0]
    count = np.diff(starts).reshape(-1, *[1] * (values.ndim - 1))
    return np.add.reduceat(values, starts[:-1], axis=0) / count


def sums(rows: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """float64 (count, d): of values, (k, d), of each row."""
    return np.stack([np.bincount(rows, column, count) for column in values.T], -1)


def _less(sharp):
    return np.maximum(sharp - np.float32(1.0), np.float32(0.0))


def _edge_points(control: Control, middles, centers) -> np.ndarray:
    face_sums = sums(control.edge_of, centers[control.face_of], len(middles))
    smooth = (2.0 * middles + face_sums) / 4.0  # of two faces: others are sharp for ever
    share = np.minimum(control.sharp, 1.0)[:, None].astype(np.float64)
    return share * middles + (1.0 - share) * smooth


def _moved_points(control: Control, middles, centers) -> np.ndarray:
    now = _ruled(control, control.sharp, control.sharp_points, middles, centers)
    later = [_less(s) for s in (control.sharp, control.sharp_points)]
    fading = [(s > 0.0) & (s < 1.0) for s in (control.sharp, control.sharp_points)]
    if not any(fade.any() for fade in fading):
        return now
    n, (edges, points) = len(control.points), fading
    total, count = np.where(points, control.sharp_points, 0.0), points.astype(np.float64)
    for end in control.ends[edges].T:
        total = total + np.bincount(end, control.sharp[edges], n)
        count = count + np.bincount(end, minlength=n)
    share = np.where(count > 0.0, total / np.maximum(count, 1.0), 1.0)[:, None]
    return share * now + (1.0 - share) * _ruled(control, *later, middles, centers)


def _ruled(control: Control, sharp, sharp_points, middles, centers) -> np.ndarray:
    """Where the points go by one rule each: smooth, along a crease, or not at all."""
    n, points = len(control.points), control.points
    valence = np.maximum(np.bincount(control.corners, minlength=n), 1)[:, None]
    near = sums(control.corners, centers[control.face_of], n) / valence
    ends, both = control.ends, np.repeat(middles, 2, axis=0)
    along = sums(ends.ravel(), both, n)
    along /= np.maximum(np.bincount(ends.ravel(), minlength=n), 1)[:, None]
    smooth = (near + 2.0 * along + (valence - 3.0) * points) / valence
    count, others = sharp_neighbours(control, sharp)
    crease = (6.0 * points + others) / 8.0
    kind = kinds_of(count, sharp_points)
    return np.where(kind == 0, smooth, np.where(kind == 1, crease, points))


def sharp_neighbours(control: Control, sharp) -> tuple[np.ndarray, np.ndarray]:
    """int64 (n,): how many sharp edges a point has; float64 (n, d): the sum of their other ends."""
    ends = control.ends[sharp > 0.0]
    own, other = ends.ravel(), ends[:, ::-1].ravel()
    n = len(control.points)
    return np.bincount(own, minlength=n), sums(own, control.points[other], n)


def kinds_of(count, sharp_points) -> np.ndarray:
    """int64 (n, 1): 0: smooth, also at the end of a crease; 1: on a crease; 2: a corner."""
    kind = np.where(count < 2, 0, np.where(count == 2, 1, 2))
    return np.where(sharp_points > 0.0, 2, kind)[:, None]

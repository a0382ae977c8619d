"""Strands as tubes of triangles, in bulk. Needs no Blender.

As in Cycles a strand goes through its keys as a Catmull-Rom spline, its radius too. It becomes
rings of corners, a few between two keys where it bends, and a band of triangles from ring to ring,
open at both ends. Where it goes straight from key to key each piece is a tube of its own, as wide
all along, which meets the next one in the plane between them. A tube of few sides lies a little
outside, so that from a mean direction it is as wide as the round one; its normals are those of the
round one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Triangles of all tubes of an object together, as far as that is possible: with pieces between keys
# only where there is room for that with eight sides, straight from key to key with four.
_WANTED = 1 << 21
_SIDES = (32, 24, 16, 12, 8, 6, 4)
_SIDES_OF_PIECES = 8
# Strands with kinks are up to a fifth darker than bent ones. So there may be this many triangles
# for a few pieces, if need be of fewer sides; of four they are a tenth too bright.
_MOST, _ENOUGH_PIECES, _LEAST_SIDES = 1 << 23, 5, 6
# A chord may leave the spline by this part of the radius, but for the worst of 20.
_STRAY, _SHARE = 0.02, 95.0
_MOST_PIECES = 16
_MOST_MITRE = 1.0  # radii by which a piece is longer where it meets another: at right angles
_GOLDEN = 0.618034


class Strands(NamedTuple):
    """keys: float32 (n, 4), places and radii; first: int64 (c + 1,), where each begins and ends"""

    keys: np.ndarray
    first: np.ndarray

    @property
    def segments(self) -> int:
        return int(np.maximum(np.diff(self.first) - 1, 0).sum())


class Shape(NamedTuple):
    """sides: of each tube; pieces: from key to key; straight: no spline"""

    sides: int
    pieces: int
    straight: bool


class Rings(NamedTuple):
    """Where the rings of tubes are, one a row, the strands one after another.

    strand, key: int32 (r,), the strand and the key before it; part: float32 (r,), how far it is to
    the next key; last: bool (r,), whether it ends a tube: a strand's, or a straight piece's
    """

    strand: np.ndarray
    key: np.ndarray
    part: np.ndarray
    last: np.ndarray


class Tubes(NamedTuple):
    """positions, normals: float32 (n, 3); triangles: int32 (m, 3); ring: int32 (n,), of a corner"""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    ring: np.ndarray


def _neighbours(strands: Strands, key, strand):
    """The four keys that decide a strand after a key: float32 (r, 4), ends are taken twice."""
    low, high = strands.first[strand], strands.first[strand + 1] - 1
    rows = (np.clip(key + step, low, high) for step in (-1, 0, 1, 2))
    return [strands.keys[row] for row in rows]


def choose_shape(strands: Strands, most_pieces: int, straight: bool) -> Shape:
    """Few enough sides and pieces for the number of strands, and enough for their bends.

    most_pieces: between two keys; straight: Cycles' curve shape is a linear one
    """
    pieces = 1
    if not straight and most_pieces > 1 and strands.segments:
        strand = np.repeat(np.arange(len(strands.first) - 1), np.diff(strands.first))
        inner = np.arange(len(strands.keys)) < strands.first[strand + 1] - 1
        key, strand = np.flatnonzero(inner), strand[inner]
        step = max(len(key) // 100_000, 1)  # some of very many tell enough
        key, strand = key[::step], strand[::step]
        a, b, c, d = _neighbours(strands, key, strand)
        stray = np.linalg.norm((b + c - a - d)[:, :3], axis=1) / 16.0
        radius = np.maximum(b[:, 3], c[:, 3])
        far = np.divide(stray, radius, out=np.zeros_like(stray), where=radius > 0.0)
        worst = min(float(np.percentile(far, _SHARE)) / _STRAY, 1e6)
        wanted = int(min(np.ceil(np.sqrt(max(worst, 1.0))), most_pieces, _MOST_PIECES))
        pieces = _pieces(strands.segments, wanted)
    return Shape(_sides(max(strands.segments * pieces, 1), pieces > 1), pieces, straight)


def _pieces(segments: int, wanted: int) -> int:
    """As many as wanted where there is room, and a few where there is little."""
    room, most = (
        _WANTED // (2 * _SIDES_OF_PIECES * segments),
        _MOST // (2 * _LEAST_SIDES * segments),
    )
    return max(min(wanted, max(room, min(_ENOUGH_PIECES, most))), 1)


def _sides(bands: int, in_pieces: bool) -> int:
    """bands: of triangles, of all strands; in_pieces: whether there is room for more of them"""
    fitting = [k for k in _SIDES if 2 * k * bands <= _WANTED]
    if in_pieces and (not fitting or fitting[0] < _SIDES_OF_PIECES):
        fitting = [k for k in _SIDES if k <= _SIDES_OF_PIECES and 2 * k * bands <= _MOST]
    return fitting[0] if fitting else _SIDES[-1]


def count_triangles(strands: Strands, shape: Shape) -> int:
    return 2 * shape.sides * shape.pieces * strands.segments


def find_rings(strands: Strands, shape: Shape) -> Rings:
    """Strands of less than two keys have none."""
    keys = np.diff(strands.first)
    if shape.straight:
        return _ends_of_pieces(strands, keys)
    counts = np.where(keys > 1, (keys - 1) * shape.pieces + 1, 0)
    strand = np.repeat(np.arange(len(keys), dtype=np.int32), counts)
    ends = np.cumsum(counts)
    step = np.arange(len(strand)) - (ends - counts)[strand]
    segment = np.minimum(step // shape.pieces, keys[strand] - 2)
    part = (step - segment * shape.pieces) / np.float32(shape.pieces)
    last = np.zeros(len(strand), bool)
    last[ends[counts > 0] - 1] = True
    key = (strands.first[strand] + segment).astype(np.int32)
    return Rings(strand, key, part.astype(np.float32), last)


def _ends_of_pieces(strands: Strands, keys) -> Rings:
    """Two rings for each piece from key to key. keys: of each strand"""
    pieces = np.maximum(keys - 1, 0)
    strand = np.repeat(np.arange(len(keys), dtype=np.int32), pieces)
    step = np.arange(len(strand)) - (np.cumsum(pieces) - pieces)[strand]
    key = (strands.first[strand] + step).astype(np.int32)
    last = np.tile([False, True], len(strand))
    return Rings(np.repeat(strand, 2), np.repeat(key, 2), last.astype(np.float32), last)


def along(strands: Strands, rings: Rings, straight: bool):
    """Places and radii of rings, float32 (r, 4), and unit tangents, float32 (r, 3)."""
    a, b, c, d = _neighbours(strands, rings.key, rings.strand)
    u = rings.part[:, None]
    if straight:
        values, tangents = b + (c - b) * u, c - b
    else:
        slope, bend, twist = c - a, 2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * (b - c) + d - a
        values = b + 0.5 * u * (slope + u * (bend + u * twist))
        tangents = 0.5 * (slope + u * (2.0 * bend + 3.0 * u * twist))
    values[rings.last] = c[rings.last]  # exactly, so that a tip without radius has none
    values[:, 3] = np.maximum(values[:, 3], 0.0)
    tangents = _unit(tangents[:, :3], (c - b)[:, :3])
    return values, tangents


def _unit(vectors, otherwise):
    """Unit vectors; of those without length the others', or else z."""
    size = np.linalg.norm(vectors, axis=1)
    lost = size <= 1e-20
    if lost.any():
        vectors = np.where(lost[:, None], otherwise, vectors)
        size = np.linalg.norm(vectors, axis=1)
        lost = size <= 1e-20
        vectors = np.where(lost[:, None], np.float32([0.0, 0.0, 1.0]), vectors)
        size = np.where(lost, 1.0, size)
    return (vectors / size[:, None]).astype(np.float32)


def _across(tangents):
    """Unit vectors at right angles to unit tangents."""
    smallest = np.abs(tangents).argmin(axis=1)
    axes = np.eye(3, dtype=np.float32)[smallest]
    return _unit(np.cross(tangents, axes), axes)


def _frames(rings: Rings, tangents, like=None):
    """A vector across each ring, turned from ring to ring no more than the tangents are.

    like: tangents at another time, whose first rings these are turned as
    All strands go on together, the longest first, so that those which still go on stand in front.
    """
    starts = np.flatnonzero(np.append(True, rings.last[:-1]))
    lengths = np.diff(np.append(starts, len(rings.last)))
    order = np.argsort(-lengths, kind="stable")
    starts, lengths = starts[order], lengths[order]
    across = np.empty_like(tangents)
    t = tangents[starts]
    now = _across(t)
    if like is not None:
        before = _across(like[starts])
        now = _unit(before - t * np.einsum("ij,ij->i", t, before)[:, None], now)
    across[starts] = now
    for step in range(1, int(lengths[0])):
        n = int(np.searchsorted(-lengths, -step))
        rows = starts[:n] + step
        t = tangents[rows]
        now = now[:n] - t * np.einsum("ij,ij->i", t, now[:n])[:, None]
        now = _unit(now, _across(t))
        across[rows] = now
    return across


def make_tubes(strands: Strands, shape: Shape, rings: Rings, like: Strands | None = None) -> Tubes:
    """Triangles of all strands; none where a ring has no radius.

    like: the same strands at another time; the tubes begin turned as theirs, so that between the
    two corners go straight to each other
    """
    values, tangents = along(strands, rings, shape.straight)
    others = None if like is None else along(like, rings, shape.straight)[1]
    across = _frames(rings, tangents, others)
    k, r = shape.sides, len(values)
    angles = np.arange(k, dtype=np.float32) * np.float32(2.0 * np.pi / k)
    angles = angles + (rings.strand * _GOLDEN % 1.0 * (2.0 * np.pi)).astype(np.float32)[:, None]
    normals = np.cos(angles)[:, :, None] * across[:, None]
    normals += np.sin(angles)[:, :, None] * np.cross(tangents, across)[:, None]
    wide = np.float32(np.pi / (k * np.sin(np.pi / k)))
    positions = normals * (values[:, 3] * wide)[:, None, None]
    if shape.straight:
        _meet(strands, rings, tangents, positions)
    positions += values[:, None, :3]
    ring = np.repeat(np.arange(r, dtype=np.int32), k)
    triangles = _bands(rings, values[:, 3], k)
    return Tubes(positions.reshape(-1, 3), normals.reshape(-1, 3), triangles, ring)


def _meet(strands: Strands, rings: Rings, tangents, around):
    """Move the corners of straight pieces along these, into the plane between two that meet.

    around: float32 (r, k, 3), from the middle of each ring, changed
    """
    a, b, c, d = (keys[:, :3] for keys in _neighbours(strands, rings.key, rings.strand))
    other = np.where(rings.last[:, None], d - c, b - a)
    size, own = np.linalg.norm(other, axis=1), np.linalg.norm(c - b, axis=1)
    bent = (size > 1e-20) & (own > 1e-20)
    plane = tangents[bent] + other[bent] / size[bent, None]
    aside = np.einsum("rkx,rx->rk", around[bent], plane)
    most = _MOST_MITRE * np.linalg.norm(around[bent], axis=2)
    aside /= np.maximum(np.einsum("rx,rx->r", plane, tangents[bent]), 1e-6)[:, None]
    around[bent] -= np.clip(aside, -most, most)[:, :, None] * tangents[bent, None]


def _bands(rings: Rings, radii, k):
    """int32 (m, 3): two triangles a side from each ring to the next of its strand.

    The two follow each other, so that Embree gets them as one quad (core/embree/triangle_pairs.py).
    """
    rows = np.flatnonzero(~rings.last).astype(np.int32)
    side, following = np.arange(k, dtype=np.int32), (np.arange(k, dtype=np.int32) + 1) % k
    first = np.stack([side, following, following + k], -1)
    second = np.stack([side, following + k, side + k], -1)
    both = np.stack([first, second], axis=1).reshape(-1, 3)
    faces = both[None] + (rows * k)[:, None, None]
    there = radii > 0.0
    if there.all():
        return faces.reshape(-1, 3)
    keep = np.tile(np.stack([there[rows], there[rows + 1]], -1), k)
    return faces[keep]

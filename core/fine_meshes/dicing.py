"""Patches to micropolygons of a size in pixels, without cracks: where they are split.

As in [Fisher09], which Cycles follows: an edge has as many segments as its length in pixels says,
or is split in its middle where these would be uneven, or many. All of it follows from the edge
alone, so that patches on both sides agree. An edge with one segment that has to be split all the
same (the one across it is) becomes two segments, of which the neighbour takes notice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .dicing_view import View, pixel_at, squared_length

_MOST_SEGMENTS = 8  # of an edge that is not split: as many as in Cycles of Blender 5
_UNKNOWN, _SPLIT = 0, -1  # in place of a number of segments
_MOST = np.float32(1e9)
_DEEP = 192  # parts that wait; a deeper one is not split
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], np.float32)
_ZERO, _HALF, _ONE, _TWO, _THREE = (np.float32(x) for x in (0.0, 0.5, 1.0, 2.0, 3.0))


class Patches(NamedTuple):
    """Bicubic Bezier patches that meet at edges.

    points: float32 (f * 4**steps, 4, 4, 3), as of smooth_patches, of the parts that patches have
        after some steps of subdivision, which are nearer to the surface
    corners: int32 (f, 4), the vertex of each corner; edges: int32 (f, 4), from corner k to k + 1
    ends: int32 (e, 2), vertices; vertices: how many there are
    level: how often the mesh was subdivided to get these patches
    steps: and after that, to get their parts
    """

    points: np.ndarray
    corners: np.ndarray
    edges: np.ndarray
    ends: np.ndarray
    vertices: int
    level: int
    steps: int = 0


class Edges(NamedTuple):
    """Edges as trees: int32 (n,) each, but for ``cut``.

    first, last: vertices; child: the row of the first of two parts, the other follows; -1: none
    segments: of those without parts; cut: float32, where it is split, 0 to 1
    """

    first: np.ndarray
    last: np.ndarray
    child: np.ndarray
    segments: np.ndarray
    cut: np.ndarray


class Leaves(NamedTuple):
    """Parts of patches that are not split.

    patch: int32 (n,); uv: float32 (n, 4, 2), corners in their patch
    edges: int32 (n, 4), from corner k to k + 1; turned: bool (n, 4), the edge runs the other way
    """

    patch: np.ndarray
    uv: np.ndarray
    edges: np.ndarray
    turned: np.ndarray


@kernel
def part_at(steps, f, u, v):
    """The part of patch f that (u, v) lies on, and where on it: parts are in the order of corners,
    each with the same corner first."""
    for _ in range(steps):
        u, v = u + u, v + v
        if v < _ONE:
            corner, u, v = (0, u, v) if u < _ONE else (1, v, _TWO - u)
        else:
            corner, u, v = (3, _TWO - v, u) if u < _ONE else (2, _TWO - u, _TWO - v)
        f = 4 * f + corner
    return f, u, v


@kernel
def place_on(surface, f, u, v):
    """The place on patch f at (u, v). surface: points and steps of Patches"""
    points, steps = surface
    f, u, v = part_at(steps, f, u, v)
    a, b = _ONE - u, _ONE - v
    bu0, bu1, bu2, bu3 = a * a * a, _THREE * u * a * a, _THREE * u * u * a, u * u * u
    bv0, bv1, bv2, bv3 = b * b * b, _THREE * v * b * b, _THREE * v * v * b, v * v * v
    x = y = z = np.float32(0.0)
    for row in range(4):
        weight = bv0 if row == 0 else (bv1 if row == 1 else (bv2 if row == 2 else bv3))
        p = points[f, row]
        x += weight * (bu0 * p[0, 0] + bu1 * p[1, 0] + bu2 * p[2, 0] + bu3 * p[3, 0])
        y += weight * (bu0 * p[0, 1] + bu1 * p[1, 1] + bu2 * p[2, 1] + bu3 * p[3, 1])
        z += weight * (bu0 * p[0, 2] + bu1 * p[1, 2] + bu2 * p[2, 2] + bu3 * p[3, 2])
    return x, y, z


@kernel
def _length_in_pixels(surface, f, view, u0, v0, u1, v1):
    """0 where it is no number: what has no place is not to be diced without end."""
    x0, y0, z0 = place_on(surface, f, u0, v0)
    x1, y1, z1 = place_on(surface, f, u1, v1)
    pixel = pixel_at(view, (x0 + x1) * _HALF, (y0 + y1) * _HALF, (z0 + z1) * _HALF)
    found = np.sqrt(squared_length(view, x1 - x0, y1 - y0, z1 - z0)) / pixel
    return min(found, _MOST) if found >= _ZERO else _ZERO


@kernel
def _count_segments(surface, f, view, most, u0, v0, u1, v1):
    """Segments of an edge, or _SPLIT. most: of a whole edge of a patch"""
    um, vm = (u0 + u1) * _HALF, (v0 + v1) * _HALF
    a = _length_in_pixels(surface, f, view, u0, v0, um, vm)
    b = _length_in_pixels(surface, f, view, um, vm, u1, v1)
    even = np.ceil((a + b) / view.rate)
    uneven = np.ceil(_TWO * max(a, b) / view.rate)
    limit = int(most * np.sqrt((u1 - u0) * (u1 - u0) + (v1 - v0) * (v1 - v0)) + np.float32(1e-3))
    if limit <= 1:
        return 1
    if uneven - even > _ONE or uneven > _MOST_SEGMENTS:
        return _SPLIT
    return min(max(int(uneven), 1), limit)


@kernel
def _split_edge(edge, vertices, n, first, last, child, segments, cut):
    """Give an edge two parts, in rows n and n + 1, which meet at the next vertex."""
    t = segments[edge]
    if t == _SPLIT:
        cut[edge], segments[n], segments[n + 1] = _HALF, _UNKNOWN, _UNKNOWN
    else:
        if t == 1:
            t = 2
        half = t // 2
        cut[edge] = np.float32(half) / np.float32(t)
        segments[n], segments[n + 1] = half, t - half
    first[n], last[n], first[n + 1], last[n + 1] = first[edge], vertices, vertices, last[edge]
    child[edge], child[n], child[n + 1] = n, -1, -1


@kernel(allocates=True)
def _longer(array, size):
    found = np.empty((size, *array.shape[1:]), array.dtype)
    found[: len(array)] = array
    return found


@kernel
def _count_around(surface, view, most, f, uv, own, segments):
    """Count the segments of four edges that are not known; True where one is to be split, along u,
    along v."""
    for k in range(4):
        if segments[own[k]] == _UNKNOWN:
            o = (k + 1) % 4
            segments[own[k]] = _count_segments(
                surface, f, view, most, uv[k, 0], uv[k, 1], uv[o, 0], uv[o, 1]
            )
    along_u = segments[own[0]] == _SPLIT or segments[own[2]] == _SPLIT
    along_v = segments[own[1]] == _SPLIT or segments[own[3]] == _SPLIT
    return along_u, along_v


@kernel
def _is_wide(surface, view, f, uv):
    """Whether a part is longer along u than along v."""
    a = _length_in_pixels(surface, f, view, uv[0, 0], uv[0, 1], uv[1, 0], uv[1, 1])
    b = _length_in_pixels(surface, f, view, uv[3, 0], uv[3, 1], uv[2, 0], uv[2, 1])
    c = _length_in_pixels(surface, f, view, uv[1, 0], uv[1, 1], uv[2, 0], uv[2, 1])
    d = _length_in_pixels(surface, f, view, uv[0, 0], uv[0, 1], uv[3, 0], uv[3, 1])
    return a + b >= c + d


@kernel
def _halve(uv, own, turned, r, child, cut, middle, out_uv, out_edges, out_turned, a, b):
    """Write the two halves of a part into rows a and b: across its edges r and r + 2, along a new
    edge, ``middle``, from the former to the latter."""
    o, p, q = (r + 1) % 4, (r + 2) % 4, (r + 3) % 4
    near, far = own[r], own[p]
    s = _ONE - cut[near] if turned[r] else cut[near]
    t = _ONE - cut[far] if turned[p] else cut[far]
    for axis in range(2):
        low = uv[r, axis] + (uv[o, axis] - uv[r, axis]) * s
        high = uv[p, axis] + (uv[q, axis] - uv[p, axis]) * t
        out_uv[a, 0, axis], out_uv[a, 1, axis] = uv[r, axis], low
        out_uv[a, 2, axis], out_uv[a, 3, axis] = high, uv[q, axis]
        out_uv[b, 0, axis], out_uv[b, 1, axis] = low, uv[o, axis]
        out_uv[b, 2, axis], out_uv[b, 3, axis] = uv[p, axis], high
    n, m = child[near], child[far]
    out_edges[a, 0], out_edges[b, 0] = (n + 1, n) if turned[r] else (n, n + 1)
    out_edges[b, 2], out_edges[a, 2] = (m + 1, m) if turned[p] else (m, m + 1)
    out_edges[a, 1], out_edges[b, 3] = middle, middle
    out_edges[a, 3], out_edges[b, 1] = own[q], own[o]
    out_turned[a, 0] = out_turned[b, 0] = turned[r]
    out_turned[a, 2] = out_turned[b, 2] = turned[p]
    out_turned[a, 1], out_turned[b, 3] = False, True
    out_turned[a, 3], out_turned[b, 1] = turned[q], turned[o]


@kernel(allocates=True)
def _split_all(surface, corners, edges, ends, vertices, view, most, limit):
    """All patches to leaves, with their edges; the last number returned is about how many
    triangles they are. Stops where these are more than limit."""
    n, count, triangles = len(ends), 0, 0
    size = 2 * n + 64
    first, last, child = (
        np.empty(size, np.int32),
        np.empty(size, np.int32),
        np.empty(size, np.int32),
    )
    segments, cut = np.zeros(size, np.int32), np.zeros(size, np.float32)
    first[:n], last[:n], child[:n] = ends[:, 0], ends[:, 1], -1
    size = len(corners) + 64
    patch, leaf_uv = np.empty(size, np.int32), np.empty((size, 4, 2), np.float32)
    leaf_edges, leaf_turned = np.empty((size, 4), np.int32), np.empty((size, 4), np.bool_)
    uv, own = np.empty((_DEEP + 2, 4, 2), np.float32), np.empty((_DEEP + 2, 4), np.int32)
    turned = np.empty((_DEEP + 2, 4), np.bool_)
    for f in range(len(corners)):
        top = 1
        for k in range(4):
            uv[0, k, 0], uv[0, k, 1] = _SQUARE[k, 0], _SQUARE[k, 1]
            own[0, k], turned[0, k] = edges[f, k], first[edges[f, k]] != corners[f, k]
        while top > 0:
            top -= 1
            along_u, along_v = _count_around(surface, view, most, f, uv[top], own[top], segments)
            if along_u and along_v:
                along_u = _is_wide(surface, view, f, uv[top])
            if top >= _DEEP or not (along_u or along_v):
                if count == len(patch):
                    size = 2 * count
                    patch, leaf_uv = _longer(patch, size), _longer(leaf_uv, size)
                    leaf_edges, leaf_turned = _longer(leaf_edges, size), _longer(leaf_turned, size)
                patch[count], leaf_uv[count] = f, uv[top]
                leaf_edges[count], leaf_turned[count] = own[top], turned[top]
                count += 1
                t = segments[own[top]]
                triangles += 2 * max(t[0], t[2], 1) * max(t[1], t[3], 1)
                if triangles > limit:
                    break
                continue
            if n + 5 > len(first):
                size = 2 * n + 64
                first, last, child = _longer(first, size), _longer(last, size), _longer(child, size)
                segments, cut = _longer(segments, size), _longer(cut, size)
            r = 0 if along_u else 1
            for edge in (own[top, r], own[top, r + 2]):
                if child[edge] < 0:
                    _split_edge(edge, vertices, n, first, last, child, segments, cut)
                    n, vertices = n + 2, vertices + 1
            first[n], last[n] = last[child[own[top, r]]], last[child[own[top, r + 2]]]
            child[n], segments[n] = -1, _UNKNOWN
            part = uv[top].copy(), own[top].copy(), turned[top].copy()
            _halve(*part, r, child, cut, n, uv, own, turned, top, top + 1)
            n, top = n + 1, top + 2
        if triangles > limit:
            break
    trees = first[:n], last[:n], child[:n], segments[:n], cut[:n]
    leaves = patch[:count], leaf_uv[:count], leaf_edges[:count], leaf_turned[:count]
    return trees, leaves, vertices, triangles


def split_patches(
    patches: Patches, view: View, max_level: int, limit: int
) -> tuple[Edges, Leaves, int] | None:
    """Edges, leaves, and how many vertices there are now; None where they would be more than about
    limit triangles. max_level: an edge of the mesh has 2**max_level segments at most"""
    most = max(2 ** (max_level - patches.level), 1)
    surface = patches.points, patches.steps
    own = surface, patches.corners, patches.edges, patches.ends, patches.vertices
    trees, leaves, vertices, triangles = _split_all(*own, view, np.float32(most), limit)
    return None if triangles > limit else (Edges(*trees), Leaves(*leaves), vertices)

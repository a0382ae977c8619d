"""Leaves of diced patches to triangles: a grid inside of each, sewn to what its edges have."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .dicing import Edges, Leaves

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


class Micropolygons(NamedTuple):
    """Triangles, and where on their patches they are.

    triangles: int32 (m, 3); patch: int32 (m,); uv: float32 (m, 3, 2), of their corners
    vertex_patch: int32 (n,), a patch that a vertex lies on, -1: none; vertex_uv: float32 (n, 2)
    """

    triangles: np.ndarray
    patch: np.ndarray
    uv: np.ndarray
    vertex_patch: np.ndarray
    vertex_uv: np.ndarray


@kernel(allocates=True)
def _totals(child, segments):
    """Segments of edges with all their parts."""
    total = np.empty(len(child), np.int32)
    for edge in range(len(child) - 1, -1, -1):  # parts come after what they are parts of
        c = child[edge]
        total[edge] = max(segments[edge], 1) if c < 0 else total[c] + total[c + 1]
    return total


@kernel(allocates=True)
def _number_edges(child, segments, vertices):
    """The first of the vertices inside of each edge without parts, and the next free number."""
    inside = np.empty(len(child), np.int32)
    for edge in range(len(child)):
        inside[edge] = vertices
        if child[edge] < 0:
            vertices += max(segments[edge], 1) - 1
    return inside, vertices


@kernel
def _grid_of(total, edges):
    return max(total[edges[0]], total[edges[2]]), max(total[edges[1]], total[edges[3]])


@kernel(allocates=True)
def _number_leaves(total, edges, vertices):
    """The first vertex and the first triangle of each leaf's inside, and how many of both there
    are."""
    first, begin = np.empty(len(edges), np.int32), np.empty(len(edges), np.int64)
    triangles, most = 0, 1
    for leaf in range(len(edges)):
        first[leaf], begin[leaf] = vertices, triangles
        mu, mv = _grid_of(total, edges[leaf])
        around = 0
        for k in range(4):
            around += total[edges[leaf, k]]
            most = max(most, total[edges[leaf, k]])
        if mu >= 2 and mv >= 2:
            vertices += (mu - 1) * (mv - 1)
            triangles += 2 * (mu - 2) * (mv - 2) + around + 2 * (mu - 2) + 2 * (mv - 2)
        else:
            triangles += around - 2  # those of the two short edges
    return first, begin, vertices, triangles, most


@kernel(allocates=True)
def _walk(edge, turned, trees, inside, ids, ts):
    """Write the vertices along an edge, as seen by a leaf, and where on it they are; their number
    less one is returned."""
    first, last, child, segments, cut = trees
    waiting, low, high = (
        np.empty(64, np.int32),
        np.empty(64, np.float32),
        np.empty(64, np.float32),
    )
    waiting[0], low[0], high[0], top, n = edge, _ZERO, _ONE, 1, 0
    while top > 0:
        top -= 1
        e, a, b, c = waiting[top], low[top], high[top], child[waiting[top]]
        if c >= 0:
            middle = a + (b - a) * (_ONE - cut[e] if turned else cut[e])
            near, far = (c + 1, c) if turned else (c, c + 1)
            waiting[top], low[top], high[top] = far, middle, b
            waiting[top + 1], low[top + 1], high[top + 1] = near, a, middle
            top += 2
            continue
        t = max(segments[e], 1)
        for k in range(t):
            ts[n] = a + (b - a) * np.float32(k) / np.float32(t)
            if k == 0:
                ids[n] = last[e] if turned else first[e]
            else:
                ids[n] = inside[e] + (t - 1 - k if turned else k - 1)
            n += 1
    ids[n], ts[n] = first[edge] if turned else last[edge], _ONE
    return n


@kernel
def _uv_at(corners, u, v):
    a, b, c, d = (_ONE - u) * (_ONE - v), u * (_ONE - v), u * v, (_ONE - u) * v
    return (
        a * corners[0, 0] + b * corners[1, 0] + c * corners[2, 0] + d * corners[3, 0],
        a * corners[0, 1] + b * corners[1, 1] + c * corners[2, 1] + d * corners[3, 1],
    )


@kernel
def _write(out, row, ids, uvs):
    triangles, uv = out
    for k in range(3):
        triangles[row, k] = ids[k]
        uv[row, k, 0], uv[row, k, 1] = uvs[k]
    return row + 1


@kernel
def _sew(out, row, low, high, corners):
    """Triangles between two rows of vertices, of which the first lies on the right.

    low, high: (ids, u, v, how far along each one is, their number less one)
    """
    ids, u, v, s, n = low
    other_ids, other_u, other_v, other_s, m = high
    i = j = 0
    while i < n or j < m:
        own, across = ids[i], other_ids[j]
        here, there = _uv_at(corners, u[i], v[i]), _uv_at(corners, other_u[j], other_v[j])
        # The row goes on whose next step has its middle first: diagonals stay short.
        if j == m or (i < n and s[i] + s[i + 1] <= other_s[j] + other_s[j + 1]):
            i += 1
            third = _uv_at(corners, u[i], v[i])
            row = _write(out, row, (own, ids[i], across), (here, third, there))
        else:
            j += 1
            third = _uv_at(corners, other_u[j], other_v[j])
            row = _write(out, row, (own, other_ids[j], across), (here, third, there))
    return row


@kernel
def _edge_places(k, n, ts, us, vs):
    """(u, v) in a leaf of what lies on its edge k."""
    for i in range(n + 1):
        t = ts[i]
        us[i] = t if k == 0 else (_ONE if k == 1 else (_ONE - t if k == 2 else _ZERO))
        vs[i] = _ZERO if k == 0 else (t if k == 1 else (_ONE if k == 2 else _ONE - t))


@kernel
def _inner_row(k, mu, mv, first, ids, us, vs, ts):
    """The grid's outermost vertices along edge k; their number less one is returned."""
    m = mu if k % 2 == 0 else mv
    for step in range(1, m):
        i = step if k == 0 else (mu - 1 if k == 1 else (mu - step if k == 2 else 1))
        j = 1 if k == 0 else (step if k == 1 else (mv - 1 if k == 2 else mv - step))
        ids[step - 1] = first + (i - 1) + (j - 1) * (mu - 1)
        us[step - 1], vs[step - 1] = np.float32(i) / np.float32(mu), np.float32(j) / np.float32(mv)
        ts[step - 1] = np.float32(step) / np.float32(m)
    return m - 2


@kernel
def _fill_grid(out, row, mu, mv, first, corners, vertex_uv):
    """The inside of a leaf: vertices, and the triangles between them."""
    for j in range(1, mv):
        for i in range(1, mu):
            own = first + (i - 1) + (j - 1) * (mu - 1)
            u, v = np.float32(i) / np.float32(mu), np.float32(j) / np.float32(mv)
            at = _uv_at(corners, u, v)
            vertex_uv[own, 0], vertex_uv[own, 1] = at
            if i == mu - 1 or j == mv - 1:
                continue
            u1, v1 = np.float32(i + 1) / np.float32(mu), np.float32(j + 1) / np.float32(mv)
            right, far, up = (
                _uv_at(corners, u1, v),
                _uv_at(corners, u1, v1),
                _uv_at(corners, u, v1),
            )
            next_, above = own + 1, own + mu - 1
            row = _write(out, row, (own, next_, above + 1), (at, right, far))
            row = _write(out, row, (own, above + 1, above), (at, far, up))
    return row


@kernel(allocates=True)
def _fill(trees, leaves, total, inside, first, begin, most, out, patch, vertex_patch, vertex_uv):
    """Write the triangles of all leaves, and on which patch their vertices lie."""
    leaf_patch, leaf_uv, leaf_edges, leaf_turned = leaves
    ids, ts = np.empty((5, most + 2), np.int32), np.empty((5, most + 2), np.float32)
    us, vs = np.empty((5, most + 2), np.float32), np.empty((5, most + 2), np.float32)
    n = np.empty(4, np.int64)
    for leaf in range(len(leaf_patch)):
        corners, f, row = leaf_uv[leaf], leaf_patch[leaf], begin[leaf]
        for k in range(4):
            turned = leaf_turned[leaf, k]
            n[k] = _walk(leaf_edges[leaf, k], turned, trees, inside, ids[k], ts[k])
            _edge_places(k, n[k], ts[k], us[k], vs[k])
            for i in range(n[k] + 1):
                own = ids[k, i]
                if vertex_patch[own] < 0:
                    vertex_patch[own] = f
                    vertex_uv[own, 0], vertex_uv[own, 1] = _uv_at(corners, us[k, i], vs[k, i])
        mu, mv = _grid_of(total, leaf_edges[leaf])
        if mu >= 2 and mv >= 2:
            start = first[leaf]
            vertex_patch[start : start + (mu - 1) * (mv - 1)] = f
            row = _fill_grid(out, row, mu, mv, start, corners, vertex_uv)
            for k in range(4):
                m = _inner_row(k, mu, mv, start, ids[4], us[4], vs[4], ts[4])
                low = ids[k], us[k], vs[k], ts[k], n[k]
                row = _sew(out, row, low, (ids[4], us[4], vs[4], ts[4], m), corners)
        else:
            k = 0 if mv == 1 else 1
            m, o = n[k + 2], k + 2
            for i in range(m + 1):
                ids[4, i], ts[4, i] = ids[o, m - i], _ONE - ts[o, m - i]
                us[4, i], vs[4, i] = us[o, m - i], vs[o, m - i]
            low = ids[k], us[k], vs[k], ts[k], n[k]
            row = _sew(out, row, low, (ids[4], us[4], vs[4], ts[4], m), corners)
        patch[begin[leaf] : row] = f


def make_micropolygons(edges: Edges, leaves: Leaves, vertices: int) -> Micropolygons:
    """The triangles of what split_patches() has made."""
    total = _totals(edges.child, edges.segments)
    inside, vertices = _number_edges(edges.child, edges.segments, vertices)
    first, begin, vertices, m, most = _number_leaves(total, leaves.edges, vertices)
    found = Micropolygons(
        triangles=np.empty((m, 3), np.int32),
        patch=np.empty(m, np.int32),
        uv=np.empty((m, 3, 2), np.float32),
        vertex_patch=np.full(vertices, -1, np.int32),
        vertex_uv=np.zeros((vertices, 2), np.float32),
    )
    out = found.triangles, found.uv
    rows = found.patch, found.vertex_patch, found.vertex_uv
    _fill(tuple(edges), tuple(leaves), total, inside, first, begin, most, out, *rows)
    return found

"""Distances to random points, one in each cell of a grid: kernels of core/nodes/voronoi.py.

Points p are a tuple of one to four arrays, float32 (n,): so a kernel is compiled for its number of
dimensions, and its loops over points, which are inside those over cells, become vectors (24 ns a
point in space, 440 where a point goes through all cells before the next one). A place is four
numbers, 0 beyond the dimensions that there are. Cells are numbered as in Cycles, x fastest: ties go
to the first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .cell_numbers import cell_numbers, cell_point, line_number

METRICS = {"EUCLIDEAN": 0, "MANHATTAN": 1, "CHEBYCHEV": 2, "MINKOWSKI": 3}
_EUCLIDEAN, _MANHATTAN = METRICS["EUCLIDEAN"], METRICS["MANHATTAN"]
_CHEBYCHEV, _MINKOWSKI = METRICS["CHEBYCHEV"], METRICS["MINKOWSKI"]
_FARTHEST = np.float32(np.finfo(np.float32).max)
_ZERO, _HALF, _ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
_TWO, _THREE = np.float32(2.0), np.float32(3.0)
_LEAST_ACROSS = np.float32(0.0001)  # squared way between two points that have a border


class Look(NamedTuple):
    """How n points look at their cells, float32 (n,) each; metric: of METRICS; far: scratch;
    before: as of cell_numbers."""

    metric: int
    before: tuple
    randomness: np.ndarray
    exponent: np.ndarray
    smoothness: np.ndarray
    far: np.ndarray


@kernel(forceinline=True)
def _added(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@kernel(forceinline=True)
def _less(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]


@kernel(forceinline=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@kernel(forceinline=True)
def _length(way, metric, exponent):
    x, y, z, w = abs(way[0]), abs(way[1]), abs(way[2]), abs(way[3])
    if metric == _EUCLIDEAN:
        return np.sqrt(_dot(way, way))
    if metric == _MANHATTAN:
        return x + y + z + w
    if metric == _CHEBYCHEV:
        return max(max(x, y), max(z, w))
    powers = x**exponent + y**exponent + (z**exponent + w**exponent)
    return powers ** (_ONE / exponent)


@kernel(forceinline=True)
def _place(p, n):
    """(cell, way from its corner) of point n."""
    d = len(p)  # known to the compiler; min() keeps indices of a shorter tuple inside it
    x, y = p[0][n], p[min(1, d - 1)][n] if d > 1 else _ZERO
    z = p[min(2, d - 1)][n] if d > 2 else _ZERO
    w = p[min(3, d - 1)][n] if d > 3 else _ZERO
    cell = np.floor(x), np.floor(y), np.floor(z), np.floor(w)
    return cell, _less((x, y, z, w), cell)


@kernel(forceinline=True)
def _offset(q, d, side):
    """Number q of the cells about one, ``side`` of them along each dimension."""
    reach = side // 2
    i, q = q % side, q // side
    j, q = q % side, q // side
    k, m = q % side, q // side
    return (
        np.float32(i - reach),
        np.float32(j - reach if d > 1 else 0),
        np.float32(k - reach if d > 2 else 0),
        np.float32(m - reach if d > 3 else 0),
    )


@kernel(forceinline=True)
def _way(p, n, offset, randomness, before):
    """From point n to the point of the cell that is so far off its own."""
    cell, local = _place(p, n)
    point = cell_point(len(p), _added(cell, offset), randomness, before)
    return _less(_added(offset, point), local)


@kernel(forceinline=True)
def _fill_by(p, metric, offset, look):
    for n in range(len(look.far)):
        way = _way(p, n, offset, look.randomness[n], look.before)
        look.far[n] = _length(way, metric, look.exponent[n])


@kernel
def _fill_far(p, offset, look):
    """Write look.far, the distances to the points of the cells so far off."""
    if look.metric == _EUCLIDEAN:
        _fill_by(p, _EUCLIDEAN, offset, look)
    elif look.metric == _MANHATTAN:
        _fill_by(p, _MANHATTAN, offset, look)
    elif look.metric == _CHEBYCHEV:
        _fill_by(p, _CHEBYCHEV, offset, look)
    else:
        _fill_by(p, _MINKOWSKI, offset, look)


@kernel
def find_nearest(p, look, distances, ranks):
    """Write distances of the two nearest points, float32 (n,) each, and int32 numbers of cells.

    Rows of one array would not do: LLVM does not see that they are apart.
    """
    d, far = len(p), look.far
    (best, second), (rank, second_rank) = distances, ranks
    for n in range(len(far)):
        best[n] = second[n] = _FARTHEST
        rank[n] = second_rank[n] = 0
    for q in range(3**d):
        _fill_far(p, _offset(q, d, 3), look)
        own = np.int32(q)
        for n in range(len(far)):
            first, after = far[n] < best[n], far[n] < second[n]
            second_rank[n] = rank[n] if first else (own if after else second_rank[n])
            second[n] = best[n] if first else (far[n] if after else second[n])
            rank[n] = own if first else rank[n]
            best[n] = far[n] if first else best[n]


@kernel
def fill_points(p, look, rank, color, position):
    """Write colours and places, three and four float32 (n,), of points of cells with numbers."""
    d = len(p)
    for n in range(len(rank)):
        cell, _ = _place(p, n)
        own = _added(cell, _offset(np.int64(rank[n]), d, 3))
        r, g, b, _ = cell_numbers(d, own, look.before)
        x, y, z, w = _added(own, cell_point(d, own, look.randomness[n], look.before))
        color[0][n], color[1][n], color[2][n] = r, g, b
        position[0][n], position[1][n], position[2][n], position[3][n] = x, y, z, w


@kernel(forceinline=True)
def _mix(a, b, t):
    return a + (b - a) * t


@kernel
def smooth_points(p, look, distance, color, position):
    """Write distance, colour and place of the nearest points, one flowing into the other.

    distance: float32 (n,); color, position: as of fill_points
    """
    d, far = len(p), look.far
    (red, green, blue), (px, py, pz, pw) = color, position
    for n in range(len(far)):
        red[n] = green[n] = blue[n] = px[n] = py[n] = pz[n] = pw[n] = _ZERO
    for q in range(5**d):
        offset, first = _offset(q, d, 5), q == 0
        _fill_far(p, offset, look)
        for n in range(len(far)):
            smoothness, total = look.smoothness[n], _ZERO if first else distance[n]
            h = min(max(_HALF + _HALF * (total - far[n]) / smoothness, _ZERO), _ONE)
            h = _ONE if first else h * h * (_THREE - _TWO * h)
            less = smoothness * h * (_ONE - h)
            distance[n] = _mix(total, far[n], h) - less
            less = less / (_ONE + _THREE * smoothness)
            cell, _ = _place(p, n)
            own = _added(cell, offset)
            r, g, b, _ = cell_numbers(d, own, look.before)
            red[n], green[n] = _mix(red[n], r, h) - less, _mix(green[n], g, h) - less
            blue[n] = _mix(blue[n], b, h) - less
            x, y, z, w = _added(own, cell_point(d, own, look.randomness[n], look.before))
            px[n], py[n] = _mix(px[n], x, h) - less, _mix(py[n], y, h) - less
            pz[n], pw[n] = _mix(pz[n], z, h) - less, _mix(pw[n], w, h) - less


@kernel(forceinline=True)
def _border_of_line(cell, local, randomness):
    """As Cycles: between the point of the cell and those of its two neighbours."""
    i = np.int32(cell[0])
    middle = line_number(i) * randomness
    left = line_number(np.int32(i - 1)) * randomness - _ONE
    right = line_number(np.int32(i + 1)) * randomness + _ONE
    return min(abs(_HALF * (middle + left) - local), abs(_HALF * (middle + right) - local))


@kernel
def border_distances(p, randomness, before, nearest, distance):
    """Write the distance to the nearest border between two cells. nearest: five of them, scratch"""
    d, (x, y, z, w, least) = len(p), nearest
    if d == 1:
        for n in range(len(distance)):
            cell, local = _place(p, n)
            distance[n] = _border_of_line(cell, local[0], randomness[n])
        return
    for n in range(len(distance)):
        least[n] = distance[n] = _FARTHEST
    for q in range(3**d):
        offset = _offset(q, d, 3)
        for n in range(len(distance)):
            way = _way(p, n, offset, randomness[n], before)
            squared = _dot(way, way)
            closer = squared < least[n]
            least[n] = squared if closer else least[n]
            x[n], y[n] = way[0] if closer else x[n], way[1] if closer else y[n]
            z[n], w[n] = way[2] if closer else z[n], way[3] if closer else w[n]
    for q in range(3**d):
        offset = _offset(q, d, 3)
        for n in range(len(distance)):
            way = _way(p, n, offset, randomness[n], before)
            own = x[n], y[n], z[n], w[n]
            across = _less(way, own)
            size = _dot(across, across)
            far = _HALF * _dot(_added(own, way), across) / np.sqrt(max(size, _LEAST_ACROSS))
            distance[n] = min(distance[n], far if size > _LEAST_ACROSS else _FARTHEST)


@kernel
def point_radii(p, randomness, before, radius):
    """Write half the way from points of cells to the nearest of another cell than theirs."""
    d = len(p)
    for n in range(len(radius)):
        radius[n] = _FARTHEST
    for q in range(3**d):
        offset = _offset(q, d, 3)
        if _dot(offset, offset) > _ZERO:
            for n in range(len(radius)):
                way = _way(p, n, offset, randomness[n], before)
                radius[n] = min(radius[n], _HALF * np.sqrt(_dot(way, way)))

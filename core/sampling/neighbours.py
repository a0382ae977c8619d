"""Shading points that tell of each other: what their samples say together of a sample's spread.

r, the standard deviation of one sample over the pixel's light, comes from few samples; what the
pixels around saw makes it certain sooner. And it must not be the pixel's own luck: a pixel that
stops when it has been lucky comes out too bright. So its own samples weigh a quarter of those of a
pixel beside it, and what all the cell saw of the same material stands in where no pixel around
shows the same surface.

    r^2 = (p (1 - p) + (s^2 + h^2) p) / (p + floor)^2

p: visibility; s, h: relative spread of the samples that were seen, of their luminance and of their
color (luminance.chroma); floor: of the dark, below which a visibility is not worth chasing. All are
over the samples of the pixels' sums, pooled.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.luminance import chroma

# Points that are sampled together where rays are written: a batch is long enough for Embree.
_RAY_POINTS = 256
CELL_PX = 8  # points tell of each other inside aligned squares of the frame, whatever the tiles
# Weights of the samples of a pixel's own, of one beside it and of one at its corner.
_OWN, _BESIDE, _DIAGONAL = 0.25, 0.61, 0.37
_CELL_SAMPLES = 8.0  # what all of the cell says counts as that many samples
_SAME_SURFACE = 0.8  # cosine between two normals


class Neighbours(NamedTuple):
    """Which shading points tell of each other.

    near: int32 (n, 8), the points around on the same surface: 4 beside, 4 at corners; -1 = none
    group: int32 (n,), one number below n for the points of one material in one cell
    """

    near: np.ndarray
    group: np.ndarray


def cell_order(columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points sorted by cell, row, column: (their order, where in it each cell begins; and n).

    columns, rows: int (n,), pixels of the frame
    """
    column, row = columns // CELL_PX, rows // CELL_PX
    order = np.lexsort((columns, rows, column, row))
    column, row = column[order], row[order]
    new = np.ones(len(order) + 1, np.bool_)
    new[1:-1] = (column[1:] != column[:-1]) | (row[1:] != row[:-1])
    return order, np.flatnonzero(new)


def long_blocks(bounds: np.ndarray) -> list[slice]:
    """Slices of blocks that are sampled together. bounds: int, where they begin, and their end"""
    runs, first = [], 0
    for k in range(1, len(bounds)):
        if k + 1 == len(bounds) or bounds[k + 1] - bounds[first] > _RAY_POINTS:
            runs.append(slice(first, k))
            first = k
    return runs


@kernel(forceinline=True)
def _same_surface(material, normal, p, q):
    cosine = normal[p, 0] * normal[q, 0] + normal[p, 1] * normal[q, 1] + normal[p, 2] * normal[q, 2]
    return material[p] == material[q] and cosine > np.float32(_SAME_SURFACE)


@kernel
def fill_neighbours(columns, rows, material, normal, slots, found):
    """find_neighbours into ``found``.

    slots: int32 (CELL_PX + 2, CELL_PX + 2), scratch: the points of one cell and none around
    """
    n, first = len(columns), 0
    while first < n:
        column, row, last = columns[first] // CELL_PX, rows[first] // CELL_PX, first
        slots[:] = -1
        while last < n and columns[last] // CELL_PX == column and rows[last] // CELL_PX == row:
            slots[rows[last] % CELL_PX + 1, columns[last] % CELL_PX + 1] = last
            last += 1
        for p in range(first, last):
            q = first
            while material[q] != material[p]:
                q += 1
            found.group[p] = q
            y, x = rows[p] % CELL_PX + 1, columns[p] % CELL_PX + 1
            beside, corner = 0, 4
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    if dx == 0 and dy == 0:
                        continue
                    q = slots[y + dy, x + dx]
                    if q >= 0 and not _same_surface(material, normal, p, q):
                        q = -1
                    if dx == 0 or dy == 0:
                        found.near[p, beside] = q
                        beside += 1
                    else:
                        found.near[p, corner] = q
                        corner += 1
        first = last


def find_neighbours(columns, rows, material, normal) -> Neighbours:
    """Of points in cell_order: columns, rows, material int (n,); normal float32 (n, 3)."""
    found = Neighbours(np.empty((len(rows), 8), np.int32), np.empty(len(rows), np.int32))
    columns, rows, material = (np.asarray(a, np.int64) for a in (columns, rows, material))
    slots = np.empty((CELL_PX + 2, CELL_PX + 2), np.int32)
    fill_neighbours(columns, rows, material, normal, slots, found)
    return found


def no_neighbours(n: int) -> Neighbours:
    """Every point alone."""
    return Neighbours(np.full((n, 8), -1, np.int32), np.arange(n, dtype=np.int32))


@kernel(forceinline=True)
def reflected_chroma(sums, p):
    """Chroma of the sums of light that row p of PixelSums, or of PassSums, reflects."""
    return chroma(
        sums.diffuse[p, 0] + sums.glossy[p, 0],
        sums.diffuse[p, 1] + sums.glossy[p, 1],
        sums.diffuse[p, 2] + sums.glossy[p, 2],
    )


@kernel(forceinline=True)
def hue_spread(sums, p, n):
    """Sum over n samples, or passes, of row p of what their color is from that of their mean."""
    return max(sums.hue[p] - np.float64(reflected_chroma(sums, p)) / n, 0.0)


@kernel
def _sum_groups(sums, neighbours, totals, scatter):
    """totals: float64 (n, 4), of each group: visible, count, scatter, its degrees of freedom.

    scatter: float64 (n,), sum over a point's seen samples of (f / their mean - 1)^2, and of color
    """
    totals[:] = 0.0
    for p in range(len(sums.count)):
        g, visible = neighbours.group[p], np.float64(sums.visible[p])
        scatter[p] = 0.0
        if visible > 1.0 and sums.seen[p] > 0.0:
            mean = sums.seen[p] / visible
            spread = max(sums.seen_squared[p] - sums.seen[p] * mean, 0.0)
            scatter[p] = (spread + hue_spread(sums, p, visible)) / (mean * mean)
        totals[g, 0] += visible
        totals[g, 1] += sums.count[p]
        totals[g, 2] += scatter[p]
        totals[g, 3] += max(visible - 1.0, 0.0)


@kernel
def pool_spread(points, n, sums, neighbours, floor, totals, scatter, spread):
    """Write r of the first n of ``points``, int32, to spread, float32.

    sums: incremental.PixelSums of all points; floor: a visibility; totals: float64 (points, 4),
    scatter: float64 (points,), scratch
    """
    _sum_groups(sums, neighbours, totals, scatter)
    for i in range(n):
        p = points[i]
        g = neighbours.group[p]
        own = np.float64(sums.visible[p])
        visible = _OWN * own + _CELL_SAMPLES * (totals[g, 0] + 0.5) / (totals[g, 1] + 1.0)
        count = _OWN * sums.count[p] + _CELL_SAMPLES
        around = _OWN * scatter[p] + _CELL_SAMPLES * (totals[g, 2] + 0.1) / (totals[g, 3] + 1.0)
        degrees = _OWN * max(own - 1.0, 0.0) + _CELL_SAMPLES
        for k in range(8):
            q = neighbours.near[p, k]
            if q >= 0:
                weight = _BESIDE if k < 4 else _DIAGONAL
                seen = np.float64(sums.visible[q])
                visible += weight * seen
                count += weight * sums.count[q]
                around += weight * scatter[q]
                degrees += weight * max(seen - 1.0, 0.0)
        part = visible / count
        squared = part * (1.0 - part) + around / degrees * part
        spread[i] = np.sqrt(max(squared, 0.0)) / (part + floor)

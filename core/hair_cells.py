"""Light x hair at cells of the sphere, for the product, as lobe_cells.py has the other lobes.

What a strand does along its axis and round it are factors (hair.py): they are tabled for a point,
and the cells read the tables. Round the axis these go by the angle's place on a square about it.
"""

from __future__ import annotations

import math

import numpy as np

from ._jit import kernel
from .hair import chiang_at, part_along, part_round, rest_along
from .hair_frame import bell_along, bell_round
from .lambert_kinds import CHIANG
from .lobes_at import lobes_at
from .luminance import luminance
from .microfacet import FOUR, HALF, ONE, QUARTER, TWO, ZERO, dot_xyz

# Bells of a strand that are narrower, radians, are looked up for each cell.
_SHARP = np.float32(0.12)
# What a cell has at least, of Lambert's lobe, and of its light where the horizon goes through it.
_LEAST, _CORNER = np.float32(0.02), np.float32(0.05)
# Nodes of the tables: sines from -1 to 1, places on the square from -1 to 3. Where they begin.
_SINES, _PLACES = 32, 32
_PARTS, _REST = 3, 3 * (_SINES + 1)
_ROUND = _REST + _SINES + 1
_TINY = np.float32(1e-12)


@kernel
def _fill_along(at, hair, tables):
    """M of the parts, and M N of the rest."""
    chiang = at.rough[3] == CHIANG
    rest = luminance(*_tinted(at, hair.rest))
    for j in range(_SINES + 1):
        sin_i = min(np.float32(2.0 / _SINES) * np.float32(j) - ONE, ONE)
        cos_i = math.sqrt(max(ONE - sin_i * sin_i, ZERO))
        if chiang:
            for k in range(_PARTS):
                tables[k * (_SINES + 1) + j] = part_along(hair, k, sin_i, cos_i)
            tables[_REST + j] = rest * rest_along(hair, sin_i, cos_i)
        else:
            tables[j] = bell_along(at, hair.frame, sin_i, cos_i)


@kernel(forceinline=True)
def _tinted(at, color):
    return color[0] * at.diffuse[0], color[1] * at.diffuse[1], color[2] * at.diffuse[2]


@kernel
def _fill_round(at, hair, tables):
    """N of the parts, times how much of the light they are."""
    chiang = at.rough[3] == CHIANG
    r = luminance(*_tinted(at, (hair.r, hair.r, hair.r)))
    tt, trt = luminance(*_tinted(at, hair.tt)), luminance(*_tinted(at, hair.trt))
    white = luminance(at.diffuse[0], at.diffuse[1], at.diffuse[2])
    for j in range(_PLACES + 1):
        place = np.float32(4.0 / _PLACES) * np.float32(j) - ONE
        y = place if place <= ONE else TWO - place
        x = ONE - abs(y) if place <= ONE else abs(y) - ONE
        phi, k = math.atan2(y, x), _ROUND + j
        if chiang:
            tables[k] = r * part_round(hair, 0, phi)
            tables[k + _PLACES + 1] = tt * part_round(hair, 1, phi)
            tables[k + 2 * (_PLACES + 1)] = trt * part_round(hair, 2, phi)
        else:
            tables[k] = white * bell_round(at, phi)


@kernel(forceinline=True)
def _read(tables, first, j, f):
    return tables[first + j] + f * (tables[first + j + 1] - tables[first + j])


@kernel(forceinline=True)
def _looked_up(tables, parts, frame, x, y, z):
    """Luminance of hair x cosine from a direction."""
    s = (dot_xyz(frame.along, x, y, z) + ONE) * np.float32(_SINES // 2)
    i = min(max(int(s), 0), _SINES - 1)
    f = s - np.float32(i)
    u, v = dot_xyz(frame.toward, x, y, z), dot_xyz(frame.across, x, y, z)
    v /= max(abs(u) + abs(v), _TINY)
    t = ((v if u >= ZERO else TWO - v) + ONE) * np.float32(_PLACES // 4)
    j = min(max(int(t), 0), _PLACES - 1)
    g = t - np.float32(j)
    found = _read(tables, _REST, i, f) if parts == _PARTS else ZERO
    for k in range(parts):
        along = _read(tables, k * (_SINES + 1), i, f)
        found += along * _read(tables, _ROUND + k * (_PLACES + 1), j, g)
    return found


@kernel(forceinline=True)
def _is_sharp(at):
    if at.rough[3] == CHIANG:
        along = HALF * math.sqrt(min(at.rough[0], FOUR * at.rough[1]))
        return min(along, TWO * at.rough[2]) < _SHARP
    return min(at.rough[0], at.rough[1]) < _SHARP


@kernel(forceinline=True)
def _middle(cells, r):
    """The direction in the middle of four cells that follow each other: those of a larger one."""
    x = cells.x[r] + cells.x[r + 1] + cells.x[r + 2] + cells.x[r + 3]
    y = cells.y[r] + cells.y[r + 1] + cells.y[r + 2] + cells.y[r + 3]
    z = cells.z[r] + cells.z[r + 1] + cells.z[r + 2] + cells.z[r + 3]
    scale = ONE / math.sqrt(x * x + y * y + z * z)
    return x * scale, y * scale, z * scale


@kernel
def add_hair(lobes, p, cells, radius, values, room):
    """Make the Lambert lobe's values over cells, float32 (n,), those of row p, which is hair.

    cells: ProductCells; radius: of a disc of a cell's solid angle; room: float32, for tables: 1024
    numbers are enough. The lobe is widened to four cells, and looked up once for them, unless it is
    sharp: among strands most of the noise is visibility.
    """
    at = lobes_at(lobes, p)
    sharp = _is_sharp(at)
    hair = chiang_at(at, radius * radius * (QUARTER if sharp else ONE))
    _fill_along(at, hair, room)
    _fill_round(at, hair, room)
    parts = _PARTS if at.rough[3] == CHIANG else 1
    for r in range(0, len(values), 4):
        if values[r] + values[r + 1] + values[r + 2] + values[r + 3] <= ZERO:
            continue
        x, y, z = _middle(cells, r)
        hair_there = ZERO if sharp else _looked_up(room, parts, hair.frame, x, y, z)
        for k in range(r, r + 4):
            if values[k] > ZERO:
                x, y, z = cells.x[k], cells.y[k], cells.z[k]
                if sharp:
                    hair_there = _looked_up(room, parts, hair.frame, x, y, z)
                cosine = dot_xyz(at.normal, x, y, z)
                above = min(max(HALF + HALF * cosine / radius, _CORNER), ONE)
                values[k] = max(cells.light[k] * above * hair_there, _LEAST * values[k])

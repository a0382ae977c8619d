"""Embree's question at each hit of a ray: does it end here?

Called by Embree itself, for one ray or a packet, in any thread. The answer is that of grids
(opacity.py makes them); between 0 and 1 it is drawn, by a hash of the ray, so that it is the same
in every run. Of colored grids red, green and blue ask with the same number, each for itself: which
of them are blocked is written to the ray's ID, and it ends where all are. Where a hierarchy stands
in several places, each instance may show some of its triangles alone (moved_accel.py). Rays that
look, and go on behind a face, do not meet it again (embree_hits.py).
"""

from __future__ import annotations

import ctypes

import numba
import numpy as np

from .._jit import c_callback, kernel
from ..machine.addresses import get_byte, get_float, get_int, get_word, put
from .embree_rays import ALL_COLORS
from .opacity_grids import ANGLES, Opacity, angle_of, passes_at

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_NEAR, _DIRECTION, _FAR, _ID = 3, 4, 8, 10  # rows of RTCRayN
_U, _V, _TRIANGLE, _INSTANCE, _PLACE = 3, 4, 5, 7, 8  # rows of RTCHitN
# A ray that goes on has its tnear so much before the face behind which it does: for Embree, whose
# boxes are rounded. What it has passed before is told by how far it is, which is rounded by two
# steps of float32 (2^-24 of it) at the most.
WELL_BEFORE = np.float32(1.0 - 2.0**-10)
_EDGE = np.float32(2.0**-20)  # u, v and what is left of 1 are rounded to about 2^-23 there
JUST_BEFORE, SAME_PLANE = np.float32(1.0 - 2.0**-21), np.float32(1.0 + 2.0**-21)
_GROUPS = 48  # bytes before the address of the groups, in what a filter reads


class LookFilter:
    """What Embree is given with a mesh: the addresses of functions, and of what they read.

    function: for shadow rays; 0 = none; nearest: for rays that ask for the nearest hit
    colored: of Opacity
    """

    function, data, colored = 0, 0, False

    def __init__(self):
        self.nearest = pass_on.address


class ShadowFilter(LookFilter):
    """LookFilter of a mesh with surfaces that let shadow rays through."""

    def __init__(self, opacity: Opacity):
        super().__init__()
        self._arrays, self.colored = opacity.arrays, opacity.colored
        self._places = (ctypes.c_size_t * 6)(*(a.ctypes.data for a in self._arrays))
        self.function = (let_colors_through if self.colored else let_through).address
        self.data = ctypes.addressof(self._places)


class GroupFilter(LookFilter):
    """ShadowFilter of a mesh that stands in several places, each of which shows a part of it."""

    def __init__(self, groups: np.ndarray, opacity: Opacity | None = None):
        """groups: uint8 (faces,), the number of the instance that shows each; of Embree's faces"""
        shown = np.ascontiguousarray(groups)
        self._arrays = (*(() if opacity is None else opacity.arrays), shown)
        self.colored = opacity is not None and opacity.colored
        places = [0] * (7 - len(self._arrays)) + [array.ctypes.data for array in self._arrays]
        self._places = (ctypes.c_size_t * 7)(*places)
        self.data, self.nearest = ctypes.addressof(self._places), show_and_pass_on.address
        both = show_and_let_colors_through if self.colored else show_and_let_through
        self.function = (show_groups if opacity is None else both).address


@kernel
def _drawn(ray, hit, row, u, v):
    """float32 in [0, 255): a hash of a ray and its hit."""
    mixed = np.uint32(get_int(hit + _U * row)) * np.uint32(0x9E3779B1)
    mixed = np.uint32(mixed ^ np.uint32(get_int(hit + _V * row)))
    for axis in range(3):
        bits = np.uint32(get_int(ray + (_DIRECTION + axis) * row))
        mixed = np.uint32(np.uint32(mixed ^ bits) * np.uint32(0x85EBCA6B))
        mixed = np.uint32(mixed ^ np.uint32(mixed >> np.uint32(15)))
    mixed = np.uint32(mixed * np.uint32(0xC2B2AE35))
    mixed = np.uint32(mixed ^ np.uint32(mixed >> np.uint32(16)))
    return np.float32(mixed >> np.uint32(8)) * np.float32(255.0 / 16777216.0)


@kernel
def _blocked(blocked, drawn, values, start, side, u, v, angle, beyond):
    """The colors, bits of int32, that are blocked after a hit."""
    corners = (side + 1) * (side + 2) // 2 * (1 if angle < 0 else ANGLES)
    for color in range(3):
        if drawn >= passes_at(values, start + color * corners, side, u, v, angle, beyond):
            blocked |= 1 << color
    return blocked


@kernel
def _let_through(arguments, colored):
    valid, grids = get_word(arguments), get_word(arguments + 8)
    rays, hits = get_word(arguments + 24), get_word(arguments + 32)
    row = 4 * get_int(arguments + 40)
    rows, starts = get_word(grids), get_word(grids + 8)
    sides, values = get_word(grids + 16), get_word(grids + 24)
    angled, normals = get_word(grids + 32), get_word(grids + 40)
    for lane in range(0, row, 4):
        if get_int(valid + lane) == 0:
            continue
        hit = hits + lane
        triangle = np.int64(get_int(hit + _TRIANGLE * row))
        grid = get_int(rows + 4 * triangle)
        if grid < 0:
            continue
        start, side = get_word(starts + 8 * grid), get_int(sides + 4 * grid)
        u, v = get_float(hit + _U * row), get_float(hit + _V * row)
        angle, beyond = -1, _ZERO
        if get_byte(angled + grid):
            angle, beyond = angle_of(rays + lane, hit, row, normals + 36 * triangle, u, v)
        if colored:
            place, drawn = rays + lane + _ID * row, _drawn(rays + lane, hit, row, u, v)
            own = values, start, side, u, v, angle, beyond
            blocked = _blocked(get_int(place), drawn, *own)
            if blocked != ALL_COLORS:
                put(place, np.int32(blocked))
                put(valid + lane, np.int32(0))
            continue
        passing = passes_at(values, start, side, u, v, angle, beyond)
        if passing > np.float32(0.0) and _drawn(rays + lane, hit, row, u, v) < passing:
            put(valid + lane, np.int32(0))


@kernel
def _show_groups(arguments):
    valid, groups = get_word(arguments), get_word(get_word(arguments + 8) + _GROUPS)
    hits, row = get_word(arguments + 32), 4 * get_int(arguments + 40)
    for lane in range(0, row, 4):
        if get_int(valid + lane) == 0:
            continue
        hit = hits + lane
        group = np.int32(get_byte(groups + get_int(hit + _TRIANGLE * row)))
        if group != get_int(hit + _INSTANCE * row):
            put(valid + lane, np.int32(0))


@kernel(forceinline=True)
def mark_of(face, instance, place, u, v):
    """int32: a number for a face of an instance, by what Embree says of a hit; hardly ever 0.

    A ray that goes on behind the face has it as its ID (pass_on). Odd at an edge of the face, where
    a ray meets the face beyond that edge as well.
    """
    mixed = np.uint32(face + 1) * np.uint32(0x9E3779B1) + np.uint32(instance)
    mixed = np.uint32(np.uint32(mixed) * np.uint32(0x85EBCA6B) + np.uint32(place))
    mixed = np.uint32(mixed ^ np.uint32(mixed >> np.uint32(15))) & np.uint32(0xFFFFFFFE)
    at_edge = min(min(u, v), _ONE - u - v) < _EDGE
    return np.int32(mixed | np.uint32(1 if at_edge else 0))


@kernel(forceinline=True)
def is_passed(mark, other):
    """Whether the same ray meets, as far away, what it has gone behind: mark_of of both.

    The same face, or the one beyond its edge.
    """
    return (mark | 1) == (other | 1) or (mark & other & 1) != 0


@kernel
def _pass_on(arguments):
    valid, row = get_word(arguments), 4 * get_int(arguments + 40)
    rays, hits = get_word(arguments + 24), get_word(arguments + 32)
    for lane in range(0, row, 4):
        ray, hit = rays + lane, hits + lane
        mark = get_int(ray + _ID * row)
        if mark == 0 or get_int(valid + lane) == 0:
            continue
        came, here = get_float(ray + _NEAR * row) / WELL_BEFORE, get_float(ray + _FAR * row)
        face, instance = get_int(hit + _TRIANGLE * row), get_int(hit + _INSTANCE * row)
        u, v = get_float(hit + _U * row), get_float(hit + _V * row)
        own = mark_of(face, instance, get_int(hit + _PLACE * row), u, v)
        if here < came * JUST_BEFORE or (here <= came * SAME_PLANE and is_passed(mark, own)):
            put(valid + lane, np.int32(0))


@c_callback(numba.types.void(numba.types.intp))
def pass_on(arguments):
    """RTCFilterFunctionN: clears the lanes that hit the face behind which they go on, or others
    before it."""
    _pass_on(arguments)


@c_callback(numba.types.void(numba.types.intp))
def show_and_pass_on(arguments):
    """RTCFilterFunctionN: that, and show_groups."""
    _show_groups(arguments)
    _pass_on(arguments)


@c_callback(numba.types.void(numba.types.intp))
def let_through(arguments):
    """RTCFilterFunctionN: clears the lanes whose ray goes on through an opacity."""
    _let_through(arguments, False)


@c_callback(numba.types.void(numba.types.intp))
def let_colors_through(arguments):
    """RTCFilterFunctionN: the same of colored grids."""
    _let_through(arguments, True)


@c_callback(numba.types.void(numba.types.intp))
def show_groups(arguments):
    """RTCFilterFunctionN: clears the lanes that hit what another instance shows."""
    _show_groups(arguments)


@c_callback(numba.types.void(numba.types.intp))
def show_and_let_through(arguments):
    """RTCFilterFunctionN: both."""
    _show_groups(arguments)
    _let_through(arguments, False)


@c_callback(numba.types.void(numba.types.intp))
def show_and_let_colors_through(arguments):
    """RTCFilterFunctionN: both, of colored grids."""
    _show_groups(arguments)
    _let_through(arguments, True)

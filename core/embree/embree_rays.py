"""Rays through Embree, from within kernels: a call by address, a ray on the stack.

The addresses are run-time numbers, so that kernels stay in the disk cache. A ray, and a packet of
rays of width w, is rows of w 32-bit numbers (Embree's rtcore_ray.h):

    origin 0-2, tnear 3, direction 4-6, time 7, tfar 8, mask 9, id 10, flags 11

An occluded ray comes back with tfar = -inf. What colors are blocked, bits 0 to 2, comes back in its
ID where a filter is colored (embree_filter.py). The nearest hits are in embree_hits.py.

A hierarchy may let a ray in a million slip through between two triangles. Of one that found nothing
another is asked that starts beside it; in lanes only where that would be seen (trace_lanes.py);
docs/decisions/0030-rays-through-edges.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..machine.addresses import call, get_float, get_int, put, stack

WIDTH, _MOST = 8, 16  # rays of a packet
_RAY, _ID = 12, 10
_PACKET, _WIDEST = _RAY * WIDTH, _RAY * _MOST
_FOREVER = np.float32(np.inf)
_ZERO = np.float32(0.0)
_ALL = np.uint32(0xFFFFFFFF)  # every bit of a mask; a lane in use; no triangle
# Two vectors that no ray is along at once.
_ONE_WAY, _OTHER_WAY = (0.48, 0.6, 0.64), (-0.64, 0.6, 0.48)
_TURN = np.float32(0.268)  # of 75 degrees
# A ray aside meets the face that another one goes to by so many times that much sooner, where it
# is seen at half a degree or more.
SOONER = np.float32(128.0)


class Traversal(NamedTuple):
    """What a kernel needs to trace rays through one hierarchy: handles and addresses, all int.

    It keeps nothing alive: the Accel that made it must be held as long.

    scene: RTCScene; 0 = no triangle at all
    occluded1, occluded8, intersect1, occluded16, intersect8: where these functions of Embree begin;
        those for 8 and 16 rays are 0 where the processor has no registers for so many
    colored: whether red, green and blue light may be blocked each for itself
    aside: float, metres that a ray which is asked again starts beside the first one; 0: no ray
        slips through, none is asked again
    time: 0 to 1, when rays see what changes its shape (Embree's motion blur)
    coherent: where the arguments are by which intersect8 takes its rays for a sheaf
    """

    scene: int
    occluded1: int
    occluded8: int
    intersect1: int
    colored: bool = False
    aside: float = 0.0
    occluded16: int = 0
    time: float = 0.0
    intersect8: int = 0
    coherent: int = 0


NOTHING = Traversal(0, 0, 0, 0)
ALL_COLORS = 7


@kernel(forceinline=True)
def put_ray(lane, row, ox, oy, oz, dx, dy, dz):
    """Write a ray to one lane of a packet whose rows are so many bytes long."""
    put(lane, np.float32(ox))
    put(lane + row, np.float32(oy))
    put(lane + 2 * row, np.float32(oz))
    put(lane + 4 * row, np.float32(dx))
    put(lane + 5 * row, np.float32(dy))
    put(lane + 6 * row, np.float32(dz))
    put(lane + 8 * row, _FOREVER)


@kernel(forceinline=True)
def put_constants(lane, row, time):
    """Write what all rays have in common. time: of Traversal"""
    put(lane + 3 * row, _ZERO)
    put(lane + 7 * row, np.float32(time))
    put(lane + 9 * row, _ALL)
    put(lane + 10 * row, _ZERO)
    put(lane + 11 * row, _ZERO)


@kernel(forceinline=True)
def _blocked_colors(lane, row):
    """What has not come through of a ray that has been traced: bits."""
    return ALL_COLORS if get_float(lane + 8 * row) < _ZERO else get_int(lane + _ID * row)


@kernel(forceinline=True)
def blocked_one(traversal, ox, oy, oz, dx, dy, dz):
    """The colors, bits, that something blocks on the ray from (ox, oy, oz) along (dx, dy, dz),
    world space."""
    if traversal.scene == 0:
        return 0
    ray = stack(_RAY)
    put_constants(ray, 4, traversal.time)
    put_ray(ray, 4, ox, oy, oz, dx, dy, dz)
    call(traversal.occluded1, (traversal.scene, ray, 0))
    return _blocked_colors(ray, 4)


@kernel(forceinline=True)
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel(forceinline=True)
def start_aside(ox, oy, oz, dx, dy, dz, aside, look):
    """Where a ray starts so many metres beside one from (ox, oy, oz) along (dx, dy, dz).

    look: 0, or 1 for a place 75 degrees from that: edges of a corner are seldom along both ways
    """
    kx, ky, kz = _ONE_WAY
    along, length = kx * dx + ky * dy + kz * dz, dx * dx + dy * dy + dz * dz
    if along * along > 0.9 * length:
        kx, ky, kz = _OTHER_WAY
    x, y, z = _cross(dx, dy, dz, kx, ky, kz)
    if look == 1:
        first, (sx, sy, sz) = _TURN * np.sqrt(length), _cross(dx, dy, dz, x, y, z)
        x, y, z = sx + first * x, sy + first * y, sz + first * z
    by = aside / np.sqrt(x * x + y * y + z * z)
    return ox + by * x, oy + by * y, oz + by * z


@kernel(forceinline=True)
def _blocked_within(traversal, ray, ox, oy, oz, dx, dy, dz, reach):
    """The colors that something blocks before ``reach``; ray: on the stack, with the constants."""
    put_ray(ray, 4, ox, oy, oz, dx, dy, dz)
    put(ray + 32, np.float32(reach))
    put(ray + 4 * _ID, _ZERO)
    if traversal.scene != 0:
        call(traversal.occluded1, (traversal.scene, ray, 0))
    return _blocked_colors(ray, 4)


@kernel
def blocked_aside(traversal, ox, oy, oz, dx, dy, dz, reach):
    """The colors that something blocks, nearer than ``reach``, on one of two rays beside a ray:
    what it has slipped by."""
    ray, blocked, aside = stack(_RAY), 0, np.float32(traversal.aside)
    put_constants(ray, 4, traversal.time)
    for look in range(2):
        if blocked == 0:
            x, y, z = start_aside(ox, oy, oz, dx, dy, dz, aside, look)
            blocked = _blocked_within(traversal, ray, x, y, z, dx, dy, dz, reach)
    return blocked


@kernel(forceinline=True)
def _same_start(o, a, b):
    return o[a, 0] == o[b, 0] and o[a, 1] == o[b, 1] and o[a, 2] == o[b, 2]


@kernel(forceinline=True)
def _fill_packet(packet, valid, o, d, k, n):
    """Put ray k and those after it that start where it starts into a packet; returns how many."""
    size = 0
    while size < WIDTH and k < n and (size == 0 or _same_start(o, k - 1, k)):
        lane = packet + 4 * size
        put_ray(lane, 4 * WIDTH, o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2])
        put(valid + 4 * size, _ALL)
        size += 1
        k += 1
    for unused in range(size, WIDTH):
        put(valid + 4 * unused, _ZERO)
    return size


@kernel(forceinline=True)
def _forget_colors(packet, width):
    for lane in range(width):
        put(packet + 4 * (_ID * width + lane), _ZERO)


@kernel(forceinline=True)
def _occluded_packets(traversal, origins, directions, n, colors, out):
    packet, valid = stack(_PACKET), stack(WIDTH)
    for lane in range(WIDTH):
        put_constants(packet + 4 * lane, 4 * WIDTH, traversal.time)
        put_ray(packet + 4 * lane, 4 * WIDTH, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO)
    k = 0
    while k < n:
        size = _fill_packet(packet, valid, origins, directions, k, n)
        if traversal.colored:
            _forget_colors(packet, WIDTH)
        call(traversal.occluded8, (valid, traversal.scene, packet, 0))
        for lane in range(size):
            out[k + lane] = _blocked_colors(packet + 4 * lane, 4 * WIDTH) & colors
        k += size


@kernel
def occluded_block(traversal, origins, directions, n, colors, out):
    """Write to out, uint8 or bool (>= n,), which colors something blocks on the first n rays,
    float32 (>= n, 3).

    colors: bits of those that are asked for
    Rays of one origin that follow each other go through the hierarchy together.
    """
    o, d = origins, directions
    if traversal.occluded8 != 0:
        _occluded_packets(traversal, o, d, n, colors, out)
    else:
        for k in range(n):
            ray = o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2]
            out[k] = blocked_one(traversal, *ray) & colors
    if traversal.aside > 0.0:
        for k in range(n):
            if not out[k]:
                ray = o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2], _FOREVER
                out[k] = blocked_aside(traversal, *ray) & colors


@kernel
def occluded_within(traversal, origins, directions, reach, towards, open_way, n, colors, out):
    """occluded_block for what lies nearer than ``reach``, float32 (>= n,), in units of direction.

    towards: int32 (>= n,), what a ray goes to, a lamp; open_way: bool, one for each of these,
        whether the last ray to it was free: those that follow are not asked again
    Rays to lamps: few start at one place, so each goes through the hierarchy alone. Those aside
    end before what they go to, a face that shines and is seen flat, or most would be blocked by it.
    """
    o, d = origins, directions
    ray = stack(_RAY)
    put_constants(ray, 4, traversal.time)
    for k in range(n):
        own = o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2], reach[k]
        blocked = _blocked_within(traversal, ray, *own)
        if blocked == 0 and traversal.aside > 0.0 and not open_way[towards[k]]:
            end = reach[k] - SOONER * np.float32(traversal.aside)
            blocked = blocked_aside(traversal, *own[:6], end) if end > _ZERO else 0
        open_way[towards[k]] = blocked == 0
        out[k] = blocked & colors


@kernel(forceinline=True)
def _put_lane(lane, bytes_a_row, numbers, origin, direction, row, s):
    put_ray(
        lane,
        bytes_a_row,
        numbers[origin + s],
        numbers[origin + row + s],
        numbers[origin + 2 * row + s],
        numbers[direction + s],
        numbers[direction + row + s],
        numbers[direction + 2 * row + s],
    )


@kernel(forceinline=True)
def _lanes_one_by_one(traversal, numbers, origin, direction, row, ray, n, seen):
    for k in range(n):
        s = ray[k]
        ox, oy = numbers[origin + s], numbers[origin + row + s]
        dx, dy = numbers[direction + s], numbers[direction + row + s]
        oz, dz = numbers[origin + 2 * row + s], numbers[direction + 2 * row + s]
        seen[s] = ALL_COLORS & ~blocked_one(traversal, ox, oy, oz, dx, dy, dz)


@kernel
def occluded_lanes(traversal, numbers, origin, direction, row, ray, n, together, seen):
    """Write to seen[ray[k]] which colors, bits, come through on ray k of n.

    numbers: float32, rows ``row`` long: x, y, z of origins from ``origin`` on, of directions from
    ``direction`` on; ray: int32 (>= n,), where in the rows; seen: uint8
    together: how many rays that follow each other have one origin, as a rule
    """
    if traversal.occluded8 == 0:
        _lanes_one_by_one(traversal, numbers, origin, direction, row, ray, n, seen)
        return
    width, occluded = WIDTH, traversal.occluded8
    if traversal.occluded16 != 0 and together >= _MOST:
        width, occluded = _MOST, traversal.occluded16
    packet, valid, bytes_a_row = stack(_WIDEST), stack(_MOST), 4 * width
    for lane in range(width):
        put_constants(packet + 4 * lane, bytes_a_row, traversal.time)
        put_ray(packet + 4 * lane, bytes_a_row, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO)
        put(valid + 4 * lane, _ALL)
    for first in range(0, n, width):
        size = min(n - first, width)
        for lane in range(size):
            own = numbers, origin, direction, row, ray[first + lane]
            _put_lane(packet + 4 * lane, bytes_a_row, *own)
        for unused in range(size, width):
            put(valid + 4 * unused, _ZERO)
        if traversal.colored:
            _forget_colors(packet, width)
        call(occluded, (valid, traversal.scene, packet, 0))
        for lane in range(size):
            blocked = _blocked_colors(packet + 4 * lane, bytes_a_row)
            seen[ray[first + lane]] = ALL_COLORS & ~blocked

"""Rays through Embree, from within kernels: a call by address, a ray on the stack.

The addresses are run-time numbers, so that kernels stay in the disk cache. A ray, and a packet of
rays of width w, is rows of w 32-bit numbers (Embree's rtcore_ray.h):

    origin 0-2, tnear 3, direction 4-6, time 7, tfar 8, mask 9, id 10, flags 11    RTCRay
    Ng 12-14, u 15, v 16, primID 17, geomID 18, instance 19 and up                 RTCHit

An occluded ray comes back with tfar = -inf; primID stays as it was where nothing is hit. What
colors are blocked, bits 0 to 2, comes back in its ID where a filter is colored (embree_filter.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._jit import kernel
from .addresses import call, get_float, get_int, put, stack

_WIDTH = 8
_RAY, _ID = 12, 10
_RAY_HIT = 32  # 19, 2 for each level of instances, and room to spare
_PACKET = _RAY * _WIDTH
_FOREVER = np.float32(np.inf)
_ZERO = np.float32(0.0)
_ALL = np.uint32(0xFFFFFFFF)  # every bit of a mask; a lane in use; no triangle


class Traversal(NamedTuple):
    """What a kernel needs to trace rays through one hierarchy: handles and addresses, all int.

    It keeps nothing alive: the Accel that made it must be held as long.

    scene: RTCScene; 0 = no triangle at all
    occluded1, occluded8, intersect1: where these functions of Embree begin; occluded8 is 0 where
        the processor has no registers for 8 rays
    colored: whether red, green and blue light may be blocked each for itself
    """

    scene: int
    occluded1: int
    occluded8: int
    intersect1: int
    colored: bool = False


NOTHING = Traversal(0, 0, 0, 0)
ALL_COLORS = 7


@kernel(forceinline=True)
def _put_ray(lane, row, ox, oy, oz, dx, dy, dz):
    """Write a ray to one lane of a packet whose rows are so many bytes long."""
    put(lane, np.float32(ox))
    put(lane + row, np.float32(oy))
    put(lane + 2 * row, np.float32(oz))
    put(lane + 4 * row, np.float32(dx))
    put(lane + 5 * row, np.float32(dy))
    put(lane + 6 * row, np.float32(dz))
    put(lane + 8 * row, _FOREVER)


@kernel(forceinline=True)
def _put_constants(lane, row):
    """Write what all rays have in common."""
    put(lane + 3 * row, _ZERO)
    put(lane + 7 * row, _ZERO)
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
    _put_constants(ray, 4)
    _put_ray(ray, 4, ox, oy, oz, dx, dy, dz)
    call(traversal.occluded1, (traversal.scene, ray, 0))
    return _blocked_colors(ray, 4)


@kernel(forceinline=True)
def _same_start(o, a, b):
    return o[a, 0] == o[b, 0] and o[a, 1] == o[b, 1] and o[a, 2] == o[b, 2]


@kernel(forceinline=True)
def _fill_packet(packet, valid, o, d, k, n):
    """Put ray k and those after it that start where it starts into a packet; returns how many."""
    size = 0
    while size < _WIDTH and k < n and (size == 0 or _same_start(o, k - 1, k)):
        lane = packet + 4 * size
        _put_ray(lane, 4 * _WIDTH, o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2])
        put(valid + 4 * size, _ALL)
        size += 1
        k += 1
    for unused in range(size, _WIDTH):
        put(valid + 4 * unused, _ZERO)
    return size


@kernel(forceinline=True)
def _forget_colors(packet):
    for lane in range(_WIDTH):
        put(packet + 4 * (_ID * _WIDTH + lane), _ZERO)


@kernel(forceinline=True)
def _occluded_packets(traversal, origins, directions, n, colors, out):
    packet, valid = stack(_PACKET), stack(_WIDTH)
    for lane in range(_WIDTH):
        _put_constants(packet + 4 * lane, 4 * _WIDTH)
        _put_ray(packet + 4 * lane, 4 * _WIDTH, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO)
    k = 0
    while k < n:
        size = _fill_packet(packet, valid, origins, directions, k, n)
        if traversal.colored:
            _forget_colors(packet)
        call(traversal.occluded8, (valid, traversal.scene, packet, 0))
        for lane in range(size):
            out[k + lane] = _blocked_colors(packet + 4 * lane, 4 * _WIDTH) & colors
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
        return
    for k in range(n):
        ray = o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2]
        out[k] = blocked_one(traversal, *ray) & colors


@kernel
def occluded_within(traversal, origins, directions, reach, n, colors, out):
    """occluded_block for what lies nearer than ``reach``, float32 (>= n,), in units of direction.

    Rays to lamps: few start at one place, so each goes through the hierarchy alone.
    """
    o, d = origins, directions
    ray = stack(_RAY)
    _put_constants(ray, 4)
    for k in range(n):
        _put_ray(ray, 4, o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2])
        put(ray + 32, np.float32(reach[k]))
        put(ray + 4 * _ID, _ZERO)
        if traversal.scene != 0:
            call(traversal.occluded1, (traversal.scene, ray, 0))
        out[k] = _blocked_colors(ray, 4) & colors


@kernel(forceinline=True)
def _put_lane(packet, lane, numbers, origin, direction, row, s):
    _put_ray(
        packet + 4 * lane,
        4 * _WIDTH,
        numbers[origin + s],
        numbers[origin + row + s],
        numbers[origin + 2 * row + s],
        numbers[direction + s],
        numbers[direction + row + s],
        numbers[direction + 2 * row + s],
    )


@kernel
def occluded_lanes(traversal, numbers, origin, direction, row, ray, n, seen):
    """Write to seen[ray[k]] which colors, bits, come through on ray k of n.

    numbers: float32, rows ``row`` long: x, y, z of origins from ``origin`` on, of directions from
    ``direction`` on; ray: int32 (>= n,), where in the rows; seen: uint8
    """
    if traversal.occluded8 == 0:
        for k in range(n):
            s = ray[k]
            ox, oy = numbers[origin + s], numbers[origin + row + s]
            dx, dy = numbers[direction + s], numbers[direction + row + s]
            oz, dz = numbers[origin + 2 * row + s], numbers[direction + 2 * row + s]
            seen[s] = ALL_COLORS & ~blocked_one(traversal, ox, oy, oz, dx, dy, dz)
        return
    packet, valid = stack(_PACKET), stack(_WIDTH)
    for lane in range(_WIDTH):
        _put_constants(packet + 4 * lane, 4 * _WIDTH)
        _put_ray(packet + 4 * lane, 4 * _WIDTH, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO)
        put(valid + 4 * lane, _ALL)
    for first in range(0, n, _WIDTH):
        size = min(n - first, _WIDTH)
        for lane in range(size):
            _put_lane(packet, lane, numbers, origin, direction, row, ray[first + lane])
        for unused in range(size, _WIDTH):
            put(valid + 4 * unused, _ZERO)
        if traversal.colored:
            _forget_colors(packet)
        call(traversal.occluded8, (valid, traversal.scene, packet, 0))
        for lane in range(size):
            blocked = _blocked_colors(packet + 4 * lane, 4 * _WIDTH)
            seen[ray[first + lane]] = ALL_COLORS & ~blocked


@kernel
def intersect_block(traversal, origins, directions, triangle, u, v):
    """Write the nearest hits: triangle int32 (n,), -1 = none; u, v float32 (n,).

    origins, directions: float32 (n, 3), world space
    """
    ray = stack(_RAY_HIT)
    _put_constants(ray, 4)
    for k in range(len(origins)):
        o, d = origins[k], directions[k]
        _put_ray(ray, 4, o[0], o[1], o[2], d[0], d[1], d[2])
        put(ray + 60, _ZERO)
        put(ray + 64, _ZERO)
        put(ray + 68, _ALL)  # no triangle
        put(ray + 72, _ALL)
        if traversal.scene != 0:
            call(traversal.intersect1, (traversal.scene, ray, 0))
        triangle[k], u[k], v[k] = get_int(ray + 68), get_float(ray + 60), get_float(ray + 64)


@kernel
def intersect_instances(traversal, origins, directions, triangle, instance, u, v):
    """intersect_block in a scene of instances: triangles as each counts them, and its number,
    int32 (n,)."""
    ray = stack(_RAY_HIT)
    _put_constants(ray, 4)
    for k in range(len(origins)):
        o, d = origins[k], directions[k]
        _put_ray(ray, 4, o[0], o[1], o[2], d[0], d[1], d[2])
        put(ray + 60, _ZERO)
        put(ray + 64, _ZERO)
        for row in range(17, 21):
            put(ray + 4 * row, _ALL)  # no triangle, no instance
        if traversal.scene != 0:
            call(traversal.intersect1, (traversal.scene, ray, 0))
        triangle[k], u[k], v[k] = get_int(ray + 68), get_float(ray + 60), get_float(ray + 64)
        instance[k] = get_int(ray + 76)

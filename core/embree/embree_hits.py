"""The nearest hits of rays through Embree: embree_rays.py's rows, with what was hit below them.

    Ng 12-14, u 15, v 16, primID 17, geomID 18, instance 19, its place in an array 20   RTCHit

primID stays as it was where nothing is hit. Rays that begin go through the hierarchy eight at a
time, as one sheaf (Embree's coherent rays); what they meet does not depend on which eight. One that
slips through between two triangles ends behind those beside it: there it is asked again
(docs/decisions/0030-rays-through-edges.md). One that goes on behind what it has met is the same ray
from there on, as in Cycles: what lies in the plane of a clear face is met as well
(docs/decisions/0049-rays-that-go-on.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..machine.addresses import call, get_float, get_int, put, stack
from .embree_filter import JUST_BEFORE, SAME_PLANE, WELL_BEFORE, is_passed, mark_of
from .embree_rays import SOONER, WIDTH, put_constants, put_ray, start_aside

_ROWS_HIT = 24  # 19, 2 for each level of instances, and room to spare
_RAY_HIT, _SHEAF = 32, _ROWS_HIT * WIDTH
_ZERO, _ALL = np.float32(0.0), np.uint32(0xFFFFFFFF)
_EXPONENT = np.int32(0x7F800000)  # all of these bits are set in a float32 that is none
# A ray that ends so much farther than the one before is asked again; what is so much nearer counts.
_FARTHER, _NEARER = np.float32(1.02), np.float32(0.999)
# The part of Traversal.aside that cameras look aside: less than a pixel, of tiny things as well.
_ASIDE = np.float32(0.25)


class Gone(NamedTuple):
    """How far rays have come, and the faces that they go on behind.

    far: float32 (n,), lengths of their directions; 0: they begin
    mark: int32 (n,), embree_filter.mark_of of the face there; 0: none
    """

    far: np.ndarray
    mark: np.ndarray

    def at(self, which) -> Gone:
        """Those of indices or a mask: copies."""
        return Gone(self.far[which], self.mark[which])


def begin_rays(n: int) -> Gone:
    """Of n rays that have met nothing yet."""
    return Gone(np.zeros(n, np.float32), np.zeros(n, np.int32))


@kernel(forceinline=True)
def _ask_nearest(traversal, ray, ox, oy, oz, d, near, mark):
    """Have the nearest hit written to a ray on the stack; how far it is, or infinity.

    near: float32, where the ray begins; mark: of the face there, which does not count
    """
    put_ray(ray, 4, ox, oy, oz, d[0], d[1], d[2])
    put(ray + 12, near)
    put(ray + 40, np.int32(mark))
    put(ray + 60, _ZERO)
    put(ray + 64, _ZERO)
    for row in range(17, 21):
        put(ray + 4 * row, _ALL)  # no triangle, no instance
    if traversal.scene != 0:
        call(traversal.intersect1, (traversal.scene, ray, 0))
    return get_float(ray + 32)


@kernel(forceinline=True)
def new_look(traversal):
    """Room for a ray that asks for its nearest hit, on the stack of the kernel that calls this."""
    ray = stack(_RAY_HIT)
    put_constants(ray, 4, traversal.time)
    return ray


@kernel(forceinline=True)
def meets(traversal, ray, origin, d, reach):
    """Whether there is anything within reach, of which hit_of then tells: the sooner the shorter.

    origin, d: float32 (3,). A ray that slips through between two triangles is not asked again.
    """
    put_ray(ray, 4, origin[0], origin[1], origin[2], d[0], d[1], d[2])
    put(ray + 32, np.float32(reach))
    for row in range(17, 21):
        put(ray + 4 * row, _ALL)
    if traversal.scene != 0:
        call(traversal.intersect1, (traversal.scene, ray, 0))
    return get_int(ray + 68) >= 0


@kernel(forceinline=True)
def hit_of(ray):
    """(face, instance, u, v) of a ray that meets something, as intersect_block writes them."""
    return get_int(ray + 68), _instance_of(ray), get_float(ray + 60), get_float(ray + 64)


@kernel(forceinline=True)
def _instance_of(ray):
    """Of what was hit: among instances the one, of an array after these counted on; else -1."""
    return get_int(ray + 76) + max(get_int(ray + 80), 0)


@kernel(forceinline=True)
def _mark(ray):
    """mark_of what a ray has met."""
    u, v = get_float(ray + 60), get_float(ray + 64)
    return mark_of(get_int(ray + 68), get_int(ray + 76), get_int(ray + 80), u, v)


@kernel(forceinline=True)
def _ask_behind(traversal, ray, ox, oy, oz, d, far, mark):
    """_ask_nearest behind the face at far, or behind that place where its mark is 0.

    What lies in that face's plane counts; where Embree asks no filter, the face itself would.
    """
    near = far * (SAME_PLANE if mark == 0 else WELL_BEFORE)
    distance = _ask_nearest(traversal, ray, ox, oy, oz, d, near, mark)
    if mark != 0 and distance <= far * SAME_PLANE:
        if distance < far * JUST_BEFORE or is_passed(mark, _mark(ray)):
            distance = _ask_nearest(traversal, ray, ox, oy, oz, d, far * SAME_PLANE, 0)
    return distance


@kernel(forceinline=True)
def _ask_beside(traversal, ray, origin, d, near, aside, distance):
    """What rays beside one meet well before ``distance``, written to a ray on the stack: how far it
    is; ``distance``: nothing. origin: (x, y, z); near: where they begin; aside: metres"""
    x, y, z = origin
    for look in range(2):
        sx, sy, sz = start_aside(x, y, z, d[0], d[1], d[2], aside, look)
        other = _ask_nearest(traversal, ray, sx, sy, sz, d, near, 0)
        if other < _NEARER * distance:
            return other
    return distance


@kernel
def intersect_block(traversal, origins, directions, gone, triangle, instance, u, v):
    """Write the nearest hits: triangle int32 (n,), -1 = none; u, v float32 (n,).

    origins, directions: float32 (n, 3), world space; those that follow each other, side by side
    gone: Gone, behind which they are; written to as well
    instance: int32 (n,), in a scene of instances: which one, that counts the triangle so
    """
    first, second = stack(_RAY_HIT), stack(_RAY_HIT)
    put_constants(first, 4, traversal.time)
    put_constants(second, 4, traversal.time)
    aside, before = _ASIDE * np.float32(traversal.aside), _ZERO
    for k in range(len(origins)):
        x, y, z, d = origins[k, 0], origins[k, 1], origins[k, 2], directions[k]
        far, mark = gone.far[k], gone.mark[k]
        ray, distance = first, _ask_behind(traversal, first, x, y, z, d, far, mark)
        if aside > _ZERO and distance > _FARTHER * before:
            near = far + SOONER * aside if far > _ZERO else _ZERO
            other = _ask_beside(traversal, second, (x, y, z), d, near, aside, distance)
            if other < distance:
                ray, distance = second, other
        before = distance
        triangle[k], instance[k], u[k], v[k] = hit_of(ray)
        # Of two faces in one plane the ray goes on behind both, else it would go to and fro.
        gone.mark[k] = 0 if far > _ZERO and distance <= far * SAME_PLANE else _mark(ray)
        gone.far[k] = distance


@kernel(forceinline=True)
def _fill_packet(packet, valid, o, d, first, size):
    """Put ``size`` rays from ``first`` on into a packet, as such that have met nothing."""
    row = 4 * WIDTH
    for s in range(size):
        k, lane = first + s, packet + 4 * s
        put_ray(lane, row, o[k, 0], o[k, 1], o[k, 2], d[k, 0], d[k, 1], d[k, 2])
        # One that is NaN or infinite would have the others of its sheaf miss what they meet.
        total = o[k, 0] + o[k, 1] + o[k, 2] + d[k, 0] + d[k, 1] + d[k, 2]
        put(lane + 15 * row, _ZERO)
        put(lane + 16 * row, _ZERO)
        for unhit in range(17, 21):
            put(lane + unhit * row, _ALL)
        put(valid + 4 * s, total)
        finite = get_int(valid + 4 * s) & _EXPONENT != _EXPONENT
        put(valid + 4 * s, _ALL if finite else np.uint32(0))
    for unused in range(size, WIDTH):
        put(valid + 4 * unused, _ZERO)


@kernel
def intersect_together(traversal, origins, directions, far, triangle, instance, u, v):
    """intersect_block for rays that begin and go much the same way from one to the next.

    traversal.intersect8 must not be 0. far: float32 (n,), gets how far the hits are
    """
    packet, valid, row = stack(_SHEAF), stack(WIDTH), 4 * WIDTH
    for lane in range(WIDTH):
        put_constants(packet + 4 * lane, row, traversal.time)
        put_ray(packet + 4 * lane, row, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO)
    for first in range(0, len(origins), WIDTH):
        size = min(len(origins) - first, WIDTH)
        _fill_packet(packet, valid, origins, directions, first, size)
        arguments = valid, traversal.scene, packet, traversal.coherent
        call(traversal.intersect8, arguments)
        for s in range(size):
            k, lane = first + s, packet + 4 * s
            far[k], triangle[k] = get_float(lane + 8 * row), get_int(lane + 17 * row)
            u[k], v[k] = get_float(lane + 15 * row), get_float(lane + 16 * row)
            instance[k] = get_int(lane + 19 * row) + max(get_int(lane + 20 * row), 0)
    if traversal.aside > 0.0:
        _mend(traversal, origins, directions, far, triangle, instance, u, v)


@kernel
def _mend(traversal, origins, directions, far, triangle, instance, u, v):
    """Ask those again that may have slipped through between two triangles."""
    ray, before = new_look(traversal), _ZERO
    aside = _ASIDE * np.float32(traversal.aside)
    for k in range(len(origins)):
        if far[k] > _FARTHER * before:
            origin = origins[k, 0], origins[k, 1], origins[k, 2]
            own = origin, directions[k], _ZERO, aside, far[k]
            other = _ask_beside(traversal, ray, *own)
            if other < far[k]:
                far[k] = other
                triangle[k], instance[k], u[k], v[k] = hit_of(ray)
        before = far[k]

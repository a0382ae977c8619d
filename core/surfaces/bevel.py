"""Normals as those of rounded edges: the mean of an object's normals around a point.

Rays through a ball around the point probe the object along three axes, one at right angles to the
face twice as often; what they find is weighted by the multiple importance of the axes and by its
distance, (R - r)^3, as in Cycles [King13]. All that a probe goes through counts, far sides too.
Departure: of faces in one place only one is found.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..embree.embree_hits import hit_of, meets, new_look
from ..geometry.poses import posed_normals, posed_points
from ..geometry.shading import ShadingPoints
from ..machine.turns import aside
from ..scene import Scene
from ..unit_square.sequence import PixelSequence, sequence_point

_MOST_HITS = 16  # of a probe
_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
_SURE, _STEPS = np.float32(1e-6), 10  # of the search for a radius
_LEAST = np.float32(1e-30)
# How often a probe is along the face's normal, its tangent and its bitangent.
_PICKS = np.float32([0.5, 0.25, 0.25])


class _Probes(NamedTuple):
    """Rays of points, ``count`` each.

    axes: float32 (n, 3, 3), of each point: the face's normal, tangent, bitangent
    axis: int8 (m,), along which of them a ray goes; radius: float32 (m,), metres, how far it passes
        the point by; reach: float32 (m,), metres; origins, directions: float32 (m, 3)
    """

    axes: np.ndarray
    axis: np.ndarray
    radius: np.ndarray
    reach: np.ndarray
    origins: np.ndarray
    directions: np.ndarray


def rounded_normals(
    scene: Scene, accel, points: ShadingPoints, radius, count: int, sequence: PixelSequence
) -> np.ndarray:
    """float32 (n, 3): sums of normals, of the mesh's front, in the scene's pose; 0 where a point's
    probes have found nothing.

    accel: of all triangles, opaque; radius: float32 (n,), metres, above 0
    """
    n, total = len(radius), np.zeros((len(radius), 3), np.float32)
    probes = _new_probes(n, count)
    own = points.position, points.geometric_normal, np.ascontiguousarray(radius, np.float32)
    _fill_probes(*own, sequence, count, probes)
    objects = scene.mesh.object_index[points.triangle]
    rays, origins, reach = np.arange(n * count), probes.origins, probes.reach
    offset = np.float32(accel.offset)
    for _ in range(_MOST_HITS):
        directions = np.ascontiguousarray(probes.directions[rays])
        hit, u, v = _hits_within(accel, origins, directions, reach)
        found = posed_points(scene.pose, scene.mesh, hit, u, v, directions)
        if not len(found.pixel):
            break
        along = found.position - origins[found.pixel]
        reach = reach[found.pixel] - np.sqrt(np.einsum("ij,ij->i", along, along)) - offset
        rays = rays[found.pixel]
        mine = np.flatnonzero(scene.mesh.object_index[found.triangle] == objects[rays // count])
        _add(scene, points, radius, probes, rays[mine], found.at(mine), total)
        on = np.flatnonzero(reach > 0.0)
        rays, reach = rays[on], reach[on]
        origins = found.position[on] + offset * probes.directions[rays]
    return total


def _add(scene, points, radius, probes: _Probes, rays, found: ShadingPoints, total) -> None:
    """Add what rays have found to the totals of their points, float32 (n, 3)."""
    of = rays // (len(probes.axis) // len(total))
    across = np.abs(np.einsum("mij,mj->mi", probes.axes[of], found.geometric_normal))
    density = _PICKS * across
    weight = density[np.arange(len(of)), probes.axis[rays]] / (density * density).sum(axis=1)
    away = found.position - points.position[of]
    own = radius[of] - np.sqrt(np.einsum("ij,ij->i", away, away))
    drawn = np.maximum(radius[of] - probes.radius[rays], _LEAST ** np.float32(0.25))
    weight *= (np.maximum(own, 0.0) / drawn) ** 3
    np.add.at(total, of, weight[:, None] * _front_normals(scene, found))


def _front_normals(scene: Scene, found: ShadingPoints) -> np.ndarray:
    """float32 (m, 3): normals of what rays have found, on the mesh's own side."""
    mesh = scene.mesh
    a, b, c = (mesh.vertices[corner] for corner in mesh.triangles[found.triangle].T)
    winding = posed_normals(scene.pose, mesh, found.triangle, np.cross(b - a, c - a))
    back = np.einsum("ij,ij->i", winding, found.geometric_normal) < 0.0
    return np.where(back[:, None], -found.normal, found.normal)


def _new_probes(n: int, count: int) -> _Probes:
    m, single = n * count, np.float32
    rays = np.empty((m, 3), single), np.empty((m, 3), single)
    own = np.empty((n, 3, 3), single), np.empty(m, np.int8)
    return _Probes(*own, np.empty(m, single), np.empty(m, single), *rays)


@aside()
def _hits_within(accel, origins, directions, reach):
    """What rays meet first, as Accel.intersect says, nearer than ``reach``."""
    n = len(origins)
    face, instance = np.empty(n, np.int32), np.empty(n, np.int32)
    u, v = np.empty(n, np.float32), np.empty(n, np.float32)
    _nearest_within(accel.looks, origins, directions, reach, face, instance, u, v)
    return accel.as_triangles(face, u, v, instance)


@kernel
def _nearest_within(traversal, origins, directions, reach, face, instance, u, v):
    ray = new_look(traversal)
    for k in range(len(origins)):
        face[k], instance[k], u[k], v[k] = -1, -1, _ZERO, _ZERO
        if meets(traversal, ray, origins[k], directions[k], reach[k]):
            face[k], instance[k], u[k], v[k] = hit_of(ray)


@kernel(forceinline=True)
def _radius_of(u):
    """The part of the radius within which a part u of all probes is: 10 x^2 - 20 x^3 + 15 x^4 -
    4 x^5 = u, by Newton's steps."""
    x = np.float32(0.25)
    for _ in range(_STEPS):
        x2, left = x * x, _ONE - x
        off = x2 * (np.float32(10.0) + x * (np.float32(-20.0) + x * (np.float32(15.0) - 4 * x)))
        off -= u
        slope = np.float32(20.0) * x * left * left * left
        if abs(off) < _SURE or slope == _ZERO:
            break
        x = min(max(x - off / slope, _ZERO), _ONE)
    return x


@kernel(forceinline=True)
def _write_axes(face, out):
    """Cycles' axes about a face's normal, float32 (3,): how a point's few probes lie shows."""
    x, y, z = face[2] - face[1], face[0] - face[2], face[1] - face[0]
    if x == _ZERO and y == _ZERO and z == _ZERO:
        y, z = face[0] + face[2], -face[1] - face[0]
    scale = _ONE / math.sqrt(max(x * x + y * y + z * z, _LEAST))
    x, y, z = x * scale, y * scale, z * scale
    for a in range(3):
        out[0, a] = face[a]
    out[1, 0], out[1, 1], out[1, 2] = x, y, z
    out[2, 0] = face[1] * z - face[2] * y
    out[2, 1] = face[2] * x - face[0] * z
    out[2, 2] = face[0] * y - face[1] * x


@kernel
def _fill_probes(position, face, radius, sequence, count, probes):
    """Write the rays of each point."""
    for p in range(len(position)):
        axes = probes.axes[p]
        _write_axes(face[p], axes)
        for k in range(count):
            first, second = sequence_point(sequence, p, k)
            u, m = np.float32(first), p * count + k
            if u < np.float32(0.5):
                along, one, other, u = 0, 1, 2, _TWO * u
            elif u < np.float32(0.75):
                along, one, other, u = 1, 0, 2, np.float32(4.0) * u - _TWO
            else:
                along, one, other, u = 2, 1, 0, np.float32(4.0) * u - np.float32(3.0)
            angle = np.float32(2.0 * math.pi) * u
            r = radius[p] * _radius_of(np.float32(second))
            height = math.sqrt(max(radius[p] * radius[p] - r * r, _ZERO))
            x, y = r * math.cos(angle), r * math.sin(angle)
            probes.axis[m], probes.radius[m], probes.reach[m] = along, r, _TWO * height
            for a in range(3):
                probes.directions[m, a] = -axes[along, a]
                aside_by = x * axes[one, a] + y * axes[other, a]
                probes.origins[m, a] = position[p, a] + height * axes[along, a] + aside_by

"""What shader nodes ask of the surfaces around a point, of Embree: how open
it is there (Ambient Occlusion), and how edges look that are rounded (Bevel, bevel.py).

What a point draws comes from its place and the seed, so that it is the same whatever tile it is in,
and whoever asks: what lets light through and what is seen of it agree. Points of a pixel's passes
lie apart, and draw other numbers.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.microfacet import basis, to_world
from ..data.program_ops import asks_around
from ..geometry.poses import normals_at_rest, posed_normals, posed_points
from ..geometry.shading import ShadingPoints
from ..scene import Scene
from ..settings import RenderSettings
from ..unit_square.sequence import PixelSequence, sequence_point, sobol_points
from .bevel import rounded_normals

# Where a pixel has one point alone, its rays are as many as the pass Ambient Occlusion has there.
_AT_ONCE = 64
_RAYS = 1 << 18  # at once
_MOST_LAYERS = 64  # of other objects, that a ray goes through which looks for its own
_OPEN, _ROUNDED = 0x2C1B3C6D, 0x297A2D39  # seeds: what is asked for draws its own numbers
_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
_EIGHTH = np.float32(math.pi / 4.0)  # of a turn


class NearPoints(NamedTuple):
    """Points whose surroundings nodes may ask for. points: where they are in the scene's pose"""

    rays: NearRays
    points: ShadingPoints

    def at(self, which) -> NearPoints:
        """Some of them."""
        return NearPoints(self.rays, self.points.at(which))

    def open_share(self, normal, reach, count: int, local: bool) -> np.ndarray:
        """float32 (n,): the share of ``count`` rays around a normal, by its cosine, that meet
        nothing.

        normal: float32 (n, 3), unit, where the mesh table has the point; reach: float32 (n,),
        metres; local: whether the point's own object alone counts
        """
        share = np.ones(len(normal), np.float32)
        count = self.rays.rays_of_point(count)
        for some in _in_parts(reach > 0.0, count):
            own = self.points.at(some), normal[some], reach[some]
            share[some] = self.rays.open_share(*own, count, local)
        return share

    def rounded_normal(self, radius, count: int) -> np.ndarray:
        """float32 (n, 3): the normal of the edges around, rounded, by ``count`` rays; unit, of the
        mesh's front, where the mesh table has the point; 0 where there is none.

        radius: float32 (n,), metres
        """
        normal = np.zeros((len(radius), 3), np.float32)
        count = self.rays.rays_of_point(count)
        for some in _in_parts(radius > 0.0, count):
            normal[some] = self.rays.rounded_normal(self.points.at(some), radius[some], count)
        return normal


def _in_parts(which: np.ndarray, count: int):
    """Rows of a mask, bool (n,), some at a time, that have ``count`` rays each."""
    rows, step = np.flatnonzero(which), max(_RAYS // count, 1)
    return (rows[first : first + step] for first in range(0, len(rows), step))


class NearRays:
    """Rays of one scene's nodes.

    distance: metres that those look that do not say how far
    """

    def __init__(self, scene: Scene, settings: RenderSettings, accel):
        """accel: an Accel or SceneRays of the scene"""
        self._scene, self._settings, self._accel = scene, settings, accel
        self.distance = scene.shaders.near_distance

    def points(self, points: ShadingPoints) -> NearPoints:
        """Points of the scene's pose, to be asked."""
        return NearPoints(self, points)

    def rays_of_point(self, count: int) -> int:
        """Of a node that asks for ``count``."""
        return max(count, _AT_ONCE) if self._settings.pixel_filter == "CENTER" else count

    def open_share(self, points: ShadingPoints, normal, reach, count: int, local: bool):
        """See NearPoints."""
        normal = posed_normals(self._scene.pose, self._scene.mesh, points.triangle, normal)
        n = len(points.pixel)
        origins, directions = (np.empty((n * count, 3), np.float32) for _ in range(2))
        own = points.position, points.geometric_normal, np.ascontiguousarray(normal, np.float32)
        offset = np.float32(self._accel.offset)
        _fill_cosine_rays(
            *own, self._sequence(points, count, _OPEN), count, offset, origins, directions
        )
        of = np.repeat(np.arange(n, dtype=np.int32), count)
        if local:
            objects = self._scene.mesh.object_index[points.triangle]
            met = self._meets_own(origins, directions, reach[of], objects[of])
        else:
            met = self._accel.throwing.occluded(origins, directions, None, reach[of], of)
        return 1.0 - met.reshape(n, count).mean(axis=1, dtype=np.float32)

    def rounded_normal(self, points: ShadingPoints, radius, count: int):
        """See NearPoints."""
        own = self._scene, self._accel.every, points, radius
        normal = rounded_normals(*own, count, self._sequence(points, count, _ROUNDED))
        size = np.sqrt(np.einsum("ij,ij->i", normal, normal))
        normal /= np.where(size > 0.0, size, np.float32(1.0))[:, None]
        return normals_at_rest(self._scene.pose, self._scene.mesh, points.triangle, normal)

    def _sequence(self, points: ShadingPoints, count: int, what: int) -> PixelSequence:
        seed = self._settings.seed ^ what
        x, y = (_hashed(points.position, own) for own in (seed, seed ^ 0x5BD1E995))
        return PixelSequence(sobol_points(count), x, y, True)

    def _meets_own(self, origins, directions, reach, objects) -> np.ndarray:
        """bool (n,): whether rays meet the object of their number within reach, whatever else is in
        the way."""
        out, rays = np.zeros(len(origins), np.bool_), np.arange(len(origins))
        scene, accel = self._scene, self._accel
        for _ in range(_MOST_LAYERS):
            hit, u, v = accel.every.intersect(origins, directions)
            points = posed_points(scene.pose, scene.mesh, hit, u, v, directions)
            way = points.position - origins[points.pixel]
            left = reach[points.pixel] - np.sqrt(np.einsum("ij,ij->i", way, way))
            own = scene.mesh.object_index[points.triangle] == objects[points.pixel]
            out[rays[points.pixel[own & (left > 0.0)]]] = True
            on = ~own & (left > 0.0)
            if not on.any():
                break
            met = points.pixel[on]
            rays, reach, objects, directions = rays[met], left[on], objects[met], directions[met]
            face = points.geometric_normal[on]  # on the side that the ray comes from
            origins = points.position[on] - np.float32(accel.offset) * face
        return out


def with_near_rays(scene: Scene, settings: RenderSettings, accel) -> Scene:
    """The scene, whose nodes can ask for what is around; as it was where none does.

    accel: its Accel or SceneRays
    """
    if scene.shaders is None or not asks_around(scene.shaders):
        return scene
    near = NearRays(scene, settings, accel)
    return dataclasses.replace(scene, shaders=dataclasses.replace(scene.shaders, near=near))


def _hashed(positions: np.ndarray, seed: int) -> np.ndarray:
    """uint32 (n,): a hash of places, float32 (n, 3)."""
    bits = np.ascontiguousarray(positions, np.float32).view(np.uint32)
    mixed = np.full(len(bits), seed & 0xFFFFFFFF, np.uint32)
    for axis in range(3):
        mixed = (mixed ^ bits[:, axis]) * np.uint32(0x85EBCA6B)
        mixed ^= mixed >> np.uint32(13)
        mixed *= np.uint32(0xC2B2AE35)
        mixed ^= mixed >> np.uint32(16)
    return mixed


@kernel(forceinline=True)
def _on_disk(a, b):
    """A place on the unit disk of one in [-1, 1) squared [ShirleyChiu97], as Cycles': by how much
    the few rays of a point differ, a threshold of it shows."""
    if a == _ZERO and b == _ZERO:
        return _ZERO, _ZERO
    if a * a > b * b:
        radius, angle = a, _EIGHTH * (b / a)
    else:
        radius, angle = b, _TWO * _EIGHTH - _EIGHTH * (a / b)
    return radius * math.cos(angle), radius * math.sin(angle)


@kernel
def _fill_cosine_rays(position, face, normal, sequence, count, offset, origins, directions):
    """Write ``count`` rays of each point, by the cosine at its normal, on whichever side of its
    face: they start off that on their own side."""
    for p in range(len(position)):
        n = normal[p, 0], normal[p, 1], normal[p, 2]
        s, t = basis(n)
        for k in range(count):
            u, v = sequence_point(sequence, p, k)
            x, y = _on_disk(np.float32(2.0 * u - 1.0), np.float32(2.0 * v - 1.0))
            z = math.sqrt(max(_ONE - x * x - y * y, _ZERO))
            wx, wy, wz = to_world(s, t, n, x, y, z)
            m = p * count + k
            above = face[p, 0] * wx + face[p, 1] * wy + face[p, 2] * wz
            aside = -offset if above < _ZERO else offset
            for a in range(3):
                origins[m, a] = position[p, a] + aside * face[p, a]
            directions[m, 0], directions[m, 1], directions[m, 2] = wx, wy, wz

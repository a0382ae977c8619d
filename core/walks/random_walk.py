"""Walks of light under surfaces, from where a camera ray meets one to where they leave it again.

A walk scatters as photons do in the medium under the surface [Chiang16]: walk_steps.py. It ends at
the next triangle of the same object, whatever else is in the way, and leaves that as from a Lambert
surface.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..camera.pixel_filter import WALKS, unit_points
from ..data.rows import rows_of
from ..geometry.poses import posed_points
from ..geometry.shading import ShadingPoints
from ..machine.turns import aside
from ..scene import Scene
from .subsurface import Media, Medium, medium_of
from .walk_steps import enter, go_on, look_on, sort_ends, wander
from .walkers import PLANNED, Meet, Walkers, new_meet, seed_states

# Objects in the way, and the surface that a walk begins on, which it may meet at once.
_MOST_OTHERS = 16
_BESIDE = np.float32(0.125)  # of a shadow ray's offset: off a surface that is in the way


class Exits(NamedTuple):
    """Where walks have ended. of: int64 (m,), ascending, rows of the points that they began at;
    points: on the outside of their surface, with the pixels of those, ``through`` is 1; gain:
    float32 (m, 3)"""

    of: np.ndarray
    points: ShadingPoints
    gain: np.ndarray


class _Walks:
    """Walks under the surfaces of a scene."""

    def __init__(self, scene: Scene, accel, medium: Medium, walkers: Walkers):
        self._scene, self._accel, self._medium, self._walkers = scene, accel, medium, walkers
        self._beside = np.float32(accel.offset) * _BESIDE

    def ends(self, active: np.ndarray) -> ShadingPoints:
        """The points where walks end, on the outside of their surface; ``pixel`` is the walker."""
        found = [self._points(np.zeros(0, np.int64), *_no_hits())]
        while len(active):
            active, meet = self._met(active)
            ended, points = self._own(active, meet)
            found.append(points)
            alive = np.empty(len(active), np.bool_)
            go_on(active, ended, meet.way, self._medium, self._walkers, alive)
            active = active[alive]
        return ShadingPoints(*map(np.concatenate, zip(*found, strict=True)))

    @aside()
    def _met(self, active) -> tuple[np.ndarray, Meet]:
        """The walkers that have met anything, and what."""
        meet = new_meet(len(active))
        wander(active, self._accel.looks, self._medium, self._walkers, meet)
        there = np.flatnonzero(meet.face >= 0)
        return active[there], Meet(*rows_of(meet, there))

    def _own(self, active, meet: Meet) -> tuple[np.ndarray, ShadingPoints]:
        """bool (m,), which ways end at their own object, and there ``meet.way``; the points."""
        walkers, object_of = self._walkers, self._scene.mesh.object_index
        origins, found = walkers.position[active], []
        ended, row = np.zeros(len(active), np.bool_), np.arange(len(active))
        way, other = meet.way, meet
        for _ in range(_MOST_OTHERS):
            hit = self._accel.as_triangles(other.face, other.u, other.v, other.instance)
            met = self._points(active[row], *hit)
            row, n = row[met.pixel], len(met.pixel)
            kind, far = np.empty(n, np.int8), np.empty(n, np.float32)
            sort_ends(met, row, active, walkers, object_of, origins, way, kind, far)
            own, others = np.flatnonzero(kind == 1), np.flatnonzero(kind == 2)
            ended[row[own]], way[row[own]] = True, far[own]
            found.append(met.at(own)._replace(pixel=active[row[own]].astype(np.int32)))
            if not len(others):
                break
            row = row[others]
            starts = met.position[others] + self._beside * walkers.direction[active[row]]
            other = new_meet(len(row))._replace(way=way[row] - far[others])
            look_on(active[row], self._accel.looks, walkers, starts, other)
        return ended, ShadingPoints(*map(np.concatenate, zip(*found, strict=True)))

    def _points(self, active, hit, u, v) -> ShadingPoints:
        scene, back = self._scene, -self._walkers.direction[active]
        return posed_points(scene.pose, scene.mesh, hit, u, v, back, scene.terminator_offset)


def _no_hits():
    return np.zeros(0, np.int32), np.zeros(0, np.float32), np.zeros(0, np.float32)


def walk(
    scene: Scene,
    accel,
    points: ShadingPoints,
    normal: np.ndarray,
    media: Media,
    places: tuple[np.ndarray, np.ndarray, np.ndarray],
    seed: int,
) -> Exits:
    """Where light comes from that points show of what is under their surface.

    normal: float32 (n, 3), shading normals on wo's side; media: of the points; places: int64 (n,),
    column, row and number of each, which its random numbers are made of
    """
    medium, n = medium_of(media), len(points.pixel)
    walkers = Walkers(
        points.position.copy(),
        np.zeros((n, 3), np.float32),
        medium.gain.copy(),
        normal,
        np.zeros((n, 3), np.float32),
        np.zeros(n, np.uint64),
        np.empty((n, PLANNED), np.float32),
        np.zeros(n, np.int32),
        points.triangle,
        scene.mesh.object_index[points.triangle],
        np.zeros(n, np.int32),
    )
    alive = np.zeros(n, np.bool_)
    for k in range(PLANNED // 2):
        walkers.planned[:, 2 * k : 2 * k + 2] = unit_points(*places, seed, WALKS + 3 * k)
    seed_states(*places, seed, walkers.state)
    enter(points, normal, medium, walkers, alive)
    ended = _Walks(scene, accel, medium, walkers).ends(np.flatnonzero(alive))
    order = np.argsort(ended.pixel, kind="stable")
    ended = ended.at(order)
    of = ended.pixel.astype(np.int64)
    gain = walkers.throughput.take(of, axis=0)
    return Exits(of, ended._replace(pixel=points.pixel[of]), gain)

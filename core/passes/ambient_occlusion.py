"""The ambient-occlusion pass: how much of an even sky, as far as a distance, a pixel's points see.

By rays of its own over the cosine at the shading normal, as Cycles' pass: those to the HDRI go
where its light is, and tell little of where it is dark.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import Lobes
from ..bsdf.microfacet import basis, dot, to_world
from ..bsdf.sheen import diffuse_colors
from ..data.rows import any_in_row
from ..embree.accel import Accel, start_shadow_ray
from ..geometry.shading import ShadingPoints
from ..scene import ROUND, Scene
from ..settings import RenderSettings
from ..unit_square.sequence import PixelSequence, pixel_sequence, sequence_point, sobol_points

# Rays of a shading point: in a pass, and where a pixel has only one.
_OF_A_PASS, _AT_ONCE = 4, 64
_SEED = 0x5A0C  # other numbers than the light's
_ZERO, _ONE, _ROUND = np.float32(0.0), np.float32(1.0), np.float32(ROUND)


class TileOcclusion:
    """The pass of n pixels of one tile; costs nothing where the scene does not ask for it.

    traced: rays so far
    """

    def __init__(self, scene: Scene, settings: RenderSettings, accel: Accel, n: int):
        self._reach, self._accel, self._settings = scene.asked.occlusion_distance, accel, settings
        self._open = np.zeros((n if self.wanted else 0, 3), np.float64)
        self.traced = 0

    @property
    def wanted(self) -> bool:
        """Whether there is anything to do."""
        return self._reach > 0.0

    def look_at(self, accel: Accel) -> None:
        """Trace rays there from now on."""
        self._accel = accel

    def add_pass(self, points: ShadingPoints, lobes: Lobes, places, number: np.ndarray) -> None:
        """Add points of passes to their pixels.

        places: column and row in the frame of each; number: int64 (n,), of each its pass
        """
        if self.wanted:
            self._add(points, _normals(points, lobes), points.through, places, number)

    def add_panes(self, panes: ShadingPoints, taken, places, number: np.ndarray) -> None:
        """Add surfaces that rays of passes go through and that show nothing, as Cycles does.

        taken: float32 (n, 3), of the light; the others as of add_pass
        """
        if self.wanted and len(number):
            facing = panes.facing_viewer()
            self._add(facing, facing.normal, taken, places, number)

    def _add(self, points, normal, factor, places, number) -> None:
        own = self._seen(points, normal, places, number * _OF_A_PASS, _OF_A_PASS)
        np.add.at(self._open, points.pixel, own[:, None] * factor)

    def settle(self, points: ShadingPoints, lobes: Lobes, places) -> None:
        """Have the pass of points, once and for all; row k of the tile is point k."""
        if self.wanted:
            facing = points.facing_viewer()
            own = self._seen(facing, _normals(facing, lobes), places, 0, _AT_ONCE)
            self._open[:] = own[:, None] * points.through

    def add_to_layers(self, layers, rows, place, weight) -> None:
        """Write a tile's layer. rows: of the points; place: pixels of the layer, -1 = outside;
        weight: float64, one over the passes of each."""
        if not self.wanted:
            return
        flat, inside = layers["ambient_occlusion"].reshape(-1, 3), place >= 0
        seen = self._open[rows] * weight[:, None]
        flat[place[inside]] = seen[inside]

    def panes_at_once(self, panes: ShadingPoints, taken, places) -> np.ndarray:
        """float64 (n, 3): what panes add to a picture of one ray a pixel; as of add_panes."""
        facing = panes.facing_viewer()
        own = self._seen(facing, facing.normal, places, 0, _AT_ONCE)
        return own[:, None] * taken

    def _seen(self, points, normal, places, first, count) -> np.ndarray:
        """float64 (n,): the share of ``count`` rays, from ``first`` on, that meet nothing."""
        n = len(points.pixel)
        first = np.broadcast_to(first, n).astype(np.int64)
        sequence = _sequence(places, int(first.max(initial=0)) + count, self._settings)
        origins, directions = (np.zeros((n * count, 3), np.float32) for _ in range(2))
        offset = np.float32(self._accel.offset)
        own = points, normal, sequence, first, count, offset
        _fill_rays(*own, origins, directions)
        reach = np.full(n * count, self._reach, np.float32)
        met = self._accel.occluded(origins, directions, None, reach)
        self.traced += n * count
        return 1.0 - met.reshape(n, count).mean(axis=1)


def _normals(points, lobes) -> np.ndarray:
    """float32 (n, 3): of what is diffuse; bumps of gloss alone are not there, as in Cycles."""
    bumped = any_in_row(diffuse_colors(lobes))[:, None]
    return np.where(bumped, lobes.normal, points.normal)


@functools.lru_cache(maxsize=4)
def _points(count: int) -> np.ndarray:
    """The first points of Sobol's sequence."""
    return sobol_points(count)


def _sequence(places, count, settings) -> PixelSequence:
    """Each pixel's own, whatever the light's samples use."""
    column, row = (place.astype(np.int32) for place in places)
    width = int(column.max(initial=0)) + 1
    seed = settings.seed ^ _SEED
    pixel = row * np.int32(width) + column
    # As many as a power of two: passes after one another share them.
    points = _points(1 << max(count - 1, 1).bit_length())
    return pixel_sequence(points, pixel, (0, 0, width), seed, "OWEN")


@kernel
def _fill_rays(points, normal, sequence, first, count, offset, origins, directions):
    """Write rays first[p] ... first[p] + count - 1 of each point p."""
    for p in range(len(points.pixel)):
        face, n = points.geometric_normal[p], normal[p]
        side = dot(n, face)
        side = -_ONE if side < _ZERO else _ONE  # of a translucent closure
        up = (side * n[0], side * n[1], side * n[2])
        s, t = basis(up)
        # A patch that is no higher than that is a flat face, rounded.
        below, height = points.lift_below[p], dot(points.lift[p], points.lift[p])
        lifted = below >= _ROUND or (below > _ZERO and height > offset * offset)
        for k in range(count):
            u, v = sequence_point(sequence, p, first[p] + k)
            radius, angle = np.float32(math.sqrt(u)), np.float32(2.0 * math.pi * v)
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            z = np.float32(math.sqrt(1.0 - u))
            wx, wy, wz = to_world(s, t, up, x, y, z)
            m = p * count + k
            # From the smooth patch over coarse faces, and through the face itself, where bumps let
            # rays go below it: as Cycles' rays of this pass.
            if not start_shadow_ray(points, p, wx, wy, wz, lifted, offset, origins, m):
                for a in range(3):
                    origins[m, a] = points.position[p, a] - offset * face[a]
            directions[m, 0], directions[m, 1], directions[m, 2] = wx, wy, wz

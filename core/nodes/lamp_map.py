"""A lamp's program over its UV map: the texels of its picture (lamp_pictures.py has the map).

As Cycles has it, a lamp's point is where its light leaves; its normal is the way it shines from
there, and so, here, is the way to what it lights; its UV map is its parametric one. Of a lamp that
is a disc which faces what it lights, a direction has the mean over the disc.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.program import Program, SurfaceData, Value
from ..scene import Camera
from .context import ShadeContext
from .evaluate import Evaluation
from .falloff import Falloff, falloff_of

_BLOCK = 1 << 15  # points at once
_GRID = 24  # places along a side that a falloff is looked for at
_ON_DISC = 8  # places on a disc, turned otherwise for each texel: the lamp's samples see many
_GOLDEN = np.pi * (3.0 - 5.0**0.5)
_ASIDE = 0.6, np.ones(1)  # a place on a disc that is not its middle


class LampPlaces(NamedTuple):
    """Where a lamp's light leaves.

    to_world: float64 (4, 4), of its object; width, height: of an area, metres of object space;
        0 = it is none
    radius: of a point or spot, metres of the world, 0 where each direction is its own place
    slope: tangent of half the angle of a spot; 0 = it is none
    flat: whether its picture is on an area, or on a plane across a spot's axis, and not on a sphere
    by_direction: whether the picture is of directions, all from the lamp's middle
    disc: radius of a disc that faces what it lights, metres of the world; 0: it is none, or its
        nodes do not ask where on it light leaves
    """

    to_world: np.ndarray
    width: float = 0.0
    height: float = 0.0
    radius: float = 0.0
    slope: float = 0.0
    flat: bool = False
    by_direction: bool = False
    disc: float = 0.0

    def at(self, u, v) -> tuple[np.ndarray, np.ndarray]:
        """(places, the way they shine), of object space but a radius, float32 (n, 3) each."""
        if self.width > 0.0 and not self.by_direction:
            flat = np.zeros_like(u)
            places = np.column_stack([(u - 0.5) * self.width, (v - 0.5) * self.height, flat])
            return places, np.broadcast_to(np.float32([0.0, 0.0, -1.0]), places.shape)
        if self.flat:
            across = 2.0 * self.slope
            way = np.column_stack([(u - 0.5) * across, (v - 0.5) * across, -np.ones_like(u)])
        else:
            longitude, height = (1.0 - 2.0 * u) * np.pi, -np.cos(v * np.pi)
            level = np.sin(v * np.pi)
            way = np.column_stack([level * np.sin(longitude), level * np.cos(longitude), height])
        way /= np.linalg.norm(way, axis=1)[:, None]
        return np.zeros_like(way), way

    def uv(self, u, v, way) -> np.ndarray:
        """float32 (n, 3): what nodes have for UV, of places on a picture and the way from them."""
        if self.slope == 0.0 and self.width == 0.0:
            u, v = self._uv_of_ball(u, v, way)
        elif self.slope > 0.0 and not self.flat:
            depth = 2.0 * self.slope * np.maximum(-way[:, 2], 1e-6)
            u, v = 0.5 + way[:, 0] / depth, 0.5 + way[:, 1] / depth
        return np.column_stack([u, v, np.zeros_like(u)]).astype(np.float32)

    def _uv_of_ball(self, u, v, way):
        """Of directions in the lamp's own space, which a lamp of several scales bends."""
        matrix = self.to_world[:3, :3]
        scales = np.linalg.norm(matrix, axis=0)
        if np.allclose(scales, scales[0], rtol=1e-6):
            return u, v
        x, y, z = np.linalg.pinv(matrix) @ _unit_columns(matrix) @ way.T
        length = np.maximum(np.sqrt(x * x + y * y + z * z), 1e-30)
        return 0.5 * (1.0 - np.arctan2(x, y) / np.pi), 1.0 - np.arccos(z / length) / np.pi


class _LampContext(ShadeContext):
    """n places of a lamp. on_disc: how far from the middle of a disc, in radii, and the angle;
    None: its middle"""

    def __init__(self, lamp: LampPlaces, camera: Camera, u, v, distance, on_disc=None):
        places, way = lamp.at(u, v)
        matrix = lamp.to_world
        world = places @ matrix[:3, :3].T + matrix[:3, 3]
        turned = np.linalg.pinv(matrix[:3, :3])
        if lamp.width > 0.0 and not lamp.by_direction:
            normal = way @ turned
        else:
            axes = matrix[:3, :3] if lamp.flat else _unit_columns(matrix[:3, :3])
            normal = way @ axes.T
        normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
        if lamp.radius > 0.0 and not lamp.by_direction:
            world += lamp.radius * normal
            places = (world - matrix[:3, 3]) @ turned.T
        elif lamp.disc > 0.0 and on_disc is not None:
            world += lamp.disc * _across(normal, *on_disc)
            places = (world - matrix[:3, 3]) @ turned.T
        none = np.zeros(len(u), np.int32)
        self.mesh, self.camera, self.shadow = None, camera, False
        self._distance = np.broadcast_to(np.float32(distance), len(u))
        self.surface = SurfaceData(
            row=none,
            object_to_world=matrix[None],
            mirrored=np.zeros(1, np.bool_),
            color=np.ones((1, 4), np.float32),
            random=np.zeros(1, np.float32),
            pass_index=np.zeros(1, np.float32),
        )
        self.triangle = none
        self.position = world.astype(np.float32)
        self.normal = self.geometric_normal = self.wo = normal.astype(np.float32)
        self._local = places.astype(np.float32)
        self._uv = lamp.uv(u, v, way)

    camera_ray = False  # its light is asked for, not it itself
    corners = None

    @property
    def object(self):
        """All are of the lamp."""
        return self.triangle

    @property
    def material_index(self):
        """float32 (n,): a lamp has no material."""
        return np.zeros(len(self), np.float32)

    @property
    def generated(self):
        """float32 (n, 3): in the lamp's own space."""
        return self._local

    object_position = generated

    @property
    def parametric(self):
        """float32 (n, 3)."""
        return self._uv

    @property
    def backfacing(self):
        """float32 (n,): nothing sees a lamp's back."""
        return np.zeros(len(self), np.float32)

    def uv(self, name: str = "") -> np.ndarray:
        """float32 (n, 3): whatever its name, the lamp's own."""
        return self._uv

    def attribute(self, name):
        """A lamp has none."""
        return None


def _across(normal, far, angle) -> np.ndarray:
    """float64 (n, 3): so far from the origin, in a plane across each normal."""
    flat = np.abs(normal[:, 2]) < 0.9
    up = np.where(flat[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    side = np.cross(up, normal)
    side /= np.linalg.norm(side, axis=1)[:, None]
    return far * (
        np.cos(angle).reshape(-1, 1) * side + np.sin(angle).reshape(-1, 1) * np.cross(normal, side)
    )


def _unit_columns(matrix) -> np.ndarray:
    return matrix / np.maximum(np.linalg.norm(matrix, axis=0), 1e-30)


def lamp_picture(
    program: Program,
    value: Value,
    lamp: LampPlaces,
    camera: Camera,
    width: int,
    height: int,
    distance: float = 1.0,
) -> np.ndarray:
    """float32 (height, width, 3): a colour of the program, row 0 at the bottom; none is negative.

    camera: what nodes ask of the view is of its place; distance: metres that the light goes
    """
    rows, found = max(_BLOCK // width, 1), []
    for first in range(0, height, rows):
        last = min(first + rows, height)
        v, u = np.meshgrid(
            (np.arange(first, last) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij"
        )
        own = lamp, camera, u.ravel(), v.ravel(), distance
        parts = (
            Evaluation(program, _LampContext(*own, place)).vector(value)
            for place in _places_on_disc(lamp, first * width, u.size)
        )
        found.append(np.mean(list(parts), axis=0, dtype=np.float32))
    return np.maximum(np.concatenate(found), 0.0).reshape(height, width, 3)


def _places_on_disc(lamp: LampPlaces, first: int, n: int):
    """on_disc of n texels from a first one on, as many as their mean is of."""
    if lamp.disc == 0.0:
        return [None]
    turn = 2.0 * np.pi * np.random.default_rng(first).random(n)
    far = np.sqrt((np.arange(_ON_DISC) + 0.5) / _ON_DISC)
    return [(far[k], k * _GOLDEN + turn) for k in range(_ON_DISC)]


def lamp_falloff(program: Program, value: Value, lamp: LampPlaces, camera: Camera) -> Falloff:
    """How a colour of the program changes with the distance. The rest as of lamp_picture."""
    u, v = _grid()

    def light(place, distance):
        context = _LampContext(lamp, camera, u[place], v[place], distance, _ASIDE)
        return np.maximum(Evaluation(program, context).vector(value), 0.0)

    return falloff_of(light, len(u))


def even_color(
    program: Program, value: Value, lamp: LampPlaces, camera: Camera, distance: float
) -> np.ndarray | None:
    """float32 (3,): a colour of the program where it is the same all over the lamp; None: it is
    not. The rest as of lamp_picture"""
    context = _LampContext(lamp, camera, *_grid(), distance)
    found = np.maximum(Evaluation(program, context).vector(value), 0.0)
    return found[0] if (found == found[0]).all() else None


def _grid() -> tuple[np.ndarray, np.ndarray]:
    """u and v, float64 (_GRID^2,)."""
    axis = (np.arange(_GRID) + 0.5) / _GRID
    v, u = np.meshgrid(axis, axis, indexing="ij")
    return u.ravel(), v.ravel()

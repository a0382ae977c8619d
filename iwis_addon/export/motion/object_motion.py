"""Objects that move while the shutter is open: where they are, step by step, as Cycles reads it.

Between two steps an object's place goes straight and its turn and size evenly, about its own
origin. Each object has its own number of steps and may be kept from blurring (object properties,
Cycles). What changes its shape: changing_shapes.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from mathutils import Matrix

from ....core.data.object_motion import ObjectMotion, Shapes
from ..meshes.parts import WITH_SURFACE
from ..placed.instances import Instance

# Slices of the shutter's time; fewer where so many move that Embree's instances would take hundreds
# of megabytes (1 kB each).
_SLICES, _LEAST_SLICES, _MOST_PLACES = 64, 8, 1 << 18
_COPIES_OF_A_PLACE = 5  # that stand still take as much in a slice's hierarchy (190 bytes each)


class Key(NamedTuple):
    """Which instance it is, at every time: the object's name, and the number that Blender gives an
    instance (-1: it is none)."""

    name: str
    number: int


class Motions(NamedTuple):
    """What is read at each of several times.

    steps: of the objects that may blur, by Key: times from the first to the last, 2^n + 1
    places: at each time, by Key: float64 (4, 4); None in the middle: as exported
    """

    steps: dict[Key, int]
    places: list[dict[Key, np.ndarray] | None]


def key_of(item) -> Key:
    """Of one of depsgraph.object_instances."""
    return Key(item.object.name, item.random_id & 0xFFFFFFFF if item.is_instance else -1)


def steps_of(settings) -> int:
    """How many times Cycles reads a camera or an object: 0 where it is kept from blurring."""
    if settings is None:
        return 3
    return (2 << (max(settings.motion_steps, 1) - 1)) + 1 if settings.use_motion_blur else 0


def read_steps(depsgraph) -> dict[Key, int]:
    """steps of Motions. Objects of the same name (of other files) are not told apart: left out."""
    found, twice = {}, set()
    for item in depsgraph.object_instances:
        if not item.show_self or item.object.type not in WITH_SURFACE:
            continue
        key = key_of(item)
        owners = {item.object, item.parent} if item.is_instance and item.parent else {item.object}
        steps = [steps_of(getattr(owner, "cycles", None)) for owner in owners]
        if key in found:
            twice.add(key)
        found[key] = max(steps) if min(steps) else 0
    return {key: steps for key, steps in found.items() if steps and key not in twice}


def read_places(depsgraph, wanted) -> dict[Key, np.ndarray]:
    """Where things are now. wanted: of Key"""
    found = {}
    for item in depsgraph.object_instances:
        if item.show_self and item.object.type in WITH_SURFACE:
            key = key_of(item)
            if key in wanted:
                found[key] = np.array(item.matrix_world, np.float64)
    return found


def object_motion(
    instances: list[Instance],
    motions: Motions,
    times: np.ndarray,
    shapes: tuple[Shapes, ...] = (),
    copies: int = 0,
) -> tuple[ObjectMotion | None, list[str]]:
    """The motion of a scene's instances, and names of those that move but cannot be blurred.

    times: of CameraMotion; shapes: of ObjectMotion; copies: of Scene.copies, which stand still
    """
    rows, paths, still = [], [], []
    for row, instance in enumerate(instances):
        key = Key(instance.name, instance.number)
        steps = motions.steps.get(key)
        middle = instance.object_to_world
        places = [middle if at is None else at.get(key) for at in motions.places]
        if steps is None or _stands(places, middle):
            continue
        own = places[:: (len(places) - 1) // (steps - 1)]
        path = _path(own, middle)
        if path is None:
            still.append(instance.name)
        else:
            rows.append(row)
            paths.append(path)
    if not rows and not shapes:
        return None, still
    k, places = _SLICES, len(rows) + copies // _COPIES_OF_A_PLACE
    while rows and k > _LEAST_SLICES and k * places > _MOST_PLACES:
        k //= 2
    bright = (np.arange(k) + 0.5) / k
    when = np.interp(bright, np.linspace(0.0, 1.0, len(times)), times)
    matrices = np.array([[path.at(t) for path in paths] for t in when]).reshape(k, -1, 4, 4)
    return ObjectMotion(np.array(rows, np.int32), when, matrices, shapes), still


def _stands(places, middle) -> bool:
    known = [place for place in places if place is not None]
    size = max(float(np.abs(middle).max()), 1.0)
    return len(known) == len(places) and bool(np.abs(np.array(known) - middle).max() < 1e-7 * size)


class _Path(NamedTuple):
    """origins: float64 (k, 3), of the object; turns, sizes: of what its axes do from the middle on;
    middle: its origin there"""

    origins: np.ndarray
    turns: list
    sizes: list
    middle: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """float64 (4, 4): from the middle to a time from 0 to 1."""
        place = time * (len(self.turns) - 1)
        i = min(int(place), len(self.turns) - 2)
        part = place - i
        turn = self.turns[i].slerp(self.turns[i + 1], part)
        size = self.sizes[i].lerp(self.sizes[i + 1], part)
        origin = (1.0 - part) * self.origins[i] + part * self.origins[i + 1]
        matrix = np.array(Matrix.LocRotScale(None, turn, size), np.float64)
        matrix[:3, 3] = origin - matrix[:3, :3] @ self.middle
        return matrix


def _path(places, middle) -> _Path | None:
    """None where an object is not there all the time, or has no size in the middle."""
    if any(place is None or not np.isfinite(place).all() for place in places):
        return None
    if not abs(np.linalg.det(middle[:3, :3])) > 0.0:
        return None
    back = np.linalg.inv(middle[:3, :3])
    turns, sizes = [], []
    for place in places:
        axes = np.eye(4)
        axes[:3, :3] = place[:3, :3] @ back
        _, turn, size = Matrix(axes).decompose()
        if not min(size) > 0.0:
            return None
        if turns:
            turn.make_compatible(turns[-1])
        turns.append(turn)
        sizes.append(size)
    return _Path(np.array([place[:3, 3] for place in places]), turns, sizes, middle[:3, 3])

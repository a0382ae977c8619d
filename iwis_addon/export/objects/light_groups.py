"""Light groups: which of a view layer's lights, what shines and the world are in."""

from __future__ import annotations

import numpy as np

from ....core.data.asked_passes import LightGroups
from ...passes import group_layer
from .object_properties import Asked


def group_numbers(view_layer) -> dict[str, int]:
    """The layer's groups by name; a name that it has not is of no group."""
    return {group.name: number for number, group in enumerate(view_layer.lightgroups)}


def group_of(asked: Asked, numbers: dict[str, int]) -> int:
    """Of an object, -1 = of none. One without a name has its instancer's, as in Cycles."""
    name = asked.own.lightgroup
    if not name and asked.instancer is not None:
        name = asked.instancer.lightgroup
    return numbers.get(name, -1)


def rows_of(every: list[Asked], numbers: dict[str, int]) -> np.ndarray | None:
    """Of all objects of a scene, int32 (n,); None: there are no groups."""
    if not numbers:
        return None
    return np.array([group_of(asked, numbers) for asked in every], np.int32)


def read_groups(every: list[Asked], world, layer: tuple, numbers: dict[str, int]) -> LightGroups:
    """What the core has to know of them.

    world: None = there is none; layer: of Inventory. In a transparent film what is seen of the
    world is in its group where the Environment pass is asked for, as in Cycles.
    """
    if not numbers:
        return LightGroups()
    view_layer, scene, _ = layer
    own = -1 if world is None else numbers.get(world.lightgroup, -1)
    shown = not scene.render.film_transparent or view_layer.use_pass_environment
    return LightGroups(tuple(map(group_layer, numbers)), own, shown, rows_of(every, numbers))

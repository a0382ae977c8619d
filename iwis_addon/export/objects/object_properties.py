"""What the Attribute node reads of data-blocks: custom properties, and Blender's own by their path.

Blender looks in the same order: attributes of geometry nodes' instances (of those that an object
makes itself, not of instances within instances), an instance's instancer, the object, its data; for
View Layer the view layer, the scene, its world.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import bpy
import numpy as np

from ..meshes.element_values import attribute_of, attribute_values

# Name in a SurfaceData table of each kind of Attribute node that is not about a mesh.
TABLES = {"OBJECT": "object", "INSTANCER": "instancer", "VIEW_LAYER": "layer"}


# A path that ends in a number of an array, which Python follows and Blender's own look-up does not.
_OF_AN_ARRAY = re.compile(r"\[\d+\]$")
_BLACK = (0.0, 0.0, 0.0, 1.0)
_NO_NUMBER = 0x7FFFFFFF  # in a persistent_id


class Asked(NamedTuple):
    """Data-blocks that an instance's properties come from, alive as long as the graph.

    instancer: what made the instance; None: it is an object of the scene
    """

    own: object
    instancer: object | None


def blocks_of(kind: str, asked: Asked, layer: tuple) -> list:
    """Where to look, first things first.

    kind: of TABLES' values; layer: the view layer, the scene, its world or None
    """
    if kind == "layer":
        return [block for block in layer if block is not None]
    own = [asked.own, asked.own.data] if asked.own.data is not None else [asked.own]
    return [asked.instancer, *own] if kind == "instancer" and asked.instancer else own


def asks_instancers() -> bool:
    """Whether a material of the file has an Attribute node for instances' own values."""
    trees = [material.node_tree for material in bpy.data.materials if material.node_tree]
    trees += [tree for tree in bpy.data.node_groups if tree.type == "SHADER"]
    kinds = [
        node.attribute_type
        for tree in trees
        for node in tree.nodes
        if node.bl_idname == "ShaderNodeAttribute"
    ]
    return "INSTANCER" in kinds


def outermost_index(item) -> int:
    """The number of one of depsgraph.object_instances among those of its instancer, -1: none."""
    known = [number for number in item.persistent_id if number != _NO_NUMBER]
    return known[-1] if item.is_instance and known else -1


class InstanceValues:
    """Attributes of geometry nodes' instances."""

    def __init__(self):
        self._known: dict = {}

    def rgba_of(self, asked: Asked, index: int, name: str) -> tuple[float, ...] | None:
        """That of an instance, as a color; None: there is none."""
        if index < 0:
            return None
        # What stands for no object, a mesh of its nodes, has its instancer for its object.
        instancer = asked.instancer or asked.own
        key = instancer.as_pointer(), name
        if key not in self._known:
            self._known[key] = _of_instances(instancer, name)
        values = self._known[key]
        return tuple(values[index]) if values is not None and index < len(values) else None


def _of_instances(instancer, name) -> np.ndarray | None:
    """float32 (n, 4), of the instances that an object makes."""
    try:
        geometry = instancer.evaluated_geometry()  # held: what it has made goes with it
    except TypeError:  # an empty, which shows a collection
        return None
    points = geometry.instances_pointcloud()
    attribute = None if points is None else attribute_of(points, name)
    if attribute is None:
        return None
    values = attribute_values(attribute)
    if values.shape[1] == 1:
        values = np.repeat(values, 3, axis=1)
    return np.concatenate([values, np.tile(_BLACK, (len(values), 1))[:, values.shape[1] :]], axis=1)


def rgba_of(blocks: list, name: str) -> tuple[float, ...]:
    """The first value of that name, as a color: a number is grey; of none all is 0, alpha too."""
    for block in blocks:
        found = _number_or_vector(_value(block, name))
        if found is not None:
            return found
    return 0.0, 0.0, 0.0, 0.0


def outputs_of(blocks: list, name: str) -> dict[str, np.ndarray]:
    """What an Attribute node gives of data-blocks where that is the same everywhere."""
    *color, alpha = np.float32(rgba_of(blocks, name))
    color = np.float32(color)
    return {"Color": color, "Vector": color, "Fac": color.mean(), "Alpha": alpha}


def _value(block, name):
    if _OF_AN_ARRAY.search(name):
        return None
    try:
        return block[name] if name in block.keys() else block.path_resolve(name)
    except (TypeError, ValueError, KeyError, AttributeError, IndexError):
        return None


def _number_or_vector(value) -> tuple[float, ...] | None:
    if isinstance(value, (bool, int, float)):
        return (float(value),) * 3 + (1.0,)
    try:
        numbers = np.array(value, np.float64)
    except (TypeError, ValueError):
        return None
    if numbers.ndim != 1 or not 0 < len(numbers) <= 4 or isinstance(value, (str, bytes)):
        return None
    return tuple([*numbers.tolist(), *_BLACK[len(numbers) :]])

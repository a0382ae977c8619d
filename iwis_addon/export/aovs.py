"""AOV Output nodes of materials and worlds: values that they write into passes of a layer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.data.program import Aov, Program, WorldProgram
from ..passes import aov_layer, wanted_aovs
from .images.texel_cache import TexelCache
from .shaders.node_values import NodeReader
from .shaders.program_builder import ProgramBuilder
from .shaders.program_images import ImageStore
from .shaders.seen_tree import seen_tree
from .worlds.world import is_in_layer, world_of
from .worlds.world_builder import WorldBuilder, WorldReader
from .worlds.world_coordinates import CAMERA_RAYS


class AovExport(NamedTuple):
    """The passes, and for each material the mesh data that they need, as in MaterialExport."""

    aovs: tuple[Aov, ...]
    requests: tuple[frozenset[str], ...]


class _Written(NamedTuple):
    """What one material writes. values: name of an AOV -> (Color, Value) of its node"""

    program: Program
    values: dict[str, tuple]
    requests: frozenset[str]


def export_aovs(
    depsgraph, materials: list, users: list[list[str]], warnings: list[str], texel_cache=None
) -> AovExport:
    """All that the graph's view layer asks for.

    materials: evaluated, None is an empty slot; users: names of the objects that have each
    warnings: gets a line for each node that is not known
    """
    wanted = wanted_aovs(depsgraph.view_layer_eval)
    if not wanted:
        return no_aovs(materials)
    names, images = {aov.name for aov in wanted}, ImageStore(texel_cache)
    found = [
        _written(material, names, NodeReader(_name(material), who, warnings), images, depsgraph)
        for material, who in zip(materials, users, strict=True)
    ]
    cache = texel_cache or TexelCache()
    world = _written_by_world(depsgraph, names, warnings, images, cache)
    aovs = tuple(_aov(own, found, world) for own in wanted)
    none = frozenset()
    return AovExport(aovs, tuple(none if one is None else one.requests for one in found))


def no_aovs(materials: list) -> AovExport:
    """Nothing is asked for, as in a window."""
    return AovExport((), (frozenset(),) * len(materials))


def _name(material) -> str:
    return "" if material is None else material.name


def _aov(own, found: list[_Written | None], world: _Written | None) -> Aov:
    channels, socket = (4, 0) if own.type == "COLOR" else (1, 1)
    writes = [one is not None and own.name in one.values for one in found]
    both = list(zip(found, writes, strict=True))
    return Aov(
        aov_layer(own.name),
        channels,
        tuple(one.program if write else None for one, write in both),
        tuple(one.values[own.name][socket] if write else None for one, write in both),
        _of_world(world, own.name, socket),
    )


def _of_world(world: _Written | None, name: str, socket: int) -> WorldProgram | None:
    if world is None or name not in world.values:
        return None
    value = world.values[name][socket]
    return WorldProgram(program=world.program, value=value, strength=np.ones(3, np.float32))


def _written(material, names: set[str], reader, images, depsgraph) -> _Written | None:
    """None: the material has no node for any of the names."""
    seen = None if material is None else seen_tree(material)
    if seen is None:
        return None
    return _written_by(seen.tree, ProgramBuilder(reader, images, depsgraph), names)


def _written_by_world(depsgraph, names, warnings, images, cache) -> _Written | None:
    """The same of the world, as the camera sees it."""
    world = world_of(depsgraph)
    seen = None if world is None or not is_in_layer(depsgraph) else seen_tree(world)
    if seen is None:
        return None
    reader = WorldReader(world, warnings)
    builder = WorldBuilder(reader, images, depsgraph, CAMERA_RAYS, cache)
    return _written_by(seen.tree, builder, names)


def _written_by(tree, builder: ProgramBuilder, names: set[str]) -> _Written | None:
    values = {}
    for node, groups in _nodes_of(tree):
        if node.aov_name in names and node.aov_name not in values:
            own = builder.color(node, "Color", groups), builder.number(node, "Value", groups)
            values[node.aov_name] = own
    if not values:
        return None
    program = Program(ops=builder.ops, closures=())
    return _Written(program, values, frozenset(builder.requests))


def _nodes_of(tree, groups=()):
    """(AOV Output node, the group nodes that it lies in) of a tree and of the groups in it."""
    for node in tree.nodes:
        if node.mute:
            continue
        if node.bl_idname == "ShaderNodeOutputAOV":
            yield node, groups
        elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
            yield from _nodes_of(node.node_tree, (*groups, node))

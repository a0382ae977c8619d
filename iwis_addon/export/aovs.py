"""AOV Output nodes of materials: values that they write into passes of the view layer."""

from __future__ import annotations

from typing import NamedTuple

import bpy

from ...core.program import Aov, Program
from ..passes import aov_layer, wanted_aovs
from .node_values import NodeReader
from .program_builder import ProgramBuilder
from .program_images import ImageStore
from .world import world_of


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
    view_layer, materials: list, users: list[list[str]], warnings: list[str], texel_cache=None
) -> AovExport:
    """All that the layer asks for; None, in a window: nothing.

    materials: evaluated, None is an empty slot; users: names of the objects that have each
    warnings: gets a line for each node that is not known
    """
    wanted = [] if view_layer is None else wanted_aovs(view_layer)
    if not wanted:
        return AovExport((), (frozenset(),) * len(materials))
    names, images = {aov.name for aov in wanted}, ImageStore(texel_cache)
    found = [
        _written(material, names, NodeReader(_name(material), who, warnings), images)
        for material, who in zip(materials, users, strict=True)
    ]
    aovs = tuple(_aov(own, found) for own in wanted)
    none = frozenset()
    return AovExport(aovs, tuple(none if one is None else one.requests for one in found))


def tell_of_world(depsgraph, warnings: list[str]) -> None:
    """Add a line where the world has a node that writes what is asked for: it is not read."""
    world = world_of(depsgraph)
    names = {aov.name for aov in wanted_aovs(depsgraph.view_layer_eval)}
    if not names or world is None or world.node_tree is None:
        return
    for node, _ in _nodes_of(world.node_tree):
        if node.aov_name in names:
            told = "AOV Output is not supported in a world: nothing is written"
            warnings.append(f'world "{world.name}", node "{node.name}": {told}')


def _name(material) -> str:
    return "" if material is None else material.name


def _aov(own, found: list[_Written | None]) -> Aov:
    channels, socket = (4, 0) if own.type == "COLOR" else (1, 1)
    writes = [one is not None and own.name in one.values for one in found]
    both = list(zip(found, writes, strict=True))
    return Aov(
        aov_layer(own.name),
        channels,
        tuple(one.program if write else None for one, write in both),
        tuple(one.values[own.name][socket] if write else None for one, write in both),
    )


def _written(material, names: set[str], reader: NodeReader, images) -> _Written | None:
    """None: the material has no node for any of the names."""
    uses_nodes = material is not None and (bpy.app.version >= (5, 0) or material.use_nodes)
    if not uses_nodes or material.node_tree is None:
        return None
    builder, values = ProgramBuilder(reader, images), {}
    for node, groups in _nodes_of(material.node_tree):
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

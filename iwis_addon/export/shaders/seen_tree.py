"""The shader tree of a material, a world or a lamp, as the renderer gets it.

From Blender 5 on a tree may have zones that repeat, closures, bundles and menus. Blender resolves
them, groups too, and works out what is constant; Cycles is given what it comes to, and so is IWIS.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import bpy

_RESOLVED = re.compile(r"\d+_(.+)")  # Blender numbers the nodes of a resolved tree
_RESOLVED_TREE = " Inlined"


class SeenTree(NamedTuple):
    """nodes: of ``tree``, a bpy NodeTree, which lives as long as ``owner`` is held"""

    tree: object
    owner: object

    @property
    def output(self):
        """The output node that is active for Cycles, or None."""
        return self.tree.get_output_node("CYCLES")


def seen_tree(data) -> SeenTree | None:
    """The tree of a bpy Material, World or Light, evaluated or not; None: it has no nodes.

    Nodes of groups have lost their groups there: follow() never leaves the tree.
    """
    # Blender 5 always uses nodes and warns who asks.
    uses_nodes = bpy.app.version >= (5, 0) or data.use_nodes
    if not uses_nodes or data.node_tree is None:
        return None
    if not hasattr(data, "inline_shader_nodes"):
        return SeenTree(data.node_tree, data)
    resolved = data.inline_shader_nodes()
    return SeenTree(resolved.node_tree, resolved)


def name_of(node) -> str:
    """The name of a node in the user's tree."""
    numbered = _RESOLVED.fullmatch(node.name)
    if numbered and node.id_data.name.endswith(_RESOLVED_TREE):
        return numbered[1]
    return node.name

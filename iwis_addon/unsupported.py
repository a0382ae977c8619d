"""Which outputs of shader nodes IWIS does not render as Cycles does, by its own reader."""

from __future__ import annotations

from typing import NamedTuple

from .export.shaders.node_values import NodeReader
from .export.shaders.program_builder import ProgramBuilder
from .export.shaders.program_images import ImageStore
from .export.shaders.seen_tree import seen_tree
from .export.shaders.shader_reader import ShaderReader

_TYPES = ("RGBA", "VALUE", "INT", "BOOLEAN", "VECTOR")
# What a picture cannot stand for: it is one itself, or its value is that of the ray.
_LEFT = ("ShaderNodeTexImage", "ShaderNodeLightPath", "ShaderNodeCameraData")


class Unsupported(NamedTuple):
    """An output of a node that feeds something. groups: the group nodes it lies in, () = none"""

    material: object
    node: object
    output: str
    groups: tuple


class _Reader(NodeReader):
    """Notes the nodes that it is asked to warn of."""

    def __init__(self, name):
        super().__init__(name, [], [])
        self.warned: set[int] = set()

    def warn(self, node, text: str) -> None:
        if node is not None:
            self.warned.add(node.as_pointer())


class _Builder(ProgramBuilder):
    """Notes the ends of links behind which there is no value, and all others."""

    def __init__(self, reader):
        super().__init__(reader, ImageStore(None))
        self.met, self.missing = [], []

    def _output(self, end):
        value, source = super()._output(end)
        (self.missing if value is None else self.met).append(end)
        return value, source


def unsupported_of(material) -> list[Unsupported]:
    """Each output once, in the order in which the export meets them, in the user's own tree: where
    something of what it comes to is not known, zones and menus are not either."""
    seen = None if material is None else seen_tree(material)
    if seen is None or seen.output is None or not _unread(material, seen.output):
        return []
    return _unread(material, material.node_tree.get_output_node("CYCLES"))


def _unread(material, output) -> list[Unsupported]:
    """Those of one tree. output: its Material Output"""
    reader = _Reader(material.name)
    builder = _Builder(reader)
    ShaderReader(builder).read(output.inputs["Surface"])
    ends = [end for end in builder.met if end.node.as_pointer() in reader.warned]
    found = {}
    for end in (*builder.missing, *ends):
        if end.socket.type in _TYPES and end.node.bl_idname not in _LEFT:
            key = end.node.as_pointer(), end.socket.identifier
            one = Unsupported(material, end.node, end.socket.identifier, end.groups)
            found.setdefault(key, one)
    return list(found.values())

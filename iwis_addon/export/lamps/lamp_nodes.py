"""What a light's own nodes multiply its strength by: a colour, or what varies over the lamp."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.data.program import Program, Value
from ..objects.object_properties import TABLES, Asked, blocks_of, outputs_of
from ..shaders.node_values import NodeReader, follow
from ..shaders.program_builder import ProgramBuilder

_OF_NORMALS = {"outputs": {"Normal"}}
_WHITE = np.ones(3, np.float32)


class LampLight(NamedTuple):
    """A colour of a program, as Program has them."""

    program: Program
    value: Value


class LampReader(NodeReader):
    """The warnings of one light."""

    def __init__(self, object_name: str, light_name: str, warnings: list[str]):
        super().__init__("", [], warnings)
        self.object_name = object_name
        self._where = f'object "{object_name}", light "{light_name}"'


class _LampBuilder(ProgramBuilder):
    """The operations of one light's tree.

    asked, layer: whose properties an Attribute node reads, as for object_properties.blocks_of
    """

    of_instances = False

    def __init__(self, reader, images, asked: Asked, layer: tuple):
        super().__init__(reader, images, layer[1])
        self._asked, self._layer = asked, layer

    def _made(self, node, groups):
        """See ProgramBuilder."""
        if node.bl_idname == "ShaderNodeAttribute" and node.attribute_type in TABLES:
            blocks = blocks_of(TABLES[node.attribute_type], self._asked, self._layer)
            return outputs_of(blocks, node.attribute_name)
        return super()._made(node, groups)

    def outwards(self):
        """See ProgramBuilder."""
        return self.run_at_points("ShaderNodeTexCoord", "Normal", settings=_OF_NORMALS)[0]


def read_light(tree, reader: LampReader, images, asked: Asked, layer: tuple) -> LampLight | None:
    """What a tree's Light Output gets; None: it is dark.

    images: an ImageStore; asked, layer: as for read_lamp
    """
    output = next((n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputLight"), None)
    end = None if output is None else follow(output.inputs["Surface"])
    if end is None or end.node is None:
        reader.warn(output, "nothing is linked to the Surface of the Light Output: it is dark")
        return None
    builder = _LampBuilder(reader, images, asked, layer)
    if end.node.bl_idname != "ShaderNodeEmission":
        reader.warn(end.node, "only Emission is supported in a light: it shines as without nodes")
        return LampLight(Program(ops=(), closures=()), _WHITE)
    color = builder.color(end.node, "Color", end.groups)
    value = builder.scaled(color, builder.number(end.node, "Strength", end.groups))
    return LampLight(Program(ops=builder.ops, closures=()), value)

"""Nodes of a world's tree to operations over directions, as Cycles evaluates them there.

Most nodes are those of materials (program_nodes.py). Others a world answers otherwise: its point is
the direction, its normal looks back along it, it has no surface, object or UV map.
"""

from __future__ import annotations

import numpy as np

from ....core.data.program import Op, Ref
from ....core.nodes.falloff import LIGHT_FALLOFF
from ....core.nodes.world import DIRECTION, ENVIRONMENT
from ....core.scene import EnvironmentMap
from ..shaders.program_builder import ProgramBuilder
from ..shaders.seen_tree import name_of
from . import world_coordinates, world_textures
from .world_coordinates import constants

_GRAY = np.float32([0.5, 0.5, 0.5])
# Constant outputs, as measured in Cycles; what is not named is 0.
_CONSTANT = {
    "ShaderNodeObjectInfo": {},
    "ShaderNodeUVMap": {},
    "ShaderNodeVertexColor": {},
    "ShaderNodeHairInfo": {},
    "ShaderNodeParticleInfo": {},
    "ShaderNodePointInfo": {},
    "ShaderNodeWireframe": {},
}
_NORMALS = ("ShaderNodeBump", "ShaderNodeNormalMap", "ShaderNodeBevel")


class WorldReader:
    """The warnings of one world, as program_builder asks for a reader."""

    def __init__(self, world, warnings: list[str]):
        self.name, self._warnings = world.name, warnings

    def warn(self, node, text: str) -> None:
        """Add a warning that names the world and the node (None: no node), once."""
        where = "" if node is None else f', node "{name_of(node)}"'
        line = f'world "{self.name}"{where}: {text}'
        if line not in self._warnings:
            self._warnings.append(line)


class WorldBuilder(ProgramBuilder):
    """The operations of one world for one kind of rays.

    rays: CAMERA_RAYS or LIGHT_RAYS; cache: the job's TexelCache
    camera: the scene's; layer: data-blocks of which an Attribute node reads properties
    asks_for_rays: whether a Light Path node has been met
    """

    def __init__(self, reader: WorldReader, images, depsgraph, rays, cache):
        super().__init__(reader, images, depsgraph)
        self.asks_for_rays = False
        scene = getattr(depsgraph, "scene_eval", depsgraph)
        layer = getattr(depsgraph, "view_layer_eval", None)
        # Where Attribute nodes look, first things first.
        self.layer = [block for block in (layer, scene, scene.world) if block is not None]
        self.camera = scene.camera
        self.rays, self.cache = rays, cache
        self._textures: dict[tuple, int] = {}

    def direction(self, output: str = "") -> Ref:
        """The direction, or the "Normal" that looks back along it."""
        if DIRECTION not in self._textures:
            self._textures[DIRECTION] = self.add(Op(DIRECTION, {}, {}))
        return Ref(self._textures[DIRECTION], output)

    def outwards(self) -> Ref:
        """See ProgramBuilder."""
        return self.direction("Normal")

    def add(self, op: Op) -> int:
        """The row of a new operation."""
        return self.add_node(None, (), *op)

    def transformed(self, vector, matrix) -> Ref:
        """A vector through a matrix (3, 4)."""
        settings = {"matrix": np.ascontiguousarray(matrix, np.float32)}
        return self.run("world_transform", Vector=vector, settings=settings)

    def texture(self, environment: EnvironmentMap, inputs) -> int:
        """The row of an Environment Texture; the same one for the same picture and directions."""
        key = id(environment.radiance), environment.projection, environment.interpolation
        key += environment.world_to_map.tobytes(), repr(inputs)
        if key not in self._textures:
            self._textures[key] = self.add(Op(ENVIRONMENT, inputs, {"map": environment}))
        return self._textures[key]

    def made_as_in_materials(self, node, groups):
        """What ProgramBuilder makes of a node."""
        return super()._made(node, groups)

    def _made(self, node, groups):
        """See ProgramBuilder."""
        kind = node.bl_idname
        if kind in _HANDLERS:
            return _HANDLERS[kind](self, node, groups)
        if kind in _CONSTANT:
            return constants(node, _CONSTANT[kind])
        if kind in _NORMALS:
            self.reader.warn(node, "a world has no surface: its normal, which looks back")
            return {socket.identifier: self.direction("Normal") for socket in node.outputs}
        made = self.made_as_in_materials(node, groups)
        return _grey(self, node) if made is None else made


def _grey(builder, node):
    """A node that is not supported."""
    builder.reader.warn(node, f"{node.bl_label} is not supported: one colour, (0.5, 0.5, 0.5)")
    return {s.identifier: np.float32(0.5) if s.type == "VALUE" else _GRAY for s in node.outputs}


def _ambient_occlusion(builder, node, groups):
    """Nothing is near a world."""
    return constants(node, {"AO": 1.0}) | {"Color": builder.color(node, "Color", groups)}


def _light_falloff(builder, node, groups):
    """From infinitely far light comes as it is, in Cycles too (measured)."""
    strength = builder.number(node, "Strength", groups)
    return {socket.identifier: strength for socket in node.outputs}


def _mix(builder, node, groups):
    """A Mix of a constant factor that shows one of its inputs alone is that one."""
    old = node.bl_idname == "ShaderNodeMixRGB"
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}
    kind = "Color" if old else kind.get(node.data_type)
    uneven = kind == "Vector" and node.factor_mode == "NON_UNIFORM"
    clamps = node.use_clamp if old else kind == "Color" and node.clamp_result
    if kind is not None and not uneven and not clamps:
        names = ("Fac", "Color1", "Color2") if old else ("Factor_Float", f"A_{kind}", f"B_{kind}")
        factor, a, b = (next(s for s in node.inputs if s.identifier == name) for name in names)
        factor = builder.behind(factor, groups, "NUMBER")
        plain = kind != "Color" or node.blend_type == "MIX"
        if not isinstance(factor, Ref) and (factor == 0.0 or (factor == 1.0 and plain)):
            target = {"Float": "NUMBER", "Vector": "VECTOR", "Color": "COLOR"}[kind]
            value = builder.behind(a if factor == 0.0 else b, groups, target)
            return {socket.identifier: value for socket in node.outputs}
    return builder.made_as_in_materials(node, groups)


_HANDLERS = {
    **world_coordinates.HANDLERS,
    **world_textures.HANDLERS,
    "ShaderNodeAmbientOcclusion": _ambient_occlusion,
    LIGHT_FALLOFF: _light_falloff,
    "ShaderNodeMix": _mix,
    "ShaderNodeMixRGB": _mix,
}

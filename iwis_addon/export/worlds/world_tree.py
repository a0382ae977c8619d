"""A world's shaders to one program for its radiance, and to a factor where that is constant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.data.program import Program, Ref, Value
from ..shaders.node_values import follow
from .world_builder import WorldBuilder

_BLACK, _WHITE = np.zeros(3, np.float32), np.ones(3, np.float32)
_EMITTERS = ("ShaderNodeBackground", "ShaderNodeEmission")


class WorldTree(NamedTuple):
    """The radiance of all directions: value, a colour, times strength, float32 (3,)."""

    program: Program
    value: Value
    strength: np.ndarray


class _Glow(NamedTuple):
    """One Background: what of it is mixed in, its colour and its strength."""

    weight: Value
    color: Value
    strength: Value


def read_tree(output, builder: WorldBuilder) -> WorldTree:
    """The tree behind a World Output node."""
    found: list[_Glow] = []
    _read(output.inputs["Surface"], (), _WHITE, builder, found)
    if len(found) == 1 and not any(isinstance(v, Ref) for v in found[0][::2]):
        value, strength = found[0].color, found[0].weight * found[0].strength
    else:
        value, strength = builder.added([_whole(glow, builder) for glow in found]), _WHITE
    program = Program(ops=builder.ops, closures=())
    return WorldTree(program, _BLACK if value is None else value, np.float32(strength))


def _whole(glow: _Glow, builder) -> Value:
    color = builder.scaled(glow.color, glow.strength)
    return builder.run("product", A=glow.weight, B=color)


def _read(socket, groups, weight, builder, found):
    """Add the lights behind a shader socket, times a colour."""
    end = follow(socket, groups)
    if end.node is None or (not isinstance(weight, Ref) and not weight.any()):
        return
    node, kind = end.node, end.node.bl_idname
    if end.socket.type != "SHADER":  # a colour at a shader's place glows, as in Cycles
        found.append(_Glow(weight, builder.behind(socket, groups, "COLOR"), np.float32(1.0)))
    elif kind in _EMITTERS:
        color = builder.behind(node.inputs["Color"], end.groups, "COLOR")
        strength = builder.behind(node.inputs["Strength"], end.groups, "NUMBER")
        found.append(_Glow(weight, color, strength))
    elif kind == "ShaderNodeAddShader":
        for inner in node.inputs:
            _read(inner, end.groups, weight, builder, found)
    elif kind == "ShaderNodeMixShader":
        factor = builder.behind(node.inputs[0], end.groups, "NUMBER")
        for second, inner in enumerate(node.inputs[1:]):
            share = {"settings": {"second": bool(second)}}
            share = builder.run("weigh", Weight=weight, Factor=factor, **share)
            _read(inner, end.groups, share, builder, found)
    else:
        builder.reader.warn(node, f"{node.bl_label} gives no light in a world, as in Cycles")

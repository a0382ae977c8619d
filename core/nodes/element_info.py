"""Nodes that tell of strands, points and particles: Curves Info, Point Info, Particle Info.

Elsewhere all is 0.
"""

from __future__ import annotations

import numpy as np

from ..data.rows import any_in_row
from .hashing import hash_words
from .values import column, dot, length, normalized

_OF_ONE_AXIS = np.float32(3.0**-0.5)


def element_number(context, name: str) -> np.ndarray:
    """float32 (n,): a number of points, strands or a mesh; 0 where it has none of the name."""
    value = context.attribute(f"element:{name}")
    return np.zeros(len(context), np.float32) if value is None else value[:, 0]


def _size(context, name):
    """A size in the object's space, in the world's."""
    size = column(element_number(context, name) * _OF_ONE_AXIS)
    return length(context.vector_to_world(np.repeat(size, 3, -1)))


def _tangent_normal(context):
    """Towards the viewer, at right angles to the strand."""
    tangent = context.attribute("element:Tangent")
    if tangent is None:
        return np.zeros((len(context), 3), np.float32)
    tangent = normalized(context.vector_to_world(tangent))
    normal = normalized(context.wo - tangent * column(dot(tangent, context.wo)))
    return np.where(any_in_row(tangent)[:, None], normal, np.float32(0.0))


def _point_position(context):
    place = context.attribute("element:Position")
    if place is None:
        return np.zeros((len(context), 3), np.float32)
    origin = context.surface.object_to_world[context.object][:, :3, 3].astype(np.float32)
    there = column(element_number(context, "Radius")) > 0.0
    return np.where(there, context.vector_to_world(place) + origin, np.float32(0.0))


def curves_info(context, settings, inputs):
    """settings: outputs, those that are used"""
    values = {
        "Is Strand": lambda: element_number(context, "Is Strand"),
        "Intercept": lambda: element_number(context, "Intercept"),
        "Length": lambda: element_number(context, "Length"),
        "Thickness": lambda: _size(context, "Thickness"),
        "Tangent Normal": lambda: _tangent_normal(context),
        "Random": lambda: element_number(context, "Random"),
    }
    return {name: values[name]() for name in settings["outputs"]}


def point_info(context, settings, inputs):
    """settings: outputs, those that are used"""
    values = {
        "Position": lambda: _point_position(context),
        "Radius": lambda: _size(context, "Radius"),
        "Random": lambda: element_number(context, "Random"),
    }
    return {name: values[name]() for name in settings["outputs"]}


def particle_info(context, settings, inputs):
    """Of the particle that an instance stands for. settings: outputs, those that are used"""
    return {name: _of_particle(context, name) for name in settings["outputs"]}


def _of_particle(context, name):
    if name == "Random":
        index = context.of_object("origin:Index")[:, 0].astype(np.uint32)
        return hash_words(index, np.zeros_like(index)).astype(np.float32) / np.float32(0xFFFFFFFF)
    values = context.of_object(f"origin:{name}")
    return values[:, :3] if name in ("Location", "Velocity", "Angular Velocity") else values[:, 0]


FUNCTIONS = {
    "ShaderNodeHairInfo": curves_info,
    "ShaderNodePointInfo": point_info,
    "ShaderNodeParticleInfo": particle_info,
}

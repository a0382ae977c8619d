"""Nodes that turn the normal, and those that depend on the angle to it.

A function takes the context, the node's settings and its inputs (program.Op), and returns its
outputs by name. Each reproduces the Cycles node of its name.
"""

from __future__ import annotations

import numpy as np

from ..data.rows import any_in_row
from .values import as_number, as_vector, column, dot, length, normalized, parts


def normal_map(context, settings, inputs):
    """settings: space, table (name of the tangents at the corners, width 4: sign last), downward:
    whether green is along -y, original: whether what is displaced has the map on its shape before,
    follows: whether tangents are of its shape now, unit: whether normals are, between corners,
    before they are turned
    """
    n = len(context)
    color = 2.0 * as_vector(inputs["Color"], n) - 1.0
    if settings["downward"]:
        color = color * np.float32([1.0, -1.0, 1.0])
    given = as_number(inputs["Strength"], n)
    strength = np.maximum(given, 0.0)
    back = context.backfacing[:, None] > 0.0
    if settings["space"] == "TANGENT":
        table = context.attribute(settings["table"])
        if table is None:
            return {"Normal": context.normal}
        moved = _moved_tangents(context, table) if settings["follows"] else table
        own = normalized(context.object_normal) if settings["unit"] else context.object_normal
        turned = _about_tangents(context, own, moved, color, given)
        front = np.where(back, -context.normal, context.normal)
        if settings["original"] and context.rest is not None:
            before = context.at_rest().object_normal  # unit or not: there is no other in 5.2
            before = _about_tangents(context, before, table, color, np.ones_like(strength))
            before = normalized(front + (before - front) * column(strength))
            turned = np.where(context.rest.smooth[context.triangle][:, None], before, turned)
        turned = np.where(any_in_row(table[:, :3])[:, None], turned, front)
        return {"Normal": _or(np.where(back, -turned, turned), context.normal)}
    if settings["space"].startswith("BLENDER"):
        color = color * np.float32([1.0, -1.0, -1.0])
    in_object = settings["space"] in ("OBJECT", "BLENDER_OBJECT")
    turned = context.normal_to_world(color) if in_object else normalized(color)
    turned = np.where(back, -turned, turned)
    stretched = normalized(context.normal + (turned - context.normal) * column(strength))
    turned = np.where(column(strength) == 1.0, turned, stretched)
    return {"Normal": _or(turned, context.normal)}


def _moved_tangents(context, table):
    """Tangents, float32 (n, 4), of what was displaced, where it is now: they go along with the
    faces."""
    if context.rest is None:
        return table
    before, own = context.at_rest(), context.object_normal
    along = before.vector_to_world(table[:, :3])
    u, v = (before.moved(along).barycentric - before.barycentric).T
    a, b, c = context.corners.transpose(1, 0, 2)
    along = context.vector_to_object(column(u) * (b - a) + column(v) * (c - a))
    along = normalized(along - column(dot(along, own) / np.maximum(dot(own, own), 1e-20)) * own)
    smooth = column(context.rest.smooth[context.triangle])
    return np.where(smooth > 0.0, np.concatenate([along, table[:, 3:]], -1), table)


def _about_tangents(context, own, table, color, strength):
    """The map's normal, of the mesh's front. Strength flattens the map itself, or makes it steeper,
    before it is made unit: in the other spaces it mixes two unit normals. Below 0 it is turned."""
    tangent = table[:, :3]
    across = column(np.sign(table[:, 3])) * np.cross(own, tangent)
    x, y, z = parts(color)
    z = 1.0 + (z - 1.0) * np.clip(strength, 0.0, 1.0)
    turned = column(x * strength) * tangent + column(y * strength) * across + column(z) * own
    return context.normal_to_world(turned)


def _or(normal, otherwise):
    return np.where(any_in_row(normal)[:, None], normal, otherwise)


def bump(context, settings, inputs):
    """settings: invert; heights is the sub-program's value (here, along x, along y)."""
    n = len(context)
    here, along_x, along_y, (step_x, step_y) = settings["heights"]
    width = as_number(inputs.get("Filter Width", np.float32(0.1)), n)
    normal = as_vector(inputs.get("Normal", context.normal), n)
    if context.now is not None:  # in the object's space, as in Cycles
        normal = context.normal_to_object(normal)
        step_x, step_y = (context.vector_to_object(step) for step in (step_x, step_y))
    cross_x, cross_y = np.cross(step_y, normal), np.cross(normal, step_x)
    determinant = dot(step_x, cross_x)
    slope = column(along_x - here) * cross_x + column(along_y - here) * cross_y
    distance = as_number(inputs["Distance"], n) * (-1.0 if settings["invert"] else 1.0)
    turned = normalized(
        column(np.abs(determinant)) * normal - column(distance * np.sign(determinant)) * slope
    )
    strength = column(np.maximum(as_number(inputs["Strength"], n), 0.0))
    turned = normalized(strength * _or(turned, normal) + (1.0 - strength) * normal)
    turned = np.where(column(width) > 0.0, turned, normal)
    return {"Normal": turned if context.now is None else context.normal_to_world(turned)}


def object_height(context, settings, inputs):
    """A height along the normal in the object's space, in the world's."""
    along = context.vector_to_world(context.normal_to_object(context.normal))
    return {"": inputs["Size"] * length(along)}


def displacement(context, settings, inputs):
    """settings: space, OBJECT or WORLD"""
    n = len(context)
    along = as_vector(inputs.get("Normal", context.normal), n)
    if settings["space"] == "OBJECT":
        along = context.vector_to_world(context.normal_to_object(along))
    height = (inputs["Height"] - inputs["Midlevel"]) * inputs["Scale"]
    return {"Displacement": along * column(as_number(height, n))}


def vector_displacement(context, settings, inputs):
    """settings: space, TANGENT, OBJECT or WORLD; table (name of the tangents at the corners)"""
    n = len(context)
    offset = as_vector(inputs["Vector"] - column(inputs["Midlevel"]), n)
    offset = offset * column(as_number(inputs["Scale"], n))
    if settings["space"] == "WORLD":
        return {"Displacement": offset}
    if settings["space"] == "TANGENT":
        x, y, z = parts(offset)
        # A bump's heights all have the tangents of its middle, as in Cycles.
        table = (context.unmoved or context).attribute(settings["table"])
        own = context.normal_to_object(context.normal)
        offset = column(y) * own
        if table is not None:
            across = column(np.sign(table[:, 3])) * normalized(np.cross(own, table[:, :3]))
            offset = offset + column(x) * table[:, :3] + column(z) * across
    return {"Displacement": context.vector_to_world(offset)}


def _dielectric(cosine, eta):
    """Fresnel's reflectance of an index eta, 1 where all is reflected."""
    c = np.abs(cosine)
    g = eta * eta - 1.0 + c * c
    root = np.sqrt(np.maximum(g, 0.0))
    a = (root - c) / (root + c)
    b = (c * (root + c) - 1.0) / (c * (root - c) + 1.0)
    return np.where(g > 0.0, 0.5 * a * a * (1.0 + b * b), 1.0)


def fresnel(context, settings, inputs):
    normal = inputs.get("Normal", context.normal)
    eta = np.maximum(inputs["IOR"], np.float32(1e-5))
    eta = np.where(context.backfacing > 0.0, 1.0 / eta, eta)
    return {"Fac": _dielectric(dot(context.wo, normal), eta)}


def layer_weight(context, settings, inputs):
    normal, blend = inputs.get("Normal", context.normal), inputs["Blend"]
    cosine = dot(context.wo, normal)
    eta = np.maximum(1.0 - blend, np.float32(1e-5))
    eta = np.where(context.backfacing > 0.0, eta, 1.0 / eta)
    facing = np.abs(cosine)
    limited = np.clip(blend, 0.0, np.float32(1.0 - 1e-5))
    power = np.where(limited < 0.5, 2.0 * limited, 0.5 / (1.0 - limited))
    bent = np.power(facing, power)
    facing = np.where(limited != 0.5, bent, facing)
    return {"Fresnel": _dielectric(cosine, eta), "Facing": 1.0 - facing}


def normal(context, settings, inputs):
    """settings: direction float32 (3,), unit"""
    return {
        "Normal": settings["direction"],
        "Dot": dot(settings["direction"], normalized(inputs["Normal"])),
    }


FUNCTIONS = {
    "ShaderNodeNormalMap": normal_map,
    "ShaderNodeBump": bump,
    "object_height": object_height,
    "ShaderNodeDisplacement": displacement,
    "ShaderNodeVectorDisplacement": vector_displacement,
    "ShaderNodeFresnel": fresnel,
    "ShaderNodeLayerWeight": layer_weight,
    "ShaderNodeNormal": normal,
}

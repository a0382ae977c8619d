"""Random attributes of meshes, of all domains and types, and what materials read of them."""

from __future__ import annotations

import numpy as np

from .dice import Dice

_DOMAINS = "POINT", "EDGE", "FACE", "CORNER"
_TYPES = "FLOAT", "INT", "BOOLEAN", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR", "FLOAT2"
_SIZES = {"FLOAT_VECTOR": 3, "FLOAT_COLOR": 4, "BYTE_COLOR": 4, "FLOAT2": 2}
_FIELDS = {"FLOAT_VECTOR": "vector", "FLOAT_COLOR": "color", "BYTE_COLOR": "color"}
NAME, UV = "Own", "Second"


def add_attributes(dice: Dice, mesh) -> None:
    """Give a mesh an attribute, and a second UV map."""
    domain, kind = dice.of(*_DOMAINS), dice.of(*_TYPES)
    own = mesh.attributes.new(NAME, kind, domain)
    n = len(own.data) * _SIZES.get(kind, 1)
    values = np.arange(n) * 7 % 11 / 10.0
    if kind in ("INT", "BOOLEAN"):
        whole = np.int32 if kind == "INT" else np.bool_
        own.data.foreach_set("value", (np.arange(n) % 2).astype(whole))
    else:
        own.data.foreach_set(_FIELDS.get(kind, "value" if kind == "FLOAT" else "vector"), values)
    dice.tell(f"attribute {kind.lower()} of {domain.lower()}")
    first = mesh.uv_layers.active
    if first is None:
        return
    places = np.empty(2 * len(mesh.loops), np.float32)
    first.uv.foreach_get("vector", places)
    places = places.reshape(-1, 2)[:, ::-1] * np.float32(1.7) + np.float32(0.2)
    mesh.uv_layers.new(name=UV).uv.foreach_set("vector", np.ascontiguousarray(places).ravel())
    mesh.uv_layers.active = mesh.uv_layers[first.name]


def read_number(dice: Dice, tree):
    """A number from 0 to 1 of an attribute, by any output."""
    kind = "INSTANCER" if dice.chance(0.1) else "GEOMETRY"
    output = dice.of("Fac", "Color", "Vector", "Alpha")
    return tree.made("ShaderNodeAttribute", output, attribute_name=NAME, attribute_type=kind)


def read_place(dice: Dice, tree):
    """A place by UV map, or by attribute."""
    if dice.chance(0.5):
        return tree.made("ShaderNodeUVMap", 0, uv_map=dice.of(UV, "UVMap", ""))
    return tree.made("ShaderNodeAttribute", "Vector", attribute_name=dice.of(UV, NAME))

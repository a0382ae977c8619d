"""Hair curves, and curves that geometry nodes make: strands."""

from __future__ import annotations

import bpy
import numpy as np

from .element_values import (
    attribute_of,
    attribute_values,
    read_values,
)
from .strand_tubes import Strands

_RADIUS = 0.005  # metres, where curves have none
_ROOT_UV = "surface_uv_coordinate"
_POLY = 1  # of the attribute curve_type


class CurveValues:
    """What materials ask of bpy curves beside their shape; read while the graph lives."""

    def __init__(self, data, strands: Strands):
        self._data, self._strands = data, strands

    def __call__(self, name: str):
        """As StrandSource's own."""
        kind, _, rest = name.partition(":")
        if kind == "uv":
            return self._read(rest or _ROOT_UV, "FLOAT2")
        return self._read(rest) if kind in ("attribute", "color") and rest else None

    def _read(self, name, kind=None):
        attribute = attribute_of(self._data, name, kind)
        if attribute is None:
            return None
        return attribute_values(attribute), attribute.domain == "POINT"


def curve_strands(data) -> Strands:
    """Of evaluated bpy curves."""
    first = np.zeros(1, np.int64)
    if len(data.points) == 0:
        return Strands(np.empty((0, 4), np.float32), first)
    first = read_values(data.curve_offset_data, "value", 1, np.int32)[:, 0].astype(np.int64)
    keys = np.empty((len(data.points), 4), np.float32)
    keys[:, :3] = read_values(data.attributes["position"].data, "vector", 3, np.float32)
    radius = attribute_of(data, "radius", "FLOAT", "POINT")
    keys[:, 3] = _RADIUS if radius is None else attribute_values(radius)[:, 0]
    return Strands(keys, first)


def are_polylines(data) -> bool:
    """Whether Cycles draws evaluated bpy curves as straight pieces, whatever the scene's curve
    shape: where the first one's type is Poly, from Blender 5 on."""
    kinds = attribute_of(data, "curve_type", "INT8", "CURVE")
    poly = kinds is not None and len(kinds.data) > 0 and kinds.data[0].value == _POLY
    return poly and bpy.app.version >= (5, 0)


def curve_slots(data) -> np.ndarray | None:
    """int32: the material slot of each curve; None where all are 0."""
    slots = attribute_of(data, "material_index", "INT", "CURVE")
    if slots is None:
        return None
    slots = np.maximum(attribute_values(slots)[:, 0], 0.0).astype(np.int32)
    return slots if slots.any() else None

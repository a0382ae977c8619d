"""Nodes that ask what is around a point (core/surfaces/near_rays.py): Ambient Occlusion, Bevel.

Where nobody can answer nothing is near: for shadow rays, and where a surface's light is looked up,
as in Cycles; for what stands for a material as a whole.
"""

from __future__ import annotations

import numpy as np

from ..data.rows import any_in_row
from .values import as_number, as_vector, column, normalized


def ambient_occlusion(context, settings, inputs):
    """settings: samples; inside; only_local; everywhere, as far as the world says"""
    near, n = context.near, len(context)
    if near is None:
        return {"AO": np.float32(1.0), "Color": inputs["Color"]}
    normal = normalized(as_vector(inputs.get("Normal", context.normal), n))
    reach = near.rays.distance if settings["everywhere"] else inputs["Distance"]
    side = np.float32(-1.0 if settings["inside"] else 1.0)
    own = settings["samples"], settings["only_local"]
    share = near.open_share(side * normal, as_number(reach, n), *own)
    return {"AO": share, "Color": column(share) * inputs["Color"]}


def bevel(context, settings, inputs):
    """settings: samples"""
    near, n = context.near, len(context)
    own = normal = as_vector(inputs.get("Surface", context.normal), n)
    if near is not None:
        found = near.rounded_normal(as_number(inputs["Radius"], n), settings["samples"])
        found = np.where(column(context.backfacing) > 0.0, -found, found)
        normal = np.where(any_in_row(found)[:, None], found, normal)
    if "Normal" in inputs:
        normal = normalized(as_vector(inputs["Normal"], n) + (normal - own))
    return {"Normal": normal}


FUNCTIONS = {
    "ShaderNodeAmbientOcclusion": ambient_occlusion,
    "ShaderNodeBevel": bevel,
}

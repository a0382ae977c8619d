"""Nodes that look up tables of light: black bodies, wavelengths, luminaires.

Handlers are as in program_nodes.py.
"""

from __future__ import annotations

import bpy
import mathutils
import numpy as np

from ....core.data.program import Ref
from ....core.nodes import FUNCTIONS
from ....core.nodes.ies import IES
from ..images.blackbody import blackbody_color, blackbody_settings
from ..images.ies import IesError, read_ies


def _blackbody(builder, node, groups):
    settings, inputs = blackbody_settings(), builder.inputs(node, groups)
    if isinstance(inputs["Temperature"], Ref):
        return builder.add_node(node, groups, node.bl_idname, inputs, settings)
    return {"Color": np.float32(blackbody_color(inputs["Temperature"]))}


def _wavelength(builder, node, groups):
    """In the working space of the file, as Blender converts to it."""
    columns = [mathutils.Color(axis).from_xyz_d65_to_scene_linear() for axis in np.eye(3)]
    settings = {"to_rgb": np.array(columns, np.float32).T}
    inputs = builder.inputs(node, groups)
    if isinstance(inputs["Wavelength"], Ref):
        return builder.add_node(node, groups, node.bl_idname, inputs, settings)
    number = {"Wavelength": np.reshape(inputs["Wavelength"], 1)}
    return {"Color": FUNCTIONS[node.bl_idname](None, settings, number)["Color"][0]}


def _ies(builder, node, groups):
    """A luminaire's table, by direction."""
    strength = builder.number(node, "Strength", groups)
    try:
        settings = read_ies(node) | {"dark_ends": bpy.app.version < (5, 0)}
    except IesError as error:
        builder.reader.warn(node, f"IES file: {error}; it shines as without it")
        return {output.identifier: strength for output in node.outputs}
    vector = builder.vector_if_linked(node, "Vector", groups)
    if vector is None:
        vector = builder.outwards()
    row = builder.add_node(node, groups, IES, {"Vector": vector, "Strength": strength}, settings)
    return {output.identifier: Ref(row, "Fac") for output in node.outputs}


HANDLERS = {
    "ShaderNodeBlackbody": _blackbody,
    "ShaderNodeTexIES": _ies,
    "ShaderNodeWavelength": _wavelength,
}

"""Panels of a lamp that Blender shows to Cycles alone: an area's beam, its shadow, its nodes.

Type, colour, power and size are in EEVEE's panel, which IWIS joins (panels.py).
"""

from __future__ import annotations

from typing import ClassVar

import bpy
from bpy_extras.node_utils import find_node_input

from .job import ENGINE
from .panel_base import IWISPanel


class _LampPanel(IWISPanel):
    bl_context = "data"
    kinds: ClassVar[set[str]] = {"POINT", "SPOT", "SUN", "AREA"}

    @classmethod
    def poll(cls, context):
        light = getattr(context, "light", None)
        return context.engine == ENGINE and light is not None and light.type in cls.kinds


class IWIS_PT_lamp_beam(_LampPanel, bpy.types.Panel):
    bl_label = "Beam Shape"
    bl_parent_id = "DATA_PT_EEVEE_light"
    kinds: ClassVar[set[str]] = {"AREA"}

    def draw(self, context):
        self.split_layout().column().prop(context.light, "spread")


class IWIS_PT_lamp_settings(_LampPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column, light = self.split_layout().column(), context.light
        column.prop(light, "use_shadow", text="Cast Shadow")
        if not hasattr(light, "cycles"):  # the others are Cycles' own, as long as it is on
            return
        column.prop(light.cycles, "use_multiple_importance_sampling", text="Multiple Importance")
        if light.type == "AREA":
            column.prop(light.cycles, "is_portal", text="Portal")


class IWIS_PT_lamp_nodes(_LampPanel, bpy.types.Panel):
    bl_label = "Nodes"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, light = self.split_layout(), context.light
        if bpy.app.version < (5, 0) and not light.use_nodes:
            layout.prop(light, "use_nodes", icon="NODETREE")
            return
        tree = light.node_tree
        output = None if tree is None else tree.get_output_node("CYCLES")
        if output is None:
            layout.label(text="No output node")
            return
        layout.template_node_view(tree, output, find_node_input(output, "Surface"))


CLASSES = (IWIS_PT_lamp_beam, IWIS_PT_lamp_settings, IWIS_PT_lamp_nodes)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

"""Panels of the view layer: its passes and overrides."""

from __future__ import annotations

from typing import ClassVar

import bpy
from bl_ui.properties_view_layer import (
    ViewLayerAOVPanelHelper,
    ViewLayerLightgroupsPanelHelper,
)

from .panel_base import IWISPanel
from .passes import DENOISING_DATA, MATTES, TABLE


class _PassesPanel(IWISPanel):
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"
    group = ""

    def draw(self, context):
        column = self.split_layout().column()
        rows = [row for row in (*TABLE, *DENOISING_DATA) if row.flag and row.group == self.group]
        for row in {row.flag: row for row in rows}.values():
            owner = context.view_layer.iwis if row.owned else context.view_layer
            column.prop(owner, row.flag)


class IWIS_PT_passes_data(_PassesPanel, bpy.types.Panel):
    bl_label = "Data"
    group = "DATA"


class IWIS_PT_passes_light(_PassesPanel, bpy.types.Panel):
    bl_label = "Light"
    group = "LIGHT"


class IWIS_PT_passes_iwis(_PassesPanel, bpy.types.Panel):
    bl_label = "IWIS"
    group = "IWIS"


class IWIS_PT_passes_cryptomatte(IWISPanel, bpy.types.Panel):
    bl_label = "Cryptomatte"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context):
        column, layer = self.split_layout().column(), context.view_layer
        column.prop(layer, MATTES["Object"], text="Object")
        column.prop(layer, MATTES["Material"], text="Material")
        column.prop(layer, MATTES["Asset"], text="Asset")
        column = column.column()
        column.active = any(getattr(layer, flag) for flag in MATTES.values())
        column.prop(layer, "pass_cryptomatte_depth", text="Levels")


class IWIS_PT_passes_aov(IWISPanel, ViewLayerAOVPanelHelper, bpy.types.Panel):
    bl_label = "Shader AOV"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"


class IWIS_PT_passes_light_groups(IWISPanel, ViewLayerLightgroupsPanelHelper, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"


class IWIS_PT_layer_filter(IWISPanel, bpy.types.Panel):
    """What of the scene this view layer has"""

    bl_label = "Filter"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer"

    def draw(self, context):
        column, layer = self.split_layout().column(heading="Include"), context.view_layer
        column.prop(layer, "use_sky", text="Environment")
        column.prop(layer, "use_solid", text="Surfaces")
        column.prop(layer, "use_strand", text="Hair")
        if hasattr(layer, "use_motion_blur"):
            column = self.layout.column(heading="Use")
            column.active = context.scene.render.use_motion_blur
            column.prop(layer, "use_motion_blur", text="Motion Blur")


class IWIS_PT_layer_denoising(IWISPanel, bpy.types.Panel):
    """Whether this view layer is denoised, where the scene is"""

    bl_label = "Denoising"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer"

    def draw(self, context):
        layout = self.split_layout()
        layout.active = context.scene.iwis.denoise
        layout.prop(context.view_layer.iwis, "use_denoising")


class IWIS_PT_override(IWISPanel, bpy.types.Panel):
    bl_label = "Override"
    bl_context = "view_layer"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, layer = self.split_layout(), context.view_layer
        layout.prop(layer, "material_override")
        layout.prop(layer, "world_override")


CLASSES = (
    IWIS_PT_passes_data,
    IWIS_PT_passes_light,
    IWIS_PT_passes_cryptomatte,
    IWIS_PT_passes_iwis,
    IWIS_PT_passes_aov,
    IWIS_PT_passes_light_groups,
    IWIS_PT_layer_filter,
    IWIS_PT_layer_denoising,
    IWIS_PT_override,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

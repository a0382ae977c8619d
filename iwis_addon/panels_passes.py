"""Panels of the view layer's passes, and of what the world says to some of them."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .panel_base import IWISPanel
from .passes import MATTES, TABLE


class _PassesPanel(IWISPanel):
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"
    group = ""

    def draw(self, context):
        column = self.split_layout().column()
        for row in TABLE:
            if row.flag and row.group == self.group:
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


class _WorldPanel(IWISPanel):
    bl_context = "world"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.world is not None and super().poll(context)


class IWIS_PT_world_preview(_WorldPanel, bpy.types.Panel):
    bl_label = "Preview"

    def draw(self, context):
        self.layout.template_preview(context.scene.world)


class IWIS_PT_world_mist(_WorldPanel, bpy.types.Panel):
    bl_label = "Mist Pass"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.view_layer.use_pass_mist

    def draw(self, context):
        layout, mist = self.split_layout(), context.scene.world.mist_settings
        layout.prop(mist, "start")
        layout.prop(mist, "depth")
        layout.prop(mist, "falloff")


class IWIS_PT_world_occlusion(_WorldPanel, bpy.types.Panel):
    bl_label = "Ambient Occlusion Pass"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.view_layer.use_pass_ambient_occlusion

    def draw(self, context):
        self.split_layout().prop(context.scene.world.light_settings, "distance")


CLASSES = (
    IWIS_PT_world_preview,
    IWIS_PT_world_mist,
    IWIS_PT_world_occlusion,
    IWIS_PT_passes_data,
    IWIS_PT_passes_light,
    IWIS_PT_passes_cryptomatte,
    IWIS_PT_passes_iwis,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

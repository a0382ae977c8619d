"""Panels of the world beside its nodes: its preview, whether the camera sees it, some passes."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .panel_base import IWISPanel, draw_light_group


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


class IWIS_PT_world_visibility(_WorldPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"

    @classmethod
    def poll(cls, context):
        """The setting is Cycles' own, there as long as its add-on is enabled."""
        return super().poll(context) and hasattr(context.scene.world, "cycles_visibility")

    def draw(self, context):
        self.split_layout().prop(context.scene.world.cycles_visibility, "camera")


class IWIS_PT_world_light_group(_WorldPanel, bpy.types.Panel):
    bl_label = "Light Group"

    def draw(self, context):
        draw_light_group(self.split_layout(), context.scene.world, context.view_layer)


CLASSES = (
    IWIS_PT_world_preview,
    IWIS_PT_world_visibility,
    IWIS_PT_world_mist,
    IWIS_PT_world_occlusion,
    IWIS_PT_world_light_group,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

"""The panel Bake: Blender's own settings of a bake, as Cycles shows them, and IWIS' kinds."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .panel_base import IWISPanel

# Kinds that no direction of view changes, and those that are made of several parts.
_VIEWLESS = {"AO", "POSITION", "NORMAL", "UV", "ROUGHNESS", "ENVIRONMENT"}
_WITH_PARTS = {"NORMAL", "COMBINED", "DIFFUSE", "GLOSSY"}


class IWIS_PT_bake(IWISPanel, bpy.types.Panel):
    bl_label = "Bake"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 6

    def draw(self, context):
        layout, scene = self.split_layout(), context.scene
        kind = scene.iwis.bake_type
        layout.operator("object.bake", icon="RENDER_STILL").type = kind
        layout.prop(scene.iwis, "bake_type")
        if kind not in _VIEWLESS:
            row = layout.row()
            row.active = scene.camera is not None
            row.prop(scene.render.bake, "view_from")


class IWIS_PT_bake_influence(IWISPanel, bpy.types.Panel):
    bl_label = "Influence"
    bl_parent_id = "IWIS_PT_bake"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.iwis.bake_type in _WITH_PARTS

    def draw(self, context):
        layout, bake = self.split_layout(), context.scene.render.bake
        kind = context.scene.iwis.bake_type
        if kind == "NORMAL":
            layout.prop(bake, "normal_space", text="Space")
            column = layout.column(align=True)
            for axis, text in (("r", "Swizzle R"), ("g", "G"), ("b", "B")):
                column.prop(bake, f"normal_{axis}", text=text)
            return
        column = layout.column(heading="Contributions", align=True)
        column.prop(bake, "use_pass_direct")
        if kind != "COMBINED":
            column.prop(bake, "use_pass_color")
            return
        lit = column.column(align=True)
        lit.active = bake.use_pass_direct
        lit.prop(bake, "use_pass_diffuse")
        lit.prop(bake, "use_pass_glossy")
        column.prop(bake, "use_pass_emit")


class IWIS_PT_bake_selected_to_active(IWISPanel, bpy.types.Panel):
    bl_label = "Selected to Active"
    bl_parent_id = "IWIS_PT_bake"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render.bake, "use_selected_to_active", text="")

    def draw(self, context):
        layout, bake = self.split_layout(), context.scene.render.bake
        layout.active = bake.use_selected_to_active
        layout.prop(bake, "use_cage", text="Cage")
        if bake.use_cage:
            layout.prop(bake, "cage_object")
        column = layout.column()
        column.active = not bake.use_cage or bake.cage_object is None
        column.prop(bake, "cage_extrusion", text="Extrusion")
        layout.prop(bake, "max_ray_distance")


class IWIS_PT_bake_output(IWISPanel, bpy.types.Panel):
    bl_label = "Output"
    bl_parent_id = "IWIS_PT_bake"

    def draw(self, context):
        layout, bake = self.split_layout(), context.scene.render.bake
        layout.prop(bake, "target")
        if bake.target != "IMAGE_TEXTURES":
            return
        layout.prop(bake, "use_clear", text="Clear Image")
        column = layout.column(align=True)
        kind = context.scene.iwis.bake_type
        # Normals in tangent space and places on the map cannot be those of a neighboring face.
        if kind != "UV" and not (kind == "NORMAL" and bake.normal_space == "TANGENT"):
            column.prop(bake, "margin_type", text="Margin")
        column.prop(bake, "margin", text="Margin Size")


CLASSES = (
    IWIS_PT_bake,
    IWIS_PT_bake_influence,
    IWIS_PT_bake_selected_to_active,
    IWIS_PT_bake_output,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

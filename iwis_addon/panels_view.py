"""Panels in the shading menu of the rendered view, as Cycles has them."""

from __future__ import annotations

import bpy

from .job import ENGINE


class _ShadingPanel:
    """Blender's own of these ask for its own engines."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_parent_id = "VIEW3D_PT_shading"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE and context.space_data.shading.type == "RENDERED"


class IWIS_VIEW3D_PT_shading_lighting(_ShadingPanel, bpy.types.Panel):
    bl_label = "Lighting"

    def draw(self, context):
        layout, shading = self.layout, context.space_data.shading
        column = layout.column()
        column.prop(shading, "use_scene_lights_render")
        column.prop(shading, "use_scene_world_render")
        if shading.use_scene_world_render:
            return
        split = layout.column().split(factor=0.9)
        row = split.column().row()
        row.scale_y = 0.6
        row.template_icon_view(shading, "studio_light", scale_popup=3)
        button = {"emboss": False, "text": "", "icon": "PREFERENCES"}
        split.column().operator("screen.userpref_show", **button).section = "LIGHTS"
        column = layout.split(factor=0.9).column()
        column.prop(shading, "studiolight_rotate_z", text="Rotation")
        column.prop(shading, "studiolight_intensity")
        column.prop(shading, "studiolight_background_alpha")


class IWIS_VIEW3D_PT_shading_render_pass(_ShadingPanel, bpy.types.Panel):
    bl_label = "Render Pass"

    def draw(self, context):
        self.layout.prop(context.space_data.shading.iwis, "render_pass", text="")


CLASSES = (IWIS_VIEW3D_PT_shading_lighting, IWIS_VIEW3D_PT_shading_render_pass)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

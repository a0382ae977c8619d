"""Panels of an object that Blender shows to Cycles alone: which rays see it, how it is shaded, and
whether it is blurred by its motion; and of its material beside the nodes."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .panel_base import IWISPanel, draw_light_group

_GEOMETRY = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD"}


def _makes_copies(obj) -> bool:
    return obj.instance_type == "COLLECTION" and obj.instance_collection is not None


class _ObjectPanel(IWISPanel):
    bl_context = "object"
    kinds: ClassVar[set[str]] = _GEOMETRY

    @classmethod
    def poll(cls, context):
        obj = context.object
        return super().poll(context) and obj is not None and cls.is_about(obj)

    @classmethod
    def is_about(cls, obj) -> bool:
        """Whether the panel says something of an object; copies have their instancer's flags."""
        return obj.type in cls.kinds or _makes_copies(obj)


class IWIS_PT_object_visibility(_ObjectPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_parent_id = "OBJECT_PT_visibility"
    kinds: ClassVar[set[str]] = {*_GEOMETRY, "LIGHT"}

    def draw(self, context):
        column, obj = self.split_layout().column(), context.object
        column.prop(obj, "visible_camera", text="Camera")
        if obj.type == "LIGHT":
            column.prop(obj, "visible_diffuse", text="Diffuse")
            column.prop(obj, "visible_glossy", text="Glossy")
            return
        column.prop(obj, "visible_shadow", text="Shadow")
        column.prop(obj, "is_shadow_catcher")


class IWIS_PT_object_culling(_ObjectPanel, bpy.types.Panel):
    bl_label = "Culling"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def is_about(cls, obj) -> bool:
        """The settings are Cycles' own; of copies those of what is copied count."""
        return hasattr(obj, "cycles") and obj.type in cls.kinds

    def draw(self, context):
        layout, scene = self.split_layout(), context.scene
        for kind in ("camera", "distance"):
            row = layout.row()
            row.active = scene.render.use_simplify and getattr(scene.cycles, f"use_{kind}_cull")
            row.prop(context.object.cycles, f"use_{kind}_cull")


class IWIS_PT_object_terminator(_ObjectPanel, bpy.types.Panel):
    bl_label = "Shadow Terminator"
    bl_parent_id = "OBJECT_PT_shading"

    def draw(self, context):
        offset = "shadow_terminator_geometry_offset"
        self.split_layout().prop(context.object, offset, text="Geometry Offset")


class IWIS_PT_object_light_group(_ObjectPanel, bpy.types.Panel):
    bl_label = "Light Group"
    bl_parent_id = "OBJECT_PT_shading"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    kinds: ClassVar[set[str]] = {*_GEOMETRY, "LIGHT"}

    def draw(self, context):
        draw_light_group(self.split_layout(), context.object, context.view_layer)


class IWIS_PT_object_motion_blur(_ObjectPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    kinds: ClassVar[set[str]] = {*_GEOMETRY, "CAMERA"}

    @classmethod
    def is_about(cls, obj) -> bool:
        """The settings are Cycles' own, there as long as its add-on is enabled."""
        return hasattr(obj, "cycles") and super().is_about(obj)

    def draw_header(self, context):
        self.layout.active = context.scene.render.use_motion_blur
        self.layout.prop(context.object.cycles, "use_motion_blur", text="")

    def draw(self, context):
        layout, own = self.split_layout(), context.object.cycles
        layout.active = context.scene.render.use_motion_blur and own.use_motion_blur
        layout.prop(own, "motion_steps", text="Steps")
        if context.object.type != "CAMERA":
            layout.prop(own, "use_deform_motion", text="Deformation")


def _adaptive(obj):
    """What says whether an object's last modifier is adaptive: of Blender 4.5 Cycles' settings."""
    last = obj.modifiers[-1]
    return last if hasattr(last, "use_adaptive_subdivision") else obj.cycles


class IWIS_PT_object_subdivision(_ObjectPanel, bpy.types.Panel):
    bl_label = "Adaptive Subdivision"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def is_about(cls, obj) -> bool:
        """Blender shows it in the modifier, to Cycles alone."""
        last = obj.modifiers[-1] if len(obj.modifiers) else None
        return hasattr(obj, "cycles") and last is not None and last.type == "SUBSURF"

    def draw_header(self, context):
        self.layout.prop(_adaptive(context.object), "use_adaptive_subdivision", text="")

    def draw(self, context):
        layout, last = self.split_layout(), context.object.modifiers[-1]
        layout.active = _adaptive(context.object).use_adaptive_subdivision
        if not hasattr(last, "adaptive_space"):
            layout.prop(context.object.cycles, "dicing_rate")
            return
        layout.prop(last, "adaptive_space", text="Space")
        in_space = last.adaptive_space == "OBJECT"
        layout.prop(last, "adaptive_object_edge_length" if in_space else "adaptive_pixel_size")


class IWIS_PT_material_settings(IWISPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_context = "material"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        material = getattr(context, "material", None)
        return super().poll(context) and material is not None and not material.grease_pencil

    def draw(self, context):
        column, material = self.split_layout().column(), context.material
        column.prop(material, "pass_index")
        column.prop(material, "displacement_method", text="Displacement")
        column.prop(material, "use_transparent_shadow")
        if hasattr(material, "cycles"):
            column.prop(material.cycles, "use_bump_map_correction")


CLASSES = (
    IWIS_PT_object_visibility,
    IWIS_PT_object_culling,
    IWIS_PT_object_terminator,
    IWIS_PT_object_light_group,
    IWIS_PT_object_motion_blur,
    IWIS_PT_object_subdivision,
    IWIS_PT_material_settings,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

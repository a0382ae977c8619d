"""Panels of the camera's motion blur and panoramas: Blender shows both to Cycles alone."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .job import ENGINE
from .panel_base import IWISPanel

# What a kind of panorama is set by: (property, label).
PANORAMA_PROPERTIES = {
    "EQUIRECTANGULAR": (
        ("latitude_min", "Latitude Min"),
        ("latitude_max", "Max"),
        ("longitude_min", "Longitude Min"),
        ("longitude_max", "Max"),
    ),
    "EQUIANGULAR_CUBEMAP_FACE": (),
    "MIRRORBALL": (),
    "FISHEYE_EQUIDISTANT": (("fisheye_fov", "Field of View"),),
    "FISHEYE_EQUISOLID": (("fisheye_lens", "Lens"), ("fisheye_fov", "Field of View")),
    "FISHEYE_LENS_POLYNOMIAL": (
        ("fisheye_fov", "Field of View"),
        *((f"fisheye_polynomial_k{k}", f"K{k}") for k in range(5)),
    ),
    "CENTRAL_CYLINDRICAL": (
        ("central_cylindrical_range_v_min", "Height Min"),
        ("central_cylindrical_range_v_max", "Max"),
        ("central_cylindrical_range_u_min", "Longitude Min"),
        ("central_cylindrical_range_u_max", "Max"),
        ("central_cylindrical_radius", "Cylinder Radius"),
    ),
}


class IWIS_PT_panorama(IWISPanel, bpy.types.Panel):
    bl_label = "Panorama"
    bl_context = "data"
    bl_parent_id = "DATA_PT_lens"

    @classmethod
    def poll(cls, context):
        camera = getattr(context, "camera", None)
        return context.engine == ENGINE and camera is not None and camera.type == "PANO"

    def draw(self, context):
        column, data = self.split_layout().column(), context.camera
        owner = data if hasattr(data, "panorama_type") else data.cycles
        column.prop(owner, "panorama_type", text="Type")
        for name, label in PANORAMA_PROPERTIES.get(owner.panorama_type, ()):
            column.prop(owner, name, text=label)


class IWIS_PT_motion_blur(IWISPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout, scene = self.split_layout(), context.scene
        layout.active = scene.render.use_motion_blur
        column = layout.column()
        column.prop(scene.render, "motion_blur_position", text="Position")
        column.prop(scene.render, "motion_blur_shutter")
        camera = scene.camera
        if camera is not None and hasattr(camera, "cycles"):
            column.prop(camera.cycles, "motion_steps", text="Camera Steps")
        layout.label(text="Lamps stand as in the middle of the time", icon="INFO")


class IWIS_PT_motion_blur_curve(IWISPanel, bpy.types.Panel):
    bl_label = "Shutter Curve"
    bl_parent_id = "IWIS_PT_motion_blur"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        render = context.scene.render
        self.layout.active = render.use_motion_blur
        self.layout.template_curve_mapping(render, "motion_blur_shutter_curve")


CLASSES = (IWIS_PT_panorama, IWIS_PT_motion_blur, IWIS_PT_motion_blur_curve)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

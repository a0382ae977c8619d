"""Simplify, as Cycles' panel has it; Blender's own stands above Sampling."""

from __future__ import annotations

from typing import ClassVar

import bpy

from .panel_base import IWISPanel


class IWIS_PT_simplify(IWISPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context):
        layout, render = self.split_layout(), context.scene.render
        layout.active = render.use_simplify
        owners = [
            (render, "simplify_subdivision", "Max Subdivision"),
            (render, "simplify_child_particles", "Child Particles"),
        ]
        cycles = getattr(context.scene, "cycles", None)
        if cycles is not None:  # the others are Cycles' own, there as long as its add-on is on
            owners += [
                (cycles, "texture_limit", "Texture Limit"),
                (cycles, "texture_resolution", "Texture Resolution"),  # of Blender 5
            ]
        for owner, name, text in owners:
            if hasattr(owner, name):
                column = layout.column(align=True)
                column.prop(owner, name, text=f"{text} Viewport")
                column.prop(owner, f"{name}_render", text="Render")


class IWIS_PT_simplify_culling(IWISPanel, bpy.types.Panel):
    bl_label = "Culling"
    bl_parent_id = "IWIS_PT_simplify"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw(self, context):
        layout, cycles = self.split_layout(), context.scene.cycles
        layout.active = context.scene.render.use_simplify
        for kind, text in (("camera", "Camera Culling"), ("distance", "Distance Culling")):
            row = layout.row(heading=text)
            row.prop(cycles, f"use_{kind}_cull", text="")
            margin = row.column()
            margin.active = getattr(cycles, f"use_{kind}_cull")
            margin.prop(cycles, f"{kind}_cull_margin", text="")


CLASSES = (IWIS_PT_simplify, IWIS_PT_simplify_culling)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

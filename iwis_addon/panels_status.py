"""Panels that tell: what is wrong, which light is used, what the last render took."""

from __future__ import annotations

from typing import ClassVar

import bpy

from . import light_status
from .job import RenderJob, stats_by_frame
from .notices import advice_before_render, environment_node, last_notices
from .panel_base import IWISPanel, wrapped
from .sink import clock


class IWIS_PT_warnings(IWISPanel, bpy.types.Panel):
    """What keeps IWIS from rendering, and what it could not show as set"""

    bl_label = "Warnings"
    bl_order = 0

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(advice_before_render(context.scene) or last_notices())

    def draw_header(self, _context):
        self.layout.label(icon="ERROR")

    def draw(self, context):
        layout = self.layout
        for line in advice_before_render(context.scene):
            wrapped(layout, context, line, "ERROR")
        notices = last_notices()
        for number, notice in enumerate(notices):
            row = layout.row()
            wrapped(row.column(), context, notice.text, "INFO")
            button = row.operator("iwis.select_warned", text="", icon="RESTRICT_SELECT_OFF")
            button.number = number
        if notices:
            kinds = f"{len(notices)} kind" + ("s" if len(notices) > 1 else "")
            total = sum(notice.count for notice in notices)
            row = layout.row()
            row.label(text=f"{kinds}, {total} in all")
            row.operator("iwis.copy_warnings", icon="COPYDOWN")


class IWIS_PT_light(IWISPanel, bpy.types.Panel):
    """The HDRI that lights the scene, and what is prepared of it"""

    bl_label = "Light"
    bl_order = 2

    def draw(self, context):
        layout, world = self.split_layout(), context.scene.world
        node = environment_node(world)
        if node is None:
            layout.label(text="No HDRI in the world", icon="INFO")
        else:
            image = node.image
            width, height = image.size
            column = layout.column()
            column.prop(node, "image", text="HDRI")
            column.label(text=f"{width} x {height} px, {image.colorspace_settings.name}")
        layout.operator("iwis.convert_world")
        for line in light_status.lines():
            layout.label(text=line)
        row = layout.row()
        row.active = context.scene.iwis.estimator == "PAPER"
        row.operator("iwis.bake_tables")


class IWIS_PT_statistics(IWISPanel, bpy.types.Panel):
    """What the last render took"""

    bl_label = "Statistics"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 7

    @classmethod
    def poll(cls, context):
        return super().poll(context) and RenderJob.current is not None and bool(_frames())

    def draw(self, _context):
        frame = _frames()[-1]
        column = self.layout.column(align=True)
        for label, text in statistics_rows(frame.frame, frame.stats):
            row = column.row()
            row.label(text=label)
            row.label(text=text)
        self.layout.operator("iwis.false_color")
        self.layout.operator("iwis.save_film")


def _frames():
    return [] if RenderJob.current is None else stats_by_frame(RenderJob.current.records)


def statistics_rows(frame: int, stats) -> list[tuple[str, str]]:
    """(label, value) of a frame's RenderStats, as the panel shows them."""
    seconds = stats.seconds
    rows = [
        ("Frame", f"{frame}{', cancelled' if stats.cancelled else ''}"),
        ("Size", f"{stats.width} x {stats.height} px"),
        ("Time", clock(sum(seconds.values()))),
    ]
    names = {"export": "Export", "tables": "Light", "bvh": "BVH", "sampling": "Sampling"}
    if seconds["denoising"]:
        names["denoising"] = "Denoising"
    names["output"] = "Output"
    rows += [(f"    {names[phase]}", clock(seconds[phase])) for phase in names]
    rows += [
        ("Samples a pixel", f"{stats.samples_mean:.1f}, at most {stats.samples_max}"),
        ("Shadow rays", f"{stats.shadow_rays:,}"),
        ("Camera rays", f"{stats.primary_rays:,}"),
        ("Triangles", f"{stats.triangles:,}"),
    ]
    return rows


CLASSES = (IWIS_PT_warnings, IWIS_PT_light, IWIS_PT_statistics)

register, unregister = bpy.utils.register_classes_factory(CLASSES)

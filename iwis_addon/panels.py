"""IWIS' own panels, and those of Blender's that make sense with it."""

from __future__ import annotations

from typing import ClassVar

import bpy
from bl_ui.properties_render import (
    CompositorDenoisePerformanceButtonsPanel,
    CompositorPerformanceButtonsPanel,
)

from .job import ENGINE
from .panel_base import IWISPanel
from .panels_denoise import draw_denoise
from .preferences import add_on_preferences, cache_dir
from .sampling_presets import IWIS_PT_sampling_presets

# Blender's panels for every engine that mean nothing here, as light probes, or too little: EEVEE's
# panel of a lamp, below, shows the power as well. (Freestyle's lines are drawn over any engine's.)
_EXCLUDED = {
    "DATA_PT_distance",
    "DATA_PT_light",
    "NODE_DATA_PT_light",
}
_EXCLUDED_WORDS = (
    "gpencil",
    "lightprobe",
    "PT_volume",
    "RENDER_PT_simplify",  # stands above Sampling; IWIS has its own
)

# EEVEE's panels that only show the node trees, lamps and the lens, and the passes' parent.
_SHARED_WITH_EEVEE = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_displacement",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
    "VIEWLAYER_PT_layer_passes",
}


def blender_panels() -> list[type]:
    """Blender's panel classes that IWIS joins, of the Blender that runs."""
    return [panel for panel in _subclasses(bpy.types.Panel) if _is_joined(panel)]


def _subclasses(cls):
    for sub in cls.__subclasses__():
        yield sub
        yield from _subclasses(sub)


def _is_joined(panel) -> bool:
    name = panel.__name__
    if name in _SHARED_WITH_EEVEE:
        return True
    if name in _EXCLUDED or any(word in name for word in _EXCLUDED_WORDS):
        return False
    return "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())


class IWIS_PT_sampling(IWISPanel, bpy.types.Panel):
    bl_label = "Sampling"
    bl_order = 1

    def draw_header_preset(self, _context):
        IWIS_PT_sampling_presets.draw_panel_header(self.layout)

    def draw(self, context):
        pass


class IWIS_PT_sampling_viewport(IWISPanel, bpy.types.Panel):
    bl_label = "Viewport"
    bl_parent_id = "IWIS_PT_sampling"

    def draw(self, context):
        layout, own = self.split_layout(), context.scene.iwis.viewport
        column = layout.column(align=True)
        column.prop(own, "error_threshold")
        column.prop(own, "max_samples")
        layout.prop(own, "pixel_filter")
        draw_denoise(layout, context, own)
        layout.prop(own, "overlay")


class IWIS_PT_sampling_render(IWISPanel, bpy.types.Panel):
    bl_label = "Render"
    bl_parent_id = "IWIS_PT_sampling"

    def draw(self, context):
        layout, iwis = self.split_layout(), context.scene.iwis
        layout.prop(iwis, "stop_rule")
        column = layout.column(align=True)
        if iwis.stop_rule == "BUDGET":
            column.prop(iwis, "target_samples")
            column.prop(iwis, "time_limit")
        else:
            row = column.row()
            row.active = iwis.stop_rule != "FIXED"
            row.prop(iwis, "error_threshold")
        column.prop(iwis, "max_samples")
        draw_denoise(layout, context, iwis)


class IWIS_PT_sampling_advanced(IWISPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "IWIS_PT_sampling"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, iwis = self.split_layout(), context.scene.iwis
        for name in (
            "estimator",
            "coefficients",
            "batch_size",
            "decorrelation",
            "transparent_max_bounces",
            "seed",
            "use_animated_seed",
        ):
            row = layout.row()
            row.active = name != "coefficients" or iwis.estimator == "PAPER"
            row.prop(iwis, name)
        layout.operator("iwis.copy_cycles_settings")


class IWIS_PT_performance(IWISPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 5

    def draw(self, context):
        pass


class IWIS_PT_performance_compositor(IWISPanel, CompositorPerformanceButtonsPanel, bpy.types.Panel):
    bl_parent_id = "IWIS_PT_performance"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}


class IWIS_PT_performance_compositor_denoise(
    IWISPanel, CompositorDenoisePerformanceButtonsPanel, bpy.types.Panel
):
    bl_parent_id = "IWIS_PT_performance_compositor"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}


class IWIS_PT_performance_threads(IWISPanel, bpy.types.Panel):
    bl_label = "Threads"
    bl_parent_id = "IWIS_PT_performance"

    def draw(self, context):
        layout, render = self.split_layout(), context.scene.render
        layout.prop(render, "threads_mode")
        column = layout.column()
        column.enabled = render.threads_mode == "FIXED"
        column.prop(render, "threads")
        layout.prop(context.scene.iwis, "threads", text="IWIS Threads")


class IWIS_PT_performance_memory(IWISPanel, bpy.types.Panel):
    bl_label = "Memory"
    bl_parent_id = "IWIS_PT_performance"

    def draw(self, context):
        layout = self.split_layout()
        layout.prop(context.scene.iwis, "tile_px")
        preferences = add_on_preferences()
        if preferences is not None:
            layout.prop(preferences, "cache_dir", placeholder=cache_dir())
        layout.operator("iwis.clear_cache")


class IWIS_PT_performance_final(IWISPanel, bpy.types.Panel):
    bl_label = "Final Render"
    bl_parent_id = "IWIS_PT_performance"

    def draw(self, context):
        self.split_layout().prop(context.scene.render, "use_persistent_data")


class IWIS_PT_performance_viewport(IWISPanel, bpy.types.Panel):
    bl_label = "Viewport"
    bl_parent_id = "IWIS_PT_performance"

    def draw(self, context):
        self.split_layout().prop(context.scene.render, "preview_pixel_size", text="Pixel Size")


class IWIS_PT_subdivision(IWISPanel, bpy.types.Panel):
    bl_label = "Subdivision"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 3

    @classmethod
    def poll(cls, context):
        """The settings are Cycles' own, there as long as its add-on is enabled."""
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw(self, context):
        layout, cycles = self.split_layout(), context.scene.cycles
        column = layout.column(align=True)
        column.prop(cycles, "dicing_rate", text="Dicing Rate Render")
        column.prop(cycles, "preview_dicing_rate", text="Viewport")
        layout.prop(cycles, "offscreen_dicing_scale", text="Offscreen Scale")
        layout.prop(cycles, "max_subdivisions")
        layout.prop(cycles, "dicing_camera")
        if hasattr(cycles, "feature_set"):  # of Blender 4.5, which dices as an experiment alone
            layout.prop(cycles, "feature_set")


class IWIS_PT_film(IWISPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 4

    def draw(self, context):
        layout = self.split_layout()
        if hasattr(context.scene, "cycles"):  # the exposure is Cycles' own, as long as it is on
            layout.prop(context.scene.cycles, "film_exposure")
        layout.prop(context.scene.render, "film_transparent", text="Transparent")
        layout.prop(context.scene.iwis, "keep_film")
        layout.operator("iwis.save_film")


class IWIS_PT_film_pixel_filter(IWISPanel, bpy.types.Panel):
    bl_label = "Pixel Filter"
    bl_parent_id = "IWIS_PT_film"

    def draw(self, context):
        column, iwis = self.split_layout().column(), context.scene.iwis
        column.prop(iwis, "pixel_filter", text="Type")
        if iwis.pixel_filter in ("GAUSSIAN", "BLACKMAN_HARRIS"):
            column.prop(iwis, "filter_width", text="Width")


CLASSES = (
    IWIS_PT_sampling,
    IWIS_PT_sampling_viewport,
    IWIS_PT_sampling_render,
    IWIS_PT_sampling_advanced,
    IWIS_PT_performance,
    IWIS_PT_performance_compositor,
    IWIS_PT_performance_compositor_denoise,
    IWIS_PT_performance_threads,
    IWIS_PT_performance_memory,
    IWIS_PT_performance_final,
    IWIS_PT_performance_viewport,
    IWIS_PT_film,
    IWIS_PT_film_pixel_filter,
    IWIS_PT_subdivision,
)


def register() -> None:
    for panel in blender_panels():
        panel.COMPAT_ENGINES.add(ENGINE)
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    for panel in blender_panels():  # and not IWIS' own: theirs is one set, kept for the next time
        panel.COMPAT_ENGINES.discard(ENGINE)

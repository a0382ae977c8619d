"""IWIS' own panels, and those of Blender's that make sense with it."""

from __future__ import annotations

from typing import ClassVar

import bpy

from . import dependencies
from .job import ENGINE, RenderJob
from .passes import TABLE

# Blender's panels for every engine that mean nothing here: there are no lamps, no Freestyle, no
# material previews.
_EXCLUDED = {
    "DATA_PT_distance",
    "DATA_PT_light",
    "DATA_PT_light_animation",
    "DATA_PT_preview",
    "DATA_PT_spot",
    "NODE_DATA_PT_light",
}
_EXCLUDED_WORDS = (
    "freestyle",
    "gpencil",
    "lightprobe",
    "pointcloud",
    "PT_volume",
    "RENDER_PT_simplify",  # stands above Sampling; IWIS has its own
    "speaker",
)

# EEVEE's panels that only show the node trees, and the passes' parent.
_SHARED_WITH_EEVEE = {
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
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


class _IWISPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES: ClassVar[set[str]] = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def split_layout(self):
        """The panel's layout with labels on the left."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class IWIS_PT_warnings(_IWISPanel, bpy.types.Panel):
    """What keeps IWIS from rendering, and what the last render could not show as set."""

    bl_label = "Warnings"
    bl_order = 0

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(dependencies.missing() or last_warnings())

    def draw(self, context):
        for line in dependencies.advice():
            self.layout.label(text=line, icon="ERROR")
        for line in last_warnings():
            self.layout.label(text=line, icon="INFO")


class IWIS_PT_sampling(_IWISPanel, bpy.types.Panel):
    bl_label = "Sampling"
    bl_order = 1

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


class IWIS_PT_sampling_advanced(_IWISPanel, bpy.types.Panel):
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
            "seed",
        ):
            layout.prop(iwis, name)


class IWIS_PT_performance(_IWISPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw(self, context):
        layout, iwis = self.split_layout(), context.scene.iwis
        layout.prop(context.scene.render, "threads_mode")
        row = layout.row()
        row.active = context.scene.render.threads_mode == "FIXED"
        row.prop(context.scene.render, "threads")
        layout.prop(iwis, "threads", text="IWIS Threads")
        layout.prop(iwis, "tile_px")
        layout.prop(context.scene.render, "use_persistent_data")
        layout.operator("iwis.bake_tables")
        layout.operator("iwis.clear_cache")


class IWIS_PT_simplify(_IWISPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 4

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context):
        layout, render = self.split_layout(), context.scene.render
        layout.active = render.use_simplify
        layout.prop(render, "simplify_subdivision_render", text="Max Subdivision")
        layout.prop(render, "simplify_child_particles_render", text="Max Child Particles")


class IWIS_PT_film(_IWISPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw(self, context):
        layout = self.split_layout()
        layout.prop(context.scene.render, "film_transparent", text="Transparent")
        layout.prop(context.scene.iwis, "keep_film")
        layout.operator("iwis.save_film")


class IWIS_PT_film_pixel_filter(_IWISPanel, bpy.types.Panel):
    bl_label = "Pixel Filter"
    bl_parent_id = "IWIS_PT_film"

    def draw(self, context):
        column, iwis = self.split_layout().column(), context.scene.iwis
        column.prop(iwis, "pixel_filter", text="Type")
        if iwis.pixel_filter == "BLACKMAN_HARRIS":
            column.prop(iwis, "filter_width", text="Width")


class _PassesPanel(_IWISPanel):
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


CLASSES = (
    IWIS_PT_warnings,
    IWIS_PT_sampling,
    IWIS_PT_sampling_advanced,
    IWIS_PT_performance,
    IWIS_PT_film,
    IWIS_PT_film_pixel_filter,
    IWIS_PT_simplify,
    IWIS_PT_passes_data,
    IWIS_PT_passes_light,
    IWIS_PT_passes_iwis,
)


def last_warnings() -> list[str]:
    """What the last render warned of, each line once."""
    if RenderJob.current is None:
        return []
    lines = (line for record in RenderJob.current.records for line in record.stats.warnings)
    return list(dict.fromkeys(lines))


def register() -> None:
    for panel in blender_panels():
        panel.COMPAT_ENGINES.add(ENGINE)
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    for panel in _subclasses(bpy.types.Panel):
        if hasattr(panel, "COMPAT_ENGINES") and panel not in CLASSES:
            panel.COMPAT_ENGINES.discard(ENGINE)

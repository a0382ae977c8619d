"""One file a button: it reads RNA, calls a plain function, reports."""

import bpy

from ..iwis_addon.job import ENGINE
from . import (
    bake_tables,
    bake_unsupported,
    clear_cache,
    compare_cycles,
    convert_world,
    copy_cycles_settings,
    false_color,
    inspect_pixel,
    save_film,
    view_overlay,
    warned,
)

MODULES = (
    bake_tables,
    bake_unsupported,
    clear_cache,
    compare_cycles,
    convert_world,
    copy_cycles_settings,
    false_color,
    inspect_pixel,
    save_film,
    view_overlay,
    warned,
)
_IN_MENU = (
    "iwis.inspect_pixel",
    "iwis.false_color",
    "iwis.compare_cycles",
    None,
    "iwis.bake_unsupported",
    "iwis.convert_world",
    "iwis.copy_cycles_settings",
    None,
    "iwis.bake_tables",
    "iwis.clear_cache",
    "iwis.save_film",
)


class IWIS_MT_render(bpy.types.Menu):
    """IWIS' part of the Render menu."""

    bl_idname = "IWIS_MT_render"
    bl_label = "IWIS"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for name in _IN_MENU:
            layout.separator() if name is None else layout.operator(name)
        layout.separator()
        layout.operator_menu_enum("iwis.view_overlay", "overlay")


def _add_to_render_menu(self, context):
    if context.scene.render.engine == ENGINE:
        self.layout.separator()
        self.layout.menu(IWIS_MT_render.bl_idname)


def _add_to_image_menu(self, context):
    if context.scene.render.engine == ENGINE:
        self.layout.separator()
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("iwis.inspect_pixel")
        self.layout.operator_menu_enum("iwis.false_color", "layer")


def _add_to_view_menu(self, context):
    if context.scene.render.engine == ENGINE and context.space_data.shading.type == "RENDERED":
        self.layout.separator()
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("iwis.inspect_pixel")


def register() -> None:
    for module in MODULES:
        for cls in module.CLASSES:
            bpy.utils.register_class(cls)
    bpy.utils.register_class(IWIS_MT_render)
    bpy.types.TOPBAR_MT_render.append(_add_to_render_menu)
    bpy.types.IMAGE_MT_image.append(_add_to_image_menu)
    bpy.types.VIEW3D_MT_view.append(_add_to_view_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_view.remove(_add_to_view_menu)
    bpy.types.IMAGE_MT_image.remove(_add_to_image_menu)
    bpy.types.TOPBAR_MT_render.remove(_add_to_render_menu)
    bpy.utils.unregister_class(IWIS_MT_render)
    for module in reversed(MODULES):
        for cls in reversed(module.CLASSES):
            bpy.utils.unregister_class(cls)

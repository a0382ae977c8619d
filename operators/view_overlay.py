"""Choose what the rendered view shows."""

import bpy

from ..iwis_addon.job import ENGINE
from ..iwis_addon.viewport_properties import OVERLAYS


class IWIS_OT_view_overlay(bpy.types.Operator):
    """Show the picture, or samples, error or visibility in false color, in the rendered view"""

    bl_idname = "iwis.view_overlay"
    bl_label = "IWIS Viewport Overlay"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    overlay: bpy.props.EnumProperty(name="Show", description="What to show", items=OVERLAYS)

    @classmethod
    def poll(cls, context):
        if context.scene.render.engine == ENGINE:
            return True
        cls.poll_message_set("The render engine is not IWIS")
        return False

    def execute(self, context):
        context.scene.iwis.viewport.overlay = self.overlay
        return {"FINISHED"}


CLASSES = (IWIS_OT_view_overlay,)

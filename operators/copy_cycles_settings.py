"""Set IWIS as the scene was set for Cycles."""

import bpy

from ..iwis_addon.cycles_settings import copy_cycles_settings


class IWIS_OT_copy_cycles_settings(bpy.types.Operator):
    """Take samples, thresholds, time limit, seed, filter and denoising from Cycles' settings"""

    bl_idname = "iwis.copy_cycles_settings"
    bl_label = "Copy Cycles Settings"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        if hasattr(context.scene, "cycles"):
            return True
        cls.poll_message_set("Cycles is disabled: its settings are not there")
        return False

    def execute(self, context):
        names = copy_cycles_settings(context.scene)
        self.report({"INFO"}, f"Copied from Cycles: {', '.join(names)}")
        return {"FINISHED"}


CLASSES = (IWIS_OT_copy_cycles_settings,)

"""Let Cycles bake what IWIS does not know of a material."""

import bpy
from bpy.props import IntProperty

from ..iwis_addon import callbacks
from ..iwis_addon.bake_unsupported import bake_unsupported


class IWIS_OT_bake_unsupported(bpy.types.Operator):
    """Bake inputs of materials that IWIS does not support to images by Cycles, and use those"""

    bl_idname = "iwis.bake_unsupported"
    bl_label = "Bake Unsupported"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    size: IntProperty(
        name="Size",
        description="Width and height of each image in pixels",
        default=1024,
        min=4,
        max=16384,
        subtype="PIXEL",
    )
    samples: IntProperty(
        name="Samples",
        description="Samples a pixel: more where a node itself is noisy, as Ambient Occlusion is",
        default=16,
        min=1,
        soft_max=256,
    )

    @classmethod
    def poll(cls, context):
        if not hasattr(context.scene, "cycles"):
            cls.poll_message_set("Cycles is disabled: it bakes the images")
        elif context.mode != "OBJECT":
            cls.poll_message_set("Baking needs Object Mode")
        elif callbacks.cannot_render():
            cls.poll_message_set(callbacks.cannot_render())
        else:
            return True
        return False

    def execute(self, context):
        try:
            done, problems = bake_unsupported(context, self.size, self.samples)
        except (RuntimeError, ValueError) as error:
            self.report({"ERROR"}, f"Nothing was baked: {error}")
            return {"CANCELLED"}
        for line in done:
            self.report({"INFO"}, line)
        for line in problems:
            self.report({"WARNING"}, line)
        if not done and not problems:
            text = "All inputs of the scene's materials are supported; a shader cannot be baked"
            self.report({"INFO"}, text)
        return {"FINISHED"} if done else {"CANCELLED"}


CLASSES = (IWIS_OT_bake_unsupported,)

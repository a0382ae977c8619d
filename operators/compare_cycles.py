"""Render the frame with both engines and show where they differ."""

import bpy
from bpy.props import IntProperty

from ..iwis_addon import callbacks
from ..iwis_addon.cycles_settings import compare_with_cycles
from ..iwis_addon.images import put_image, show_image


class IWIS_OT_compare_cycles(bpy.types.Operator):
    """Render the current frame with IWIS and with Cycles' direct light, and show the difference"""

    bl_idname = "iwis.compare_cycles"
    bl_label = "Compare with Cycles"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    samples: IntProperty(
        name="Cycles Samples",
        description="Samples of Cycles' picture: its own noise counts as difference",
        default=256,
        min=1,
        soft_max=4096,
    )

    @classmethod
    def poll(cls, context):
        if not hasattr(context.scene, "cycles"):
            cls.poll_message_set("Cycles is disabled")
        elif context.scene.camera is None:
            cls.poll_message_set("The scene has no camera")
        elif callbacks.cannot_render():
            cls.poll_message_set(callbacks.cannot_render())
        else:
            return True
        return False

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            result = compare_with_cycles(context.scene, self.samples)
        except (RuntimeError, OSError, ValueError) as error:
            self.report({"ERROR"}, f"Not compared: {error}")
            return {"CANCELLED"}
        image = put_image("IWIS Difference to Cycles", result.difference, is_float=True)
        image["mre"], image["bias"] = result.mre, result.bias
        show_image(context, image)
        text = f"Mean relative error {result.mre:.4f}, bias {result.bias:+.4f}"
        self.report({"INFO"}, f"{text}; the difference is in the image {image.name}")
        return {"FINISHED"}


CLASSES = (IWIS_OT_compare_cycles,)

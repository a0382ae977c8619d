"""Make any world one that IWIS renders exactly: an HDRI."""

import bpy
from bpy.props import IntProperty

from ..iwis_addon import callbacks
from ..iwis_addon.world_bake import bake_world, use_image


class IWIS_OT_convert_world(bpy.types.Operator):
    """Bake the world, sky textures included, to an HDRI by a Cycles panorama, and use that"""

    bl_idname = "iwis.convert_world"
    bl_label = "Convert World to HDRI"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    height: IntProperty(
        name="Height",
        description="Height of the image in pixels; it is twice as wide",
        default=1024,
        min=4,
        soft_max=4096,
        max=16384,
        subtype="PIXEL",
    )
    samples: IntProperty(
        name="Samples",
        description="Samples a pixel, for detail that is finer than a pixel",
        default=16,
        min=1,
        soft_max=256,
    )

    @classmethod
    def poll(cls, context):
        if context.scene.world is None:
            cls.poll_message_set("The scene has no world")
        elif not hasattr(context.scene, "cycles"):
            cls.poll_message_set("Cycles is disabled: it renders the panorama")
        elif callbacks.cannot_render():
            cls.poll_message_set(callbacks.cannot_render())
        else:
            return True
        return False

    def execute(self, context):
        before = context.scene.world.name
        try:
            image = bake_world(context.scene, self.height, self.samples)
        except (RuntimeError, OSError, ValueError) as error:
            self.report({"ERROR"}, f"World {before} was not converted: {error}")
            return {"CANCELLED"}
        world = use_image(context.scene, image)
        self.report({"INFO"}, f"World {before} is now the HDRI of world {world.name}, packed")
        return {"FINISHED"}


CLASSES = (IWIS_OT_convert_world,)

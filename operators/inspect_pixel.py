"""Show where the samples of one pixel go: the paper's figure 3 for one's own scene."""

import bpy
from bpy.props import IntProperty

from ..iwis_addon import dependencies
from ..iwis_addon.export import ExportError, export_scene
from ..iwis_addon.images import put_image, show_image
from ..iwis_addon.preferences import share_cache_dir
from ..iwis_addon.settings import render_settings


class IWIS_OT_inspect_pixel(bpy.types.Operator):
    """Pick a pixel of a rendered image: light, BSDF, their product and the samples as an image"""

    bl_idname = "iwis.inspect_pixel"
    bl_label = "Show Sampling of Pixel"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    x: IntProperty(name="X", description="Column of the pixel from the left", min=0)
    y: IntProperty(name="Y", description="Row of the pixel from below", min=0)
    height: IntProperty(
        name="Map Height",
        description="Height in pixels of each of the four maps",
        default=256,
        min=16,
        max=2048,
        subtype="PIXEL",
    )

    @classmethod
    def poll(cls, context):
        if context.scene.camera is not None:
            return True
        cls.poll_message_set("The scene has no camera")
        return False

    def invoke(self, context, _event):
        area = context.area
        if area is None or area.type != "IMAGE_EDITOR" or context.space_data.image is None:
            return context.window_manager.invoke_props_dialog(self)
        context.workspace.status_text_set("Click a pixel of the rendered picture; Esc: cancel")
        context.window.cursor_modal_set("EYEDROPPER")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self._end(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        self._end(context)
        region = context.region
        u, v = region.view2d.region_to_view(event.mouse_region_x, event.mouse_region_y)
        width, height = picked_size(context.space_data.image, context.scene)
        self.x, self.y = max(int(u * width), 0), max(int(v * height), 0)
        return self.execute(context)

    def _end(self, context):
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        try:
            view, picture = inspect_pixel(depsgraph, self.x, self.y, self.height)
        except (dependencies.MissingPackage, ExportError, OSError, ValueError) as error:
            self.report({"ERROR"}, f"Not shown: {error}")
            return {"CANCELLED"}
        show_image(context, put_image("IWIS Sampling", picture, is_float=False))
        seen = int((~view.occluded).sum())
        text = f"Pixel ({self.x}, {self.y}): {view.count} samples, {seen} see the light (red)"
        self.report({"INFO"}, text)
        return {"FINISHED"}


def picked_size(image, scene) -> tuple[int, int]:
    """Pixels of the frame that an image shows: a render result has no size of its own."""
    if image.type in {"RENDER_RESULT", "COMPOSITING"} or 0 in image.size:
        render = scene.render
        percentage = render.resolution_percentage
        return render.resolution_x * percentage // 100, render.resolution_y * percentage // 100
    return tuple(image.size)


def inspect_pixel(depsgraph, x: int, y: int, height: int = 256):
    """core.pixel_view.PixelView of pixel (x, y) of the frame, y up, and a picture of it.

    The picture: float32 (2 height + 8, 4 height + 8, 4), display values, row 0 at the bottom.
    """
    dependencies.require()
    share_cache_dir()
    from ..core.pixel_view import draw_pixel_view, look_at_pixel

    scene = export_scene(depsgraph, warnings=[])
    view = look_at_pixel(scene, render_settings(depsgraph.scene_eval), x, y, height)
    return view, draw_pixel_view(view)


CLASSES = (IWIS_OT_inspect_pixel,)

"""Show where the samples of one pixel go: the paper's figure 3 for one's own scene."""

import bpy
from bpy.props import EnumProperty, IntProperty

from ..iwis_addon import dependencies
from ..iwis_addon.export import ExportError, export_scene
from ..iwis_addon.images import put_image, show_image, waiting
from ..iwis_addon.preferences import share_cache_dir
from ..iwis_addon.settings import render_settings, viewport_settings
from ..iwis_addon.view_camera import view_camera


class IWIS_OT_inspect_pixel(bpy.types.Operator):
    """Pick a pixel of a picture or a rendered view: light, BSDF, product and samples as an image"""

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

    source: EnumProperty(
        name="Pixel of",
        description="Which picture X and Y count the pixels of",
        items=(
            ("CAMERA", "Camera", "A pixel of the frame of the scene's camera"),
            ("VIEW", "3D View", "A pixel of a 3D view, as its rendered view shows it"),
        ),
        default="CAMERA",
    )

    picked = None  # (space, region) of the click

    @classmethod
    def poll(cls, context):
        if context.scene.camera is not None or _view_of(context) is not None:
            return True
        cls.poll_message_set("The scene has no camera, and this is no 3D view")
        return False

    def invoke(self, context, _event):
        if not any(is_pickable(area) for area in context.window.screen.areas):
            return context.window_manager.invoke_props_dialog(self)
        context.workspace.status_text_set(
            "Click a pixel of the rendered picture or of a rendered view; Esc: cancel"
        )
        context.window.cursor_modal_set("EYEDROPPER")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self._end(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        found = region_under(context.window.screen, event.mouse_x, event.mouse_y)
        if found is None:  # beside all pictures: a header, another editor
            return {"PASS_THROUGH"}
        self._end(context)
        self._pick(context, *found, event.mouse_x, event.mouse_y)
        return self.execute(context)

    def _pick(self, context, area, region, mouse_x, mouse_y):
        x, y, space = mouse_x - region.x, mouse_y - region.y, area.spaces.active
        if area.type == "VIEW_3D":
            self.source, self.picked = "VIEW", (space, region)
        else:
            self.source = "CAMERA"
            u, v = region.view2d.region_to_view(x, y)
            width, height = picked_size(space.image, context.scene)
            x, y = int(u * width), int(v * height)
        self.x, self.y = max(x, 0), max(y, 0)

    def _end(self, context):
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        seen = None
        if self.source == "VIEW":
            seen = self.picked or _view_of(context)
            if seen is None:
                self.report({"ERROR"}, "Not shown: run it in a 3D view, or choose the camera's")
                return {"CANCELLED"}
        try:
            with waiting(context.window):  # a machine's first compiles for half a minute
                view, picture = inspect_pixel(depsgraph, self.x, self.y, self.height, seen)
        except (dependencies.MissingPackage, ExportError, OSError, ValueError) as error:
            self.report({"ERROR"}, f"Not shown: {error}")
            return {"CANCELLED"}
        show_image(context, put_image("IWIS Sampling", picture, is_float=False))
        free = int((~view.occluded).sum())
        text = f"Pixel ({self.x}, {self.y}): {view.count} samples, {free} see the light (red)"
        text += ': image "IWIS Sampling"'
        self.report({"INFO"}, text)
        return {"FINISHED"}


def is_pickable(area) -> bool:
    """Whether an area shows a picture, or the rendered view."""
    space = area.spaces.active
    if area.type == "VIEW_3D":
        return space.shading.type == "RENDERED"
    return area.type == "IMAGE_EDITOR" and space.image is not None


def region_under(screen, x: int, y: int):
    """(area, region) of the picture at a place of the window, y up; None where there is none.

    A header or a sidebar that lies over a picture is none of it.
    """
    for area in screen.areas:
        under = [
            region
            for region in area.regions
            if 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
        ]
        if under and is_pickable(area) and all(region.type == "WINDOW" for region in under):
            return area, under[0]
    return None


def _view_of(context):
    """(space, region) of the 3D view that a context is in; None elsewhere."""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        return None
    region = context.region
    if region is None or region.type != "WINDOW":
        region = next(each for each in area.regions if each.type == "WINDOW")
    return area.spaces.active, region


def picked_size(image, scene) -> tuple[int, int]:
    """Pixels of the frame that an image shows: a render result has no size of its own."""
    if image.type in {"RENDER_RESULT", "COMPOSITING"} or 0 in image.size:
        render = scene.render
        percentage = render.resolution_percentage
        return render.resolution_x * percentage // 100, render.resolution_y * percentage // 100
    return tuple(image.size)


def inspect_pixel(depsgraph, x: int, y: int, height: int = 256, seen=None):
    """core.windows.pixel_view.PixelView of pixel (x, y) of the frame, y up, and a picture of it.

    seen: (space, region) of a 3D view whose pixel is meant, with the rendered view's settings; None
    means the scene's camera and the settings of a render
    The picture: float32 (2 height + 8, 4 height + 8, 4), display values, row 0 at the bottom.
    """
    dependencies.require()
    share_cache_dir()
    from ..core.windows.pixel_view import draw_pixel_view, look_at_pixel

    scene, camera = depsgraph.scene_eval, None
    settings = render_settings(scene)
    if seen is not None:
        camera, settings = _whole_view(*seen, scene), viewport_settings(scene)
    view = look_at_pixel(
        export_scene(depsgraph, warnings=[], camera=camera), settings, x, y, height
    )
    return view, draw_pixel_view(view)


def _whole_view(space, region, scene):
    """The camera of a 3D view, a pixel of the screen to a pixel."""
    camera = view_camera(region, region.data, space, scene, 1)
    if camera is None:
        raise ValueError("the render border leaves nothing of this view")
    return camera


CLASSES = (IWIS_OT_inspect_pixel,)

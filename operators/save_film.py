"""Save every layer of the last render to one EXR, whatever passes the view layers had."""

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from ..iwis_addon.exr_process import write_exr
from ..iwis_addon.job import RenderJob
from ..iwis_addon.passes import passes_of


class IWIS_OT_save_film(bpy.types.Operator, ExportHelper):
    """Save all layers of the last render, which must have been made with Keep Film, to one EXR"""

    bl_idname = "iwis.save_film"
    bl_label = "Save Film"

    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    @classmethod
    def poll(cls, _context):
        if RenderJob.current is not None and RenderJob.current.films:
            return True
        cls.poll_message_set("There is no film: turn on Keep Film and render with IWIS")
        return False

    def execute(self, _context):
        path = bpy.path.abspath(self.filepath)
        layers, letters = film_layers(RenderJob.current.films)
        colors = getattr(bpy.data, "colorspace", None)  # of Blender 5
        space = getattr(colors, "working_space_interop_id", "")
        try:
            write_exr(path, layers, letters, not bpy.app.module, space)
        except (ImportError, OSError) as error:
            self.report({"ERROR"}, f"The film was not saved: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Saved {len(layers)} layers to {path}")
        return {"FINISHED"}


def film_layers(films: dict) -> tuple[dict, dict]:
    """(view layer, view) -> Film becomes "ViewLayer.Depth", with views "ViewLayer.Depth.left".

    Returns name -> pixels, and name -> letters of the channels, as Blender names them.
    """
    layers, letters = {}, {}
    for (layer, view), film in films.items():
        for row in passes_of(film.layers):
            name = ".".join(part for part in (layer, row.name, view) if part)
            layers[name], letters[name] = row.pixels(film.layers), row.channel_ids
    return layers, letters


CLASSES = (IWIS_OT_save_film,)

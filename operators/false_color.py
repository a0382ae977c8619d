"""The last render's passes of numbers as images in false color."""

import bpy
import numpy as np

from ..iwis_addon.false_color import false_color, scale_of
from ..iwis_addon.images import put_image, show_image
from ..iwis_addon.job import RenderJob
from ..iwis_addon.number_film import NUMBERS, NumberFilm


class IWIS_OT_false_color(bpy.types.Operator):
    """Show samples, error or visibility of the last render as an image in false color"""

    bl_idname = "iwis.false_color"
    bl_label = "Show in False Color"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    layer: bpy.props.EnumProperty(
        name="Pass",
        description="What to show",
        items=[(name, name.capitalize(), "") for name in NUMBERS],
        default="samples",
    )

    @classmethod
    def poll(cls, _context):
        if RenderJob.current is not None and RenderJob.current.numbers:
            return True
        cls.poll_message_set("Nothing to show: render with IWIS (in background with Keep Film)")
        return False

    def execute(self, context):
        film = list(RenderJob.current.numbers.values())[-1]
        image = put_image(f"IWIS {self.layer.capitalize()}", film_colors(film, self.layer), False)
        show_image(context, image)
        values = film.layers[self.layer]
        low, mean, high = values.min(), values.mean(), values.max()
        self.report({"INFO"}, f"{image.name}: {low:.3g} to {high:.3g}, mean {mean:.3g}")
        return {"FINISHED"}


def film_colors(film: NumberFilm, layer: str) -> np.ndarray:
    """Display colors, float32 (h, w, 4), of a layer of NUMBERS, with its scale along the edge."""
    scale = scale_of(layer, film.settings)
    colors = false_color(film.layers[layer], scale)
    height, width = colors.shape[:2]
    bar = max(width // 40, 2)
    values = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None]
    return np.concatenate([colors, np.repeat(false_color(values, UNIT), bar, axis=1)], axis=1)


UNIT = scale_of("visibility", None)

CLASSES = (IWIS_OT_false_color,)

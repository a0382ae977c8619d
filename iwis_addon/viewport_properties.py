"""What a user sets for the rendered view alone: `scene.iwis.viewport`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ..core.settings import LIMITS
from .denoise_properties import VIEW_DEFAULTS, choice, switch

OVERLAYS = (
    ("COMBINED", "Combined", "The picture"),
    ("SAMPLES", "Samples", "Shadow rays that each pixel took, in false color"),
    ("ERROR", "Error", "Estimated noise that each pixel was left with, in false color"),
    ("VISIBILITY", "Visibility", "Share of the shadow rays that saw the light, in false color"),
)


def redraw_views(_properties, context):
    """Draw every 3D view again."""
    # Set by a script, an add-on's property redraws nothing by itself.
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class IWISViewportProperties(bpy.types.PropertyGroup):
    """Settings of the rendered view where they differ from a final render's."""

    error_threshold: FloatProperty(
        name="Error Threshold",
        description="The relative noise at which a pixel of the rendered view is done",
        default=0.1,
        min=LIMITS["error_threshold"][0],
        max=LIMITS["error_threshold"][1],
        soft_max=1.0,
        precision=3,
        update=redraw_views,
    )
    max_samples: IntProperty(
        name="Max Samples",
        description="The most shadow rays that a pixel of the rendered view may take",
        default=256,
        min=LIMITS["max_samples"][0],
        max=LIMITS["max_samples"][1],
        soft_max=1024,
        update=redraw_views,
    )
    pixel_filter: EnumProperty(
        name="Filter Type",
        description="Pixel filter of the rendered view; Center is the fastest",
        items=[
            ("CENTER", "Center", "One shading point, at the pixel's center: no anti-aliasing"),
            ("BOX", "Box", "Box filter, one pixel wide"),
            ("BLACKMAN_HARRIS", "Blackman-Harris", "As Cycles has it by default"),
            ("GAUSSIAN", "Gaussian", "Gaussian filter, as Cycles'"),
        ],
        default="CENTER",
        update=redraw_views,
    )
    denoise: BoolProperty(
        **switch(
            description="Take the noise out of the pictures of the rendered view, once fine",
            update=redraw_views,
        )
    )
    denoise_passes: EnumProperty(**choice("denoise_passes", VIEW_DEFAULTS, update=redraw_views))
    denoise_prefilter: EnumProperty(
        **choice("denoise_prefilter", VIEW_DEFAULTS, update=redraw_views)
    )
    denoise_quality: EnumProperty(**choice("denoise_quality", VIEW_DEFAULTS, update=redraw_views))
    denoise_start: IntProperty(
        name="Start Sample",
        description="The samples that a pixel has taken before the view is denoised",
        default=1,
        min=0,
        max=LIMITS["max_samples"][1],
        soft_max=1024,
        update=redraw_views,
    )
    overlay: EnumProperty(
        name="Show",
        description="What the rendered view shows",
        items=OVERLAYS,
        default="COMBINED",
        update=redraw_views,
    )

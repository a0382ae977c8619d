"""The denoiser in the panels of sampling: greyed, with the reason, where Blender has none."""

from __future__ import annotations

from .denoiser import find_library
from .panel_base import wrapped


def draw_denoise(layout, context, own) -> None:
    """The check box, and its options where it is on.

    own: ``context.scene.iwis``, or its ``viewport``
    """
    path, problem = find_library()
    column = layout.column()
    column.enabled = bool(path)
    column.prop(own, "denoise")
    if not path:
        wrapped(layout, context, problem[:1].upper() + problem[1:].partition(";")[0], "INFO")
        return
    if not own.denoise:
        return
    column.prop(own, "denoise_passes", text="Passes")
    row = column.row()
    row.active = own.denoise_passes != "NONE"
    row.prop(own, "denoise_prefilter", text="Prefilter")
    column.prop(own, "denoise_quality", text="Quality")
    if "denoise_start" in own.bl_rna.properties:
        column.prop(own, "denoise_start")

"""What IWIS reads of a 3D view's shading menu: `space.shading`, its own part `space.shading.iwis`.

The words are Cycles'; Blender's part, scene lights, scene world and studio light, is its own.
"""

from typing import NamedTuple

import bpy
from bpy.props import EnumProperty, PointerProperty

from .export.view_shading import StudioLight, ViewShading
from .passes import MATTES, matte_layer
from .viewport_properties import redraw_views


class ViewPass(NamedTuple):
    """One choice of Render Pass.

    key, name, text: of the menu, "" = as most
    layer: of core.film.LAYERS, denoise.DATA_LAYERS or a matte
    colors: whether it is drawn in false color, over the picture, which need not begin anew
    """

    key: str
    name: str
    layer: str
    colors: bool = False
    text: str = ""


COMBINED = "COMBINED"
# By the menu's headings.
PASSES = {
    "General": (
        ViewPass(COMBINED, "Combined", "combined"),
        ViewPass("EMISSION", "Emission", "emission"),
        ViewPass("BACKGROUND", "Background", "environment"),
        ViewPass("AO", "Ambient Occlusion", "ambient_occlusion"),
        ViewPass("SHADOW_CATCHER", "Shadow Catcher", "shadow_catcher"),
    ),
    "Light": (
        ViewPass("DIFFUSE_DIRECT", "Diffuse Direct", "diffuse_direct"),
        ViewPass("DIFFUSE_COLOR", "Diffuse Color", "diffuse_color"),
        ViewPass("GLOSSY_DIRECT", "Glossy Direct", "glossy_direct"),
        ViewPass("GLOSSY_COLOR", "Glossy Color", "glossy_color"),
    ),
    "Data": (
        ViewPass("POSITION", "Position", "position"),
        ViewPass("NORMAL", "Normal", "normal"),
        ViewPass("UV", "UV", "uv"),
        ViewPass("MIST", "Mist", "mist"),
        ViewPass(
            "DENOISING_ALBEDO",
            "Denoising Albedo",
            "denoising_albedo",
            text="Albedo pass used by denoiser",
        ),
        ViewPass(
            "DENOISING_NORMAL",
            "Denoising Normal",
            "denoising_normal",
            text="Normal pass used by denoiser",
        ),
        ViewPass(
            "SAMPLE_COUNT", "Sample Count", "sample_count", text="Per-pixel number of samples"
        ),
    ),
    "Cryptomatte": tuple(
        ViewPass(
            f"CRYPTO_{kind.upper()}",
            f"Cryptomatte {kind}",
            matte_layer(kind),
            text=f"Show each {kind.lower()} in a color of its own",
        )
        for kind in MATTES
    ),
    "IWIS": (
        ViewPass("SAMPLES", "IWIS Samples", "samples", colors=True),
        ViewPass("ERROR", "IWIS Error", "error", colors=True),
        ViewPass("UNOCCLUDED", "IWIS Unoccluded", "unoccluded"),
        ViewPass("VISIBILITY", "IWIS Visibility", "visibility", colors=True),
    ),
}
_BY_KEY = {each.key: each for rows in PASSES.values() for each in rows}


def _items() -> list[tuple]:
    items = []
    for heading, rows in PASSES.items():
        items.append(("", heading, ""))
        for row in rows:
            colors = ", in false color" if row.colors else ""
            text = row.text or f"Show the {row.name} render pass{colors}"
            items.append((row.key, row.name, text))
    return items


class IWISViewShading(bpy.types.PropertyGroup):
    """IWIS' part of a 3D view's shading."""

    render_pass: EnumProperty(
        name="Render Pass",
        description="Render pass to show in the 3D Viewport",
        items=_items(),
        default=COMBINED,
        update=redraw_views,
    )


def view_shading(shading) -> ViewShading:
    """What a view shows otherwise than a render. shading: Blender's View3DShading"""
    shown = _BY_KEY[shading.iwis.render_pass]
    layer = "" if shown.key == COMBINED else shown.layer
    studio = None
    if not shading.use_scene_world_render:
        light = shading.selected_studio_light
        studio = StudioLight(
            "" if light is None else light.path,
            shading.studiolight_rotate_z,
            shading.studiolight_intensity,
            shading.studiolight_background_alpha,
        )
    return ViewShading(
        lights=shading.use_scene_lights_render,
        studio=studio,
        shown="" if shown.colors else layer,
        colors=layer if shown.colors else "",
    )


def register() -> None:
    bpy.utils.register_class(IWISViewShading)
    bpy.types.View3DShading.iwis = PointerProperty(type=IWISViewShading)


def unregister() -> None:
    del bpy.types.View3DShading.iwis
    bpy.utils.unregister_class(IWISViewShading)

"""A pass in false color over the rendered view, with its legend.

It is drawn where Blender draws its own overlays: after the view transform, so that a color on the
screen is the color of the legend.
"""

from __future__ import annotations

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .false_color import false_color, legend, scale_of
from .job import ENGINE
from .settings import viewport_settings
from .view_picture import make_texture
from .view_shading import view_shading
from .viewport import living

_WIDTH, _HEIGHT = 16, 180
_LEFT, _BELOW = 64, 48  # beside the toolbar
_GROUND = (0.0, 0.0, 0.0, 0.6)  # behind the legend, whose text is white
_state: dict = {"handle": None}
_textures: dict = {}


def colored_layer(scene, shading) -> str:
    """The layer that is drawn over a view, "" = none: of its Render Pass, else the scene's Show."""
    overlay = scene.iwis.viewport.overlay.lower()
    return view_shading(shading).colors or ("" if overlay == "combined" else overlay)


def _draw() -> None:
    """Called by Blender for every 3D view that it draws."""
    context = bpy.context
    scene, space = context.scene, context.space_data
    if scene.render.engine != ENGINE or space.shading.type != "RENDERED":
        return
    layer = colored_layer(scene, space.shading)
    if not layer:
        return
    place = context.region.as_pointer()
    viewport = next((v for v in living() if v.region == place), None)
    picture = None if viewport is None else viewport.thread.picture
    if picture is None or viewport.failure:
        return
    scale = scale_of(layer, viewport_settings(scene))
    key = viewport.thread.version, layer, scale
    if _textures.get(place, (None,))[0] != key:
        _textures[place] = key, make_texture(false_color(picture.layers[layer], scale))
    factor = picture.step * viewport.pixel_size
    x0, y0, x1, y1 = (edge * factor for edge in picture.region)
    draw_texture_2d(_textures[place][1], (x0, y0), x1 - x0, y1 - y0)
    _draw_legend(scale, context.preferences.system.ui_scale)


def _draw_legend(scale, ui) -> None:
    if "legend" not in _textures:
        _textures["legend"] = make_texture(legend(64))
        _textures["ground"] = make_texture(np.float32([[_GROUND]]))
    x, y, height = _LEFT * ui, _BELOW * ui, _HEIGHT * ui
    blf.size(0, 11 * ui)
    texts = [*scale.ticks(), (1.1, scale.title)]
    wide = _WIDTH + 18 + max(blf.dimensions(0, text)[0] for _, text in texts) / ui
    gpu.state.blend_set("ALPHA")
    ground = x - 6 * ui, y - 10 * ui
    draw_texture_2d(_textures["ground"], ground, wide * ui, 1.1 * height + 24 * ui)
    gpu.state.blend_set("NONE")
    draw_texture_2d(_textures["legend"], (x, y), _WIDTH * ui, height)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, 0.0, 0.0, 0.0, 1.0)
    for place, text in texts:
        blf.position(0, x + (_WIDTH + 6) * ui, y + place * height - 4 * ui, 0)
        blf.draw(0, text)
    blf.disable(0, blf.SHADOW)


def register() -> None:
    if not bpy.app.background:
        _state["handle"] = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    if _state["handle"] is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_state["handle"], "WINDOW")
        _state["handle"] = None
    _textures.clear()

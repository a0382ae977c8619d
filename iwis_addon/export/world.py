"""Blender's world to core.scene.EnvironmentMap: one map, one matrix, one strength.

The colour nodes between the first image found and the output are applied to its texels; a second
image counts with its mean, a procedural texture with a mean that was measured. What is not the
same as in Cycles gets a warning that names world and node.
"""

from __future__ import annotations

import bpy
import numpy as np

from ...core.scene import (
    CLOSEST,
    EQUIRECTANGULAR,
    LINEAR,
    LINEAR_SRGB,
    MIRROR_BALL,
    EnvironmentMap,
)
from .color_nodes import evaluate_color_node, luminance
from .image import ImageError
from .node_values import End, follow
from .radiance import STRONGEST, mend_radiance
from .texel_cache import TexelCache
from .world_mapping import lookup_matrix

# Constants are float32 as well: a float64 beside an 8k map would double its memory.
_MISSING = np.array([1.0, 0.0, 1.0], np.float32)  # Cycles' colour of an image that is not there
_BLACK, _WHITE, _GRAY = np.float32([0, 0, 0]), np.float32([1, 1, 1]), np.float32([0.5, 0.5, 0.5])
# Mean radiance over the sphere of the Sky Texture as Blender adds it, rendered with Cycles.
_SKY_MEAN = {
    "PREETHAM": (0.60, 0.68, 1.00),
    "HOSEK_WILKIE": (0.083, 0.155, 0.219),
    "NISHITA": (2.1, 2.1, 2.0),
    "SINGLE_SCATTERING": (2.1, 2.1, 2.0),
    "MULTIPLE_SCATTERING": (1.9, 2.5, 3.5),
}
_IN_PARTS = {
    "MOVIE": "is a movie: only the frame that Blender shows is used",
    "TILED": "has UDIM tiles: only the first is used",
}
# Warnings that mean nothing where lamps light the scene.
NO_LIGHT = "it gives no light: all is black but what emits by itself"
NO_WORLD = "the scene has no world: the background is black; add one in World settings"
_EMITTERS = ("ShaderNodeBackground", "ShaderNodeEmission")


def export_world(
    depsgraph_or_scene, warnings: list[str], cache: TexelCache | None = None
) -> EnvironmentMap:
    """The world's light. Never fails: what cannot be read gets Cycles' colour and a warning.

    warnings: gets one line for each thing that is not as in Cycles
    cache: the same object for every frame of an animation; while the texels stay the same,
        EnvironmentMap.radiance is the same array
    """
    cache = cache or TexelCache()
    cache.start_frame()
    scene = getattr(depsgraph_or_scene, "scene_eval", depsgraph_or_scene)
    world = scene.world
    if world is None:
        warnings.append(NO_WORLD)
        return _uniform(_BLACK, "no world", True)
    # Blender 5 always uses nodes and warns who asks.
    if world.node_tree is None or (bpy.app.version < (5, 0) and not world.use_nodes):
        return _uniform(np.array(world.color, np.float32), world.name, _visible_to_camera(world))
    reader = _WorldReader(world, scene.camera, warnings, cache)
    n_warnings = len(warnings)
    environment = reader.read()
    if len(warnings) == n_warnings and not (
        environment.strength.any() and environment.radiance.any()
    ):
        reader.warn(None, NO_LIGHT)
    return environment


class _WorldReader:
    """Walks one world's nodes; keeps the image it has found and what it had to leave out."""

    def __init__(self, world, camera, warnings, cache):
        self._world = world
        self._camera = camera
        self._warnings = warnings
        self._cache = cache
        self._image: End | None = None  # the output socket of the Environment Texture in use
        self._rgb = None
        self._srgb = False

    def read(self) -> EnvironmentMap:
        output = self._world.node_tree.get_output_node("CYCLES")
        if output is None or follow(output.inputs["Surface"]).node is None:
            self.warn(output, "nothing is linked to the Surface of the World Output: black")
            return self._map(_BLACK, _WHITE)
        if output.inputs["Volume"].is_linked:
            self.warn(output, "the world's volume is not supported: it is left out")
        if _hidden_from(self._world):
            kinds = " and ".join(_hidden_from(self._world))
            self.warn(None, f"ray visibility for {kinds} rays is not supported: they are lit")
        end = follow(output.inputs["Surface"])
        if end.node.bl_idname in _EMITTERS:
            radiance = self._color(end.node.inputs["Color"], end.groups)
            return self._map(radiance, self._strength(end))
        return self._map(self._shader(end), _WHITE)

    def warn(self, node, text):
        """Add a warning that names the world and the node (None: no node), once."""
        where = "" if node is None else f', node "{node.name}"'
        line = f'world "{self._world.name}"{where}: {text}'
        if line not in self._warnings:
            self._warnings.append(line)

    def _map(self, radiance, strength):
        name = self._world.name
        visible = _visible_to_camera(self._world)
        if strength.min() < 0.0 or not np.isfinite(strength).all():
            self.warn(None, f"strength {strength[0]:g} is not a finite number >= 0: 0 is used")
            strength = _BLACK
        elif strength.max() > STRONGEST:
            self.warn(None, f"strength {strength.max():g} is too large: {STRONGEST:g} is used")
            strength = np.minimum(strength, np.float32(STRONGEST))
        if radiance.ndim == 1:
            return _uniform(self._mended(radiance) * strength, name, visible)
        node, groups = self._image.node, self._image.groups
        matrix = lookup_matrix(node, groups, self._constant, self._camera, self.warn)
        mirror_ball = node.projection == "MIRROR_BALL"
        return EnvironmentMap(
            radiance=self._mended(radiance),
            world_to_map=np.ascontiguousarray(matrix, np.float32),
            projection=MIRROR_BALL if mirror_ball else EQUIRECTANGULAR,
            interpolation=self._interpolation(node),
            strength=np.asarray(strength, np.float32),
            visible_to_camera=visible,
            name=node.image.name,
        )

    def _interpolation(self, node):
        if node.interpolation == "Closest":
            return CLOSEST
        if node.interpolation != "Linear":
            self.warn(node, f"{node.interpolation} interpolation is not supported: Linear is used")
        return LINEAR_SRGB if self._srgb else LINEAR

    def _mended(self, radiance):
        """Radiance that can be rendered, float32; what had to be changed becomes a warning."""
        radiance, notes = self._cache.mended(radiance, mend_radiance)
        for note in notes:
            if self._image is None:
                self.warn(None, f"its colour {note}")
            else:
                self.warn(self._image.node, f'image "{self._image.node.image.name}": {note}')
        return radiance

    def _shader(self, end):
        """Radiance of a shader or colour, float (3,) or (h, w, 3)."""
        node = end.node
        if node is None:
            return _BLACK
        if end.socket.type != "SHADER":
            return self._output_color(end)
        if node.bl_idname in _EMITTERS:
            return self._color(node.inputs["Color"], end.groups) * self._strength(end)
        if node.bl_idname in ("ShaderNodeAddShader", "ShaderNodeMixShader"):
            first, second = (follow(s, end.groups) for s in node.inputs if s.type == "SHADER")
            if node.bl_idname == "ShaderNodeAddShader":
                return self._shader(first) + self._shader(second)
            factor = float(np.clip(self._constant(node.inputs[0], end.groups)[0], 0.0, 1.0))
            light = self._shader(first) * (1.0 - factor) if factor < 1.0 else _BLACK
            return light + self._shader(second) * factor if factor > 0.0 else light
        return self._unsupported(end)

    def _strength(self, end):
        return self._constant(end.node.inputs["Strength"], end.groups)

    def _constant(self, socket, groups):
        """float (3,): the colour behind a socket; the mean of what varies, with a warning."""
        value = self._color(socket, groups)
        if value.ndim > 1:
            self.warn(socket.node, f"{socket.name} varies over the world: its mean is used")
            value = _mean(value)
        return value

    def _color(self, socket, groups):
        """Colour behind an input socket, float (3,) or (h, w, 3); a number as three equal ones."""
        end = follow(socket, groups)
        value = _default(end.socket) if end.node is None else self._output_color(end)
        if socket.type == "VALUE" and end.socket.type == "RGBA":
            return luminance(value)
        if socket.type == "VALUE" and end.socket.type == "VECTOR":
            return np.repeat(value.mean(axis=-1, keepdims=True), 3, -1)
        return value

    def _output_color(self, end):
        node, kind = end.node, end.node.bl_idname
        if kind in ("ShaderNodeRGB", "ShaderNodeValue"):
            return _default(end.socket)
        if kind == "ShaderNodeTexEnvironment":
            return self._environment_texture(end)
        if kind == "ShaderNodeTexImage":
            self.warn(node, "an Image Texture has no direction: its mean; use Environment Texture")
            return _mean(self._texels(node)[0])
        if kind == "ShaderNodeTexSky":
            mean = _SKY_MEAN.get(node.sky_type, _WHITE)
            self.warn(node, f"the sky is not supported yet: one colour, {tuple(mean)}; bake it")
            return np.array(mean, np.float32)
        if kind == "ShaderNodeLightPath":
            self.warn(node, f"{end.socket.name} is 0: the world looks the same to all rays")
            return _BLACK
        value = evaluate_color_node(node, lambda name: self._input(end, name))
        return self._unsupported(end) if value is None else value

    def _input(self, end, identifier):
        socket = next(s for s in end.node.inputs if s.identifier == identifier)
        return self._color(socket, end.groups)

    def _unsupported(self, end):
        """The colour that goes into a node that is not supported, or gray."""
        for socket in end.node.inputs:
            inner = follow(socket, end.groups)
            if inner.node is not None and socket.type in ("RGBA", "SHADER"):
                self.warn(end.node, f'{end.node.bl_label} is skipped: "{socket.name}" is used')
                return self._shader(inner)
        colors = [_default(s) for s in end.node.inputs if s.type == "RGBA"]
        gray = colors[0] if end.socket.type == "SHADER" and colors else _GRAY
        text = ", ".join(f"{c:.3g}" for c in gray)
        self.warn(end.node, f"{end.node.bl_label} is not supported: one colour, ({text}), is used")
        return gray

    def _environment_texture(self, end):
        node = end.node
        if self._image is not None and (self._image.node, self._image.groups) != (node, end.groups):
            self.warn(node, "only one image is supported: this one counts with its mean colour")
            return _mean(self._texels(node)[0])
        if self._image is None:
            rgb, self._srgb = self._texels(node)
            if rgb.size == 3:
                return rgb[0, 0]
            self._image, self._rgb = end, rgb
        return self._rgb

    def _texels(self, node):
        """(rgb, srgb interpolation) of a texture node; one pink texel where it cannot be read."""
        image = node.image
        try:
            if image is not None and image.source in _IN_PARTS:
                self.warn(node, f'image "{image.name}" {_IN_PARTS[image.source]}')
            return self._cache.read(image, node.image_user)
        except ImageError as error:
            self.warn(node, f"{error}. Pink instead, as in Cycles")
            return _MISSING.reshape(1, 1, 3), False


def _hidden_from(world) -> list[str]:
    """Kinds of rays that the world is hidden from in Cycles, and that it lights here."""
    visibility = getattr(world, "cycles_visibility", None)
    return [kind for kind in ("diffuse", "glossy") if not getattr(visibility, kind, True)]


def _visible_to_camera(world) -> bool:
    """Ray visibility belongs to Cycles' settings, there as long as its add-on is enabled."""
    visibility = getattr(world, "cycles_visibility", None)
    return True if visibility is None else visibility.camera


def _mean(rgb) -> np.ndarray:
    """float32 (3,) of (h, w, 3), summed in float64."""
    return rgb.mean(axis=(0, 1), dtype=np.float64).astype(np.float32)


def _default(socket) -> np.ndarray:
    """float32 (3,) of a socket's own value."""
    value = getattr(socket, "default_value", 0.0)
    if isinstance(value, (bool, int, float)):
        return np.full(3, value, np.float32)
    return np.array(value[:3], np.float32)


def _uniform(color, name, visible) -> EnvironmentMap:
    """A world of one colour: a map of one white texel, times the colour."""
    return EnvironmentMap(
        radiance=np.ones((1, 1, 3), np.float32),
        strength=np.asarray(color, np.float32),
        visible_to_camera=visible,
        name=name,
    )

"""Bakes: what surfaces show, or what they are, at each texel of an image.

A render whose camera is replaced by the points of the texels (bake_rays.py); its layers then become
what is asked for. The kinds and their parts are Cycles' [Blender's manual, Render Baking].
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from .data.asked_passes import NO_PASSES
from .data.bake_points import BakePoints
from .data.lamps import BY_CAMERA, NO_LAMPS
from .film import Progress, Tile, TileSink
from .render import render
from .render_cache import RenderCache
from .scene import CAMERA_RAYS, SHADOW_RAYS, EnvironmentMap, Scene
from .settings import RenderSettings
from .stats import RenderStats
from .surfaces.backdrop import Backdrop

# What needs light, and what does not.
LIT = ("COMBINED", "DIFFUSE", "GLOSSY", "SHADOW")
UNLIT = ("AO", "EMIT", "ENVIRONMENT", "NORMAL", "POSITION", "ROUGHNESS", "UV")
_BY_ALPHA = ("AO", "EMIT")  # of UNLIT, what counts by it
_POINTS = 16  # of each texel, where there is no light to be sampled


class Wish(NamedTuple):
    """What is to be baked: one of LIT or UNLIT.

    parts: of COMBINED: DIRECT with DIFFUSE and GLOSSY, EMIT; of DIFFUSE and GLOSSY: DIRECT, COLOR
    """

    kind: str
    parts: frozenset[str] = frozenset({"DIRECT", "COLOR", "DIFFUSE", "GLOSSY", "EMIT"})


def bake(
    scene: Scene,
    points: BakePoints,
    wish: Wish,
    settings: RenderSettings,
    sink: TileSink,
    cache: RenderCache | None = None,
) -> tuple[np.ndarray, RenderStats]:
    """float32 (h, w, 4), row 0 at the bottom, as Blender takes it, and what it cost.

    Alpha is that of the surfaces, where light is baked; normals are in world space. The sink hears
    of the progress and is asked for a cancel, after which what is not done is black; it gets no
    tiles. scene.asked is to have what AO and UV ask for.
    """
    cache = cache or RenderCache()
    own = _seen_at(scene, points, wish.kind)
    if wish.kind in UNLIT:
        own, settings = _without_light(own, wish.kind), _few_samples(settings)
    elif settings.pixel_filter != "CENTER":
        settings = dataclasses.replace(settings, pixel_filter="BOX")
    world = None
    if wish.kind == "ENVIRONMENT":
        world = cache.backdrop(scene) or Backdrop(scene.environment)
    taker = _Taker(points, wish, world, sink)
    stats = render(own, settings, taker, cache)
    if wish.kind == "SHADOW" and not stats.cancelled:
        lit, taker = taker.picture, _Taker(points, wish, world, sink)
        stats.cancelled = render(_without_shadows(own), settings, taker, cache).cancelled
        share = _share(lit[..., :3], taker.picture[..., :3])
        taker.picture[..., :3] = np.where(lit[..., 3:] > 0.0, share, np.float32(0.0))
    return taker.picture, stats


def _seen_at(scene: Scene, points: BakePoints, kind: str) -> Scene:
    """The scene with the points in place of its camera, and no lamp that is seen itself."""
    height, width = points.triangle.shape
    camera = dataclasses.replace(
        scene.camera,
        width=width,
        height=height,
        region=(0, 0, width, height),
        lens=None,
        motion=None,
        bake=points,
    )
    asked, lamps = scene.asked, scene.lamps
    return dataclasses.replace(
        scene,
        camera=camera,
        transparent_film=True,
        motion=None,
        pixel_motion=None,
        lamps=lamps._replace(seen_by=lamps.seen_by & ~np.int8(BY_CAMERA)),
        asked=NO_PASSES._replace(
            occlusion_distance=asked.occlusion_distance if kind == "AO" else 0.0,
            uv=asked.uv if kind == "UV" else None,
            roughness=kind == "ROUGHNESS",
        ),
    )


def _without_light(scene: Scene, kind: str) -> Scene:
    """Nor with anything that is clear, where that says nothing."""
    dark = EnvironmentMap(radiance=np.zeros((1, 1, 3), np.float32), name="darkness")
    shaders = scene.shaders
    if shaders is not None and kind not in _BY_ALPHA:
        programs = (p and dataclasses.replace(p, transparent=None) for p in shaders.programs)
        shaders = dataclasses.replace(shaders, programs=tuple(programs))
    return dataclasses.replace(
        scene, environment=dark, backdrop=None, lamps=NO_LAMPS, lamp_links=(), shaders=shaders
    )


def _without_shadows(scene: Scene) -> Scene:
    flags = scene.object_flags
    if flags is None:
        flags = np.full(len(scene.object_pass_index), CAMERA_RAYS, np.uint8)
    return dataclasses.replace(scene, object_flags=flags & ~np.uint8(SHADOW_RAYS))


def _few_samples(settings: RenderSettings) -> RenderSettings:
    if settings.pixel_filter == "CENTER":
        return dataclasses.replace(settings, stop_rule="FIXED", max_samples=1)
    return dataclasses.replace(
        settings, stop_rule="FIXED", pixel_filter="BOX", max_samples=_POINTS, batch_size=1
    )


def _share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """part / whole, 0 to 1; what is black anyway is in no shadow."""
    share = np.divide(part, whole, out=np.ones_like(part), where=whole > 0.0)
    return np.clip(share, 0.0, 1.0)


class _Taker:
    """The sink of the render: makes each tile's part of the picture out of its layers."""

    def __init__(self, points: BakePoints, wish: Wish, world: Backdrop | None, sink: TileSink):
        self._points, self._wish, self._world, self._sink = points, wish, world, sink
        self.picture = np.zeros((*points.triangle.shape, 4), np.float32)

    def write_tile(self, tile: Tile) -> None:
        place = slice(tile.y, tile.y + tile.height), slice(tile.x, tile.x + tile.width)
        there = self._points.triangle[place] >= 0
        part = baked(self._wish, tile.layers, self._world)
        self.picture[place] = np.where(there[..., None], part, np.float32(0.0))

    def progress(self, progress: Progress) -> None:
        self._sink.progress(progress)

    def cancelled(self) -> bool:
        return self._sink.cancelled()


def baked(wish: Wish, layers: dict[str, np.ndarray], world: Backdrop | None = None) -> np.ndarray:
    """float32 (h, w, 4): what is wished for of the layers of a picture. world: of ENVIRONMENT"""
    kind, opaque = wish.kind, np.ones_like(layers["depth"])
    alpha = layers["combined"][..., 3:] if kind in ("COMBINED", "DIFFUSE", "GLOSSY") else opaque
    return np.concatenate([_color(wish, layers, world), alpha], axis=2, dtype=np.float32)


def _color(wish: Wish, layers, world) -> np.ndarray:
    kind, parts = wish
    if kind == "COMBINED":
        picture = layers["emission"] if "EMIT" in parts else np.zeros_like(layers["emission"])
        for lobe in ("DIFFUSE", "GLOSSY"):
            if lobe in parts and "DIRECT" in parts:
                picture = picture + _light(lobe, layers) * _color_of(lobe, layers)
        return picture
    if kind in ("DIFFUSE", "GLOSSY"):
        if "DIRECT" not in parts:
            color = _color_of(kind, layers)
            return color if "COLOR" in parts else np.zeros_like(color)
        light = _light(kind, layers)
        return light * _color_of(kind, layers) if "COLOR" in parts else light
    if kind == "SHADOW":
        return layers["combined"][..., :3]
    if kind == "ENVIRONMENT":
        return _world_seen(layers["position"], world)
    return _surface(kind, layers)


def _surface(kind: str, layers) -> np.ndarray:
    """What needs no light at all."""
    if kind == "NORMAL":
        return _unit(layers["normal"])
    if kind == "UV":
        return np.concatenate([layers["uv"][..., :2], np.ones_like(layers["depth"])], axis=2)
    if kind == "ROUGHNESS":
        return np.repeat(layers["roughness"], 3, axis=2)
    return layers[{"AO": "ambient_occlusion", "EMIT": "emission", "POSITION": "position"}[kind]]


def _light(lobe: str, layers) -> np.ndarray:
    return layers[f"{lobe.lower()}_direct"]


def _color_of(lobe: str, layers) -> np.ndarray:
    return layers[f"{lobe.lower()}_color"]


def _world_seen(position: np.ndarray, world: Backdrop) -> np.ndarray:
    """The world's radiance as seen from the origin towards positions, as Cycles bakes it."""
    directions = np.ascontiguousarray(_unit(position).reshape(-1, 3))
    return world.radiance(directions).reshape(position.shape)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=2, keepdims=True)
    return vectors / np.where(length > 0.0, length, np.float32(1.0))

"""Lamps whose nodes vary over them: their pictures, and the rows that show these."""

from __future__ import annotations

import functools
import math

import numpy as np

from ...core.lamps import ELLIPSE, PLANE_EDGE, RECTANGLE, SPHERE
from ...core.nodes.ies import IES
from ...core.nodes.lamp_map import LampPlaces, lamp_picture
from ...core.nodes.world_map import reached_ops
from ...core.program import ImageTiles
from ...core.scene import Camera
from .texel_cache import TexelCache

_OF_THE_VIEW = ("ShaderNodeCameraData", "ShaderNodeLightPath", "ShaderNodeVectorTransform")
_LEAST, _MOST = 256, 1024  # texels along a side
_WIDEST = math.radians(89.99)  # half a spot's angle: the tangent of a right one is none
_LUMINANCE = np.float32([0.2126, 0.7152, 0.0722])


def places_of(light, kind: int, matrix: np.ndarray) -> LampPlaces | None:
    """Where the light of an area, point or spot leaves; None: it is too far away to tell.

    kind: of core.lamps; matrix: float64 (4, 4), to the world
    """
    if kind in (RECTANGLE, ELLIPSE):
        height = light.size if light.shape in ("SQUARE", "DISK") else light.size_y
        return LampPlaces(matrix, width=light.size, height=height, flat=True)
    if light.type not in ("POINT", "SPOT"):
        return None
    radius = light.shadow_soft_size if kind == SPHERE else 0.0
    if light.type == "POINT":
        return LampPlaces(matrix, radius=radius)
    half = min(0.5 * light.spot_size, _WIDEST)
    return LampPlaces(matrix, radius=radius, slope=math.tan(half), flat=math.cos(half) > PLANE_EDGE)


def with_pictures(
    rows: list[dict], camera: Camera, cache: TexelCache | None = None
) -> tuple[list[dict], np.ndarray]:
    """The rows of lamps for make_lamps, and Lamps.texels.

    rows: of read_lamp; "light" and "places" of those that vary become "picture", and their mean
    a part of their radiance. What is dark is left out. cache: of the job: a picture is made anew
    where its lamp has changed
    """
    cache = cache or TexelCache()
    made, texels, end = [], [np.zeros((0, 3), np.float32)], 0
    for number, row in enumerate(rows):
        if "light" not in row:
            made.append(row)
            continue
        row = dict(row)
        light, places = row.pop("light"), row.pop("places")
        program, value = light
        ops = reached_ops(program, value).values()
        side = _side(ops)
        if any(op.kind == IES for op in ops):
            flat = places.flat and places.slope > 0.0
            places = places._replace(by_direction=True, flat=flat)
        size = (side, side) if places.flat else (2 * side, side)
        seen = camera if any(map(_asks_for_view, ops)) else None
        make = functools.partial(lamp_picture, program, value, places, camera, *size)
        picture = cache.kept(("lamp", number), (light, places, size, seen), make).reshape(-1, 3)
        mean = float((picture @ _LUMINANCE).mean(dtype=np.float64))
        if not mean > 0.0:
            continue
        row["radiance"] = np.multiply(row["radiance"], mean)
        made.append(row | {"picture": (end, *size, places.by_direction)})
        texels.append(picture / np.float32(mean))
        end += len(picture)
    return made, np.concatenate(texels)


def _asks_for_view(op) -> bool:
    """Whether what an operation gives depends on the camera."""
    if op.kind == "ShaderNodeTexCoord":
        return bool(op.settings["outputs"] & {"Camera", "Window"})
    return op.kind in _OF_THE_VIEW


def _side(ops) -> int:
    """Texels along a picture's side: as many as the largest image has that it shows."""
    sides = [_LEAST]
    for op in ops:
        for tiles in op.settings.values():
            if isinstance(tiles, ImageTiles):
                sides += [max(texels.shape[:2]) for texels in tiles.tiles.values()]
    return min(max(sides), _MOST)

"""Lamps whose nodes vary over them: their pictures, and the rows that show these."""

from __future__ import annotations

import functools
import math

import numpy as np

from ....core.data.channels import LUMINANCE
from ....core.data.lamps import BEAM, DISC, PLANE_EDGE, ROUND_BEAM, SPHERE
from ....core.data.program import ImageTiles, Op
from ....core.nodes.falloff import asks_for_distance
from ....core.nodes.ies import IES
from ....core.nodes.lamp_map import LampPlaces, even_color, lamp_falloff, lamp_picture
from ....core.nodes.world_map import reached_ops
from ....core.scene import Camera
from ..images.texel_cache import TexelCache
from .lamp_nodes import LampLight, LampReader

_OF_THE_VIEW = ("ShaderNodeCameraData", "ShaderNodeVectorTransform")
_MANY = (
    "its light changes with the distance otherwise in one place than in another:"
    " as in its brightest ones"
)
_LEAST, _MOST = 256, 1024  # texels along a side
_WIDEST = math.radians(89.99)  # half a spot's angle: the tangent of a right one is none


def places_of(light, kind: int, matrix: np.ndarray, own: LampLight) -> LampPlaces:
    """Where a light leaves.

    kind: of core.lamps; matrix: float64 (4, 4), to the world; own: what the light's nodes come to
    """
    ops = ops_of(own)
    by_direction = any(op.kind == IES for op in ops)
    if light.type == "AREA":
        height = light.size if light.shape in ("SQUARE", "DISK") else light.size_y
        own_map = LampPlaces(matrix, width=light.size, height=height, flat=True)
        return own_map._replace(by_direction=True, flat=False) if by_direction else own_map
    if light.type == "SUN":
        return LampPlaces(matrix, radius=1.0)  # any places that differ
    radius = light.shadow_soft_size if kind == SPHERE else 0.0
    disc = light.shadow_soft_size if kind == DISC and any(map(asks_for_place, ops)) else 0.0
    if light.type == "POINT":
        return LampPlaces(matrix, radius=radius, by_direction=by_direction, disc=disc)
    half = min(0.5 * light.spot_size, _WIDEST)
    # A spot's UV map is by the direction to what it lights, wherever on its ball a ray begins.
    by_direction = by_direction or any(map(asks_for_uv, ops))
    flat = math.cos(half) > PLANE_EDGE and (by_direction or radius == 0.0)
    slope = math.tan(half)
    own = LampPlaces(matrix, radius=radius, slope=slope, flat=flat, by_direction=by_direction)
    return own._replace(disc=disc)


def asks_for_uv(op: Op) -> bool:
    """Whether an operation looks at the UV map of a lamp."""
    if op.kind == "ShaderNodeTexImage":
        return "Vector" not in op.inputs
    outputs = op.settings.get("outputs", ())
    return op.kind == "ShaderNodeUVMap" or "UV" in outputs or "Parametric" in outputs


def asks_for_place(op: Op) -> bool:
    """Whether an operation looks at where on a lamp light leaves, beside its UV map."""
    if op.kind in ("ShaderNodeTexCoord", "ShaderNodeNewGeometry"):
        return bool(op.settings["outputs"] - {"UV", "Parametric", "Incoming"})
    return op.kind.startswith("ShaderNodeTex") and not (asks_for_uv(op) or "Vector" in op.inputs)


def ops_of(light: LampLight) -> list[Op]:
    """The operations that its colour depends on."""
    return list(reached_ops(*light).values())


def color_of(light: LampLight, places: LampPlaces, distance: float) -> np.ndarray | None:
    """float32 (3,): what nodes give at a distance if it is the same all over a lamp, and however
    it is looked at; else None."""
    if any(map(_asks_for_view, ops_of(light))):
        return None
    return even_color(*light, places, None, distance)


def with_pictures(
    rows: list[dict],
    camera: Camera,
    cache: TexelCache | None = None,
    warnings: list[str] | None = None,
) -> tuple[list[dict], np.ndarray]:
    """The rows of lamps for make_lamps, and Lamps.texels.

    rows: of read_lamp; "light", "places" and "named" of those that vary become "picture" and
    "falloff", and their mean a part of their radiance. What is dark is left out. cache: of the job:
    what is made of a lamp is made anew where it has changed; warnings: get what cannot be shown
    """
    cache, warnings = cache or TexelCache(), [] if warnings is None else warnings
    made, texels, end = [], [np.zeros((0, 3), np.float32)], 0
    for number, row in enumerate(rows):
        if "light" in row:
            row, picture = _shown(number, dict(row), camera, cache, warnings)
            if picture is not None:
                row["picture"] = (end, *row["picture"])
                texels.append(picture)
                end += len(picture)
        if np.any(row["radiance"]):
            made.append(row)
    return made, np.concatenate(texels)


def _shown(number, row, camera, cache, warnings) -> tuple[dict, np.ndarray | None]:
    """A row of make_lamps, of whose picture the first texel is missing, and its texels, or None."""
    light, places, named = row.pop("light"), row.pop("places"), row.pop("named")
    ops = ops_of(light)
    seen = camera if any(map(_asks_for_view, ops)) else None
    distance = 1.0
    if asks_for_distance(ops):
        find = functools.partial(lamp_falloff, *light, places, camera)
        falloff = cache.kept(("lamp's falloff", number), (light, places, seen), find)
        row["falloff"], distance = falloff.table, falloff.distance
        if (falloff.even and falloff.whole) or row["kind"] in (BEAM, ROUND_BEAM):
            row["radiance"] = row["radiance"] * falloff.color
            return row, None
        if not falloff.whole:
            LampReader(*named, warnings).warn(None, _MANY)
    side = _side(ops)
    size = (side, side) if places.flat else (2 * side, side)
    make = functools.partial(lamp_picture, *light, places, camera, *size, distance)
    source = light, places, size, seen, distance
    picture = cache.kept(("lamp", number), source, make).reshape(-1, 3)
    mean = float((picture @ LUMINANCE).mean(dtype=np.float64))
    row["radiance"] = np.multiply(row["radiance"], mean)
    row["picture"] = (*size, places.by_direction)
    return row, picture / np.float32(mean) if mean > 0.0 else None


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

"""Sums of a tile's points -> the layers of the film."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import Lobes
from ..bsdf.luminance import luminance
from ..bsdf.sheen import diffuse_color
from ..camera.camera import view_depth
from ..data.rows import any_in_row
from ..film import NO_DEPTH, new_layers
from ..geometry.shading import ShadingPoints
from ..sampling.incremental import PixelSums
from ..scene import Scene
from ..see_through.cutouts import opacity_of
from ..surfaces.backdrop import Backdrop
from .catchers import are_whole_holes
from .pass_sums import PassSums


class PlacedPoints(NamedTuple):
    """The points that a tile's rays hit; place: int32 (n,), pixels of the tile, -1 = outside;
    normal: float32 (n, 3), for the pass of that name; data_place: as place, for depth, position and
    indices."""

    points: ShadingPoints
    lobes: Lobes
    place: np.ndarray
    normal: np.ndarray
    data_place: np.ndarray


class MissedRays(NamedTuple):
    """The rays that see the world, or nothing.

    place: their pixels, as PlacedPoints.place; directions: float32 (n, 3), zeros = nothing;
    through: as ShadingPoints.through
    """

    place: np.ndarray
    directions: np.ndarray
    through: np.ndarray


class PointLayers(NamedTuple):
    """film.LAYERS of a tile, float32 (pixels, channels) each, as kernels take them."""

    combined: np.ndarray
    depth: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    object_index: np.ndarray
    material_index: np.ndarray
    environment: np.ndarray
    emission: np.ndarray
    diffuse_direct: np.ndarray
    diffuse_color: np.ndarray
    glossy_direct: np.ndarray
    glossy_color: np.ndarray
    sample_count: np.ndarray
    samples: np.ndarray
    error: np.ndarray
    unoccluded: np.ndarray
    visibility: np.ndarray


@kernel(forceinline=True)
def _divide(light, color):
    """light / color where color is not black: Cycles' direct passes are without their colour."""
    return light / np.float64(color) if color > 0.0 else 0.0


@kernel(forceinline=True)
def _visibility(sums, p):
    """I_d / I_s: the part of the light that arrives; of luminance, float64."""
    d, g, whole = sums.diffuse, sums.glossy, sums.unoccluded
    seen = luminance(d[p, 0] + g[p, 0], d[p, 1] + g[p, 1], d[p, 2] + g[p, 2])
    light = luminance(whole[p, 0], whole[p, 1], whole[p, 2])
    return min(seen / light, 1.0) if light > 0.0 else 0.0


@kernel
def _visibilities(sums, out):
    for p in range(len(out)):
        out[p] = _visibility(sums, p)


@kernel
def _write_points(place, normal, lobes, sums, exposure, max_samples, layers):
    for p in range(len(place)):
        k = place[p]
        if k < 0:
            continue
        count = max(sums.count[p], 1)
        scale = exposure / count
        for a in range(3):
            diffuse, glossy = sums.diffuse[p, a] * scale, sums.glossy[p, a] * scale
            emission = np.float64(lobes.emission[p, a]) * exposure
            layers.combined[k, a] = diffuse + glossy + emission
            layers.normal[k, a], layers.emission[k, a] = normal[p, a], emission
            color = diffuse_color(lobes, p, a)
            layers.diffuse_direct[k, a] = _divide(diffuse, color)
            layers.diffuse_color[k, a] = color
            layers.glossy_direct[k, a] = _divide(glossy, lobes.glossy_color[p, a])
            layers.glossy_color[k, a] = lobes.glossy_color[p, a]
            layers.unoccluded[k, a] = sums.unoccluded[p, a] * scale
        layers.combined[k, 3] = 1.0
        layers.sample_count[k, 0] = np.float64(sums.count[p]) / max_samples
        layers.samples[k, 0] = sums.count[p]
        layers.error[k, 0] = sums.error[p] if np.isfinite(sums.error[p]) else 0.0
        layers.visibility[k, 0] = _visibility(sums, p)


def develop_points(
    scene: Scene,
    world: Backdrop,
    seen: PlacedPoints,
    missed: MissedRays,
    sums: PixelSums,
    size: tuple[int, int],
    max_samples: int,
) -> dict[str, np.ndarray]:
    """The layers of a tile whose pixels have one shading point each.

    world: what is behind all; size: (width, height)
    """
    layers = new_layers(*size)
    flat = PointLayers(*(_flat(layers, name) for name in PointLayers._fields))
    flat.depth[:] = NO_DEPTH
    layers["shadow_catcher"][:] = 1.0
    _write_background(scene, world, missed, flat)
    write_geometry(layers, scene, seen.points, seen.data_place)
    own = seen.normal, seen.lobes, sums
    _write_points(seen.place, *own, float(scene.exposure), max_samples, flat)
    return layers


def _write_background(scene, world, missed, flat) -> None:
    looks = any_in_row(missed.directions)
    inside = (missed.place >= 0) & looks
    place = missed.place[inside]
    flat.combined[missed.place[(missed.place >= 0) & ~looks], 3] = 1.0
    if not len(place):
        return
    if scene.environment.visible_to_camera:
        radiance = world.radiance(missed.directions[inside]) * missed.through[inside]
        radiance *= np.float32(scene.exposure)
        flat.environment[place] = radiance
        if not scene.transparent_film:
            flat.combined[place, :3] = radiance
    flat.combined[place, 3] = 1.0
    if scene.transparent_film:
        film = opacity_of(missed.through[inside])
        flat.combined[place, 3] = np.maximum(film, np.float32(0.0))


def filtered_layers(
    scene: Scene, points: ShadingPoints, sums: PassSums, size, max_samples: int
) -> dict[str, np.ndarray]:
    """The layers of a tile whose pixels average several shading points.

    points: at the pixels' centres; sums: of the tile's pixels, row by row; size: (width, height)
    """
    layers = new_layers(*size)
    layers["depth"][:] = NO_DEPTH
    layers["shadow_catcher"][:] = 1.0
    write_geometry(layers, scene, points, points.pixel)
    passes = np.maximum(sums.passes, 1)[:, None]
    visibility = np.empty(len(passes))
    _visibilities(sums, visibility)
    light = {
        name: getattr(sums, name) / passes * np.float64(scene.exposure)
        for name in ("diffuse", "glossy", "emission", "environment", "unoccluded")
    }
    values = {
        name: getattr(sums, name) / passes for name in ("normal", "diffuse_color", "glossy_color")
    }
    values |= {
        "emission": light["emission"],
        "environment": light["environment"],
        "unoccluded": light["unoccluded"],
        "diffuse_direct": _divided(light["diffuse"], values["diffuse_color"]),
        "glossy_direct": _divided(light["glossy"], values["glossy_color"]),
        "sample_count": sums.count[:, None] / max_samples,
        "samples": sums.count[:, None],
        "error": np.where(np.isfinite(sums.error), sums.error, 0.0)[:, None],
        "visibility": visibility[:, None],
    }
    for name, value in values.items():
        _flat(layers, name)[:] = value
    combined = _flat(layers, "combined")
    combined[:, :3] = light["diffuse"] + light["glossy"] + light["emission"]
    combined[:, 3] = np.clip((sums.hits + sums.opaque) / passes[:, 0], 0.0, 1.0)
    if not scene.transparent_film:
        combined[:, :3] += values["environment"]
    return layers


def write_geometry(layers, scene, points, place) -> None:
    """Depth, position and indices: of the points, whatever the pixel filter, as in Cycles.

    Holdouts have none, as what is behind all.
    place: int32 (n,), their pixels' rows in the layers, -1 = outside
    """
    mesh = scene.mesh
    holes = are_whole_holes(scene, points)
    if holes.any():
        place = np.where(holes, np.int32(-1), place)
    names = ("depth", "position", "object_index", "material_index")
    _write_places(
        place,
        points.triangle,
        points.position,
        view_depth(scene.camera, points.position),
        (mesh.object_index, mesh.material_index),
        (scene.object_pass_index, scene.material_pass_index),
        tuple(_flat(layers, name) for name in names),
    )


@kernel
def _write_places(place, triangle, position, depth, of_triangles, indices, layers):
    """of_triangles: rows of objects and materials; indices: what is written of them."""
    objects, materials = of_triangles
    object_index, material_index = indices
    depths, positions, shown_objects, shown_materials = layers
    for k in range(len(place)):
        row, hit = place[k], triangle[k]
        if row < 0:
            continue
        depths[row, 0] = depth[k]
        for a in range(3):
            positions[row, a] = position[k, a]
        shown_objects[row, 0] = object_index[objects[hit]]
        shown_materials[row, 0] = material_index[materials[hit]]


def _divided(light, color):
    """light / color where color is not black: Cycles' direct passes are without their colour."""
    return np.divide(light, color, out=np.zeros_like(light), where=color > 0.0)


def _flat(layers, name):
    layer = layers[name]
    return layer.reshape(-1, layer.shape[2])

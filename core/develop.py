"""Sums of a tile's points -> the layers of the film."""

from __future__ import annotations

import numpy as np

from .camera import planar_depth
from .environment import EnvironmentLookup, eval_environment_many
from .film import new_layers
from .incremental import PixelSums
from .lobes import Lobes
from .pass_sums import PassSums
from .scene import Scene
from .shading import ShadingPoints

NO_DEPTH = 1e10  # what Cycles writes where nothing is hit


def background_layers(
    scene: Scene, lookup: EnvironmentLookup, directions: np.ndarray, missed: np.ndarray, size
) -> dict[str, np.ndarray]:
    """The layers of a tile that sees nothing but the world.

    directions: float32 (n, 3) of all the tile's rays; missed: bool (n,); size: (width, height)
    """
    layers = new_layers(*size)
    layers["depth"][:] = NO_DEPTH
    if not missed.any():
        return layers
    if scene.environment.visible_to_camera:
        radiance = np.empty((int(missed.sum()), 3), np.float32)
        eval_environment_many(lookup, np.ascontiguousarray(directions[missed]), radiance)
        radiance *= np.float32(scene.exposure)
        _flat(layers, "environment")[missed] = radiance
        if not scene.transparent_film:
            _flat(layers, "combined")[missed, :3] = radiance
    if not scene.transparent_film:
        _flat(layers, "combined")[missed, 3] = 1.0
    return layers


def add_points(
    layers: dict[str, np.ndarray],
    scene: Scene,
    points: ShadingPoints,
    lobes: Lobes,
    sums: PixelSums,
    max_samples: int,
) -> None:
    """Write the tile's shading points into its layers."""
    pixel = points.pixel
    count = np.maximum(sums.count, 1)[:, None]
    exposure = scene.exposure
    diffuse = sums.diffuse / count * exposure
    glossy = sums.glossy / count * exposure
    _write_geometry(layers, scene, points)
    values = {
        "normal": points.normal,
        "emission": lobes.emission * exposure,
        "diffuse_direct": _divided(diffuse, lobes.diffuse),
        "diffuse_color": lobes.diffuse,
        "glossy_direct": _divided(glossy, lobes.glossy_color),
        "glossy_color": lobes.glossy_color,
        "sample_count": sums.count[:, None] / max_samples,
        "samples": sums.count[:, None],
        "error": np.where(np.isfinite(sums.error), sums.error, 0.0)[:, None],
        "unoccluded": sums.unoccluded / count * exposure,
        "visibility": sums.visible[:, None] / count,
    }
    for name, value in values.items():
        _flat(layers, name)[pixel] = value
    combined = _flat(layers, "combined")
    combined[pixel, :3] = diffuse + glossy + lobes.emission * exposure
    combined[pixel, 3] = 1.0


def filtered_layers(
    scene: Scene, points: ShadingPoints, sums: PassSums, size, max_samples: int
) -> dict[str, np.ndarray]:
    """The layers of a tile whose pixels average several shading points.

    points: at the pixels' centres; sums: of the tile's pixels, row by row; size: (width, height)
    """
    layers = new_layers(*size)
    layers["depth"][:] = NO_DEPTH
    _write_geometry(layers, scene, points)
    passes = np.maximum(sums.passes, 1)[:, None]
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
        "visibility": (sums.visible / np.maximum(sums.count, 1))[:, None],
    }
    for name, value in values.items():
        _flat(layers, name)[:] = value
    combined = _flat(layers, "combined")
    combined[:, :3] = light["diffuse"] + light["glossy"] + light["emission"]
    if scene.transparent_film:
        combined[:, 3] = sums.hits / passes[:, 0]
    else:
        combined[:, :3] += values["environment"]
        combined[:, 3] = 1.0
    return layers


def _write_geometry(layers, scene, points) -> None:
    """Depth, position and indices: of the points, whatever the pixel filter, as in Cycles."""
    objects = scene.mesh.object_index[points.triangle]
    materials = scene.mesh.material_index[points.triangle]
    values = {
        "depth": planar_depth(scene.camera, points.position)[:, None],
        "position": points.position,
        "object_index": scene.object_pass_index[objects][:, None],
        "material_index": scene.material_pass_index[materials][:, None],
    }
    for name, value in values.items():
        _flat(layers, name)[points.pixel] = value


def _divided(light, color):
    """light / color where color is not black: Cycles' direct passes are without their colour."""
    return np.divide(light, color, out=np.zeros_like(light), where=color > 0.0)


def _flat(layers, name):
    layer = layers[name]
    return layer.reshape(-1, layer.shape[2])

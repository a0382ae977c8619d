"""Closures over media: their light, from where walks under the surface end."""

from __future__ import annotations

import numpy as np

from ..geometry.round_points import circles, is_round
from ..surfaces.seen_points import ClosureLayer, SeenPoints
from ..surfaces.surface import lambert_lobes
from ..walks.random_walk import walk
from .tile_job import Job

# From each point, whose samples they share. One leaves 1.6 times the error of Cycles' one a sample,
# four .9; CPU time by MRE squared, of 1, 2, 4 (a head of Random Walk, .02 m): 16.9, 12.8, 12.6.
_WALKS = 4


def walked_layers(
    job: Job,
    layers: list[ClosureLayer],
    places: tuple[np.ndarray, np.ndarray],
    number: np.ndarray,
) -> list[ClosureLayer]:
    """The layers, those over media at the ends of their walks; what finds none is not there.

    places: column and row in the frame of the points, int (n,); number: int64 (n,), their passes
    """
    if all(layer.media is None for layer in layers):
        return layers
    out = []
    for layer in layers:
        if layer.media is None:
            out.append(layer)
            continue
        layer = _without_strands(job, layer)
        for k in range(_WALKS):
            if job.stop.is_set():  # what is cut short is thrown away
                break
            out.append(_walked(job, layer, places, number * _WALKS + k))
    return [layer for layer in out if layer is layers[0] or len(layer.of)]


def _without_strands(job: Job, layer: ClosureLayer) -> ClosureLayer:
    """The same but for points on strands: Cycles' walks never meet those, so none has an end."""
    points, mesh = layer.seen.points, job.scene.mesh
    on_tube = is_round(job.scene, points.triangle)
    rows = np.flatnonzero(on_tube)
    if not len(rows):
        return layer
    round_ = circles(mesh, points.triangle[rows], points.position[rows])
    on_tube[rows] = round_.axis.any(axis=1)
    kept = np.flatnonzero(~on_tube)
    return ClosureLayer(layer.seen.at(kept), layer.of[kept], layer.media.at(kept))


def _walked(job: Job, layer: ClosureLayer, places, number) -> ClosureLayer:
    """One of _WALKS walks from each point, which is its number ``number``."""
    scene, media, of = job.scene, layer.media, layer.of
    points, lobes, _ = layer.seen
    apart = 0 if job.settings.decorrelation == "NONE" else 1
    columns, rows = (apart * place[of].astype(np.int64) for place in places)
    at = columns, rows, number[of].astype(np.int64)
    # Where a bump turns the surface away from wo, light still enters, as in Cycles.
    exits = walk(scene, job.accel, points, lobes.glossy_normal, media, at, job.settings.seed)
    color, own = lobes.diffuse[exits.of] / np.float32(_WALKS), media.color[exits.of].clip(0.0, 1.0)
    # The walk colors what comes out: the closure's own color is not to do so again.
    white = np.divide(color, own, out=np.zeros_like(color), where=own > 0.0)
    seen = lambert_lobes(scene, exits.points, white * exits.gain)
    material = scene.mesh.material_index[seen[0].triangle]
    return ClosureLayer(SeenPoints(*seen, material), of[exits.of], None, color)

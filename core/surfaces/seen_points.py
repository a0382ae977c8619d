"""Shading points and what they are made of: the lobes of their materials, closure by closure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.lobe_setup import setup_lobes
from ..bsdf.lobes import Lobes
from ..geometry.shading import ShadingPoints, params_at
from ..scene import Scene
from ..walks.subsurface import Media
from .surface import closure_layers, surface_lobes


class SeenPoints(NamedTuple):
    """Shading points of a set of rays and what they are made of; rows: int32 (n,), materials.

    Points of a translucent closure are those of the side that the light comes from.
    """

    points: ShadingPoints
    lobes: Lobes
    rows: np.ndarray

    def at(self, which) -> SeenPoints:
        """Those of a slice or of indices."""
        return SeenPoints(
            self.points.at(which),
            self.lobes.at(which),
            self.rows[which],
        )


def with_lobes(scene: Scene, points: ShadingPoints) -> SeenPoints:
    """Set up the materials of points; of a mixture the closure of the greatest weight."""
    rows = scene.mesh.material_index[points.triangle]
    if scene.shaders is not None:
        return SeenPoints(*surface_lobes(scene, points), rows)
    params = params_at(scene.materials, rows)
    lobes = setup_lobes(params, points.normal, points.geometric_normal, points.wo, scene.measured)
    return SeenPoints(points, lobes, rows)


class ClosureLayer(NamedTuple):
    """One closure of each of some points.

    of: int64 (m,), ascending, their rows in the first layer, which has all points
    media: what is under them, and to be walked through; None: nothing
    color: float32 (m, 3), Cycles' Diffuse Color, where it is not that of the lobes; None: it is
    """

    seen: SeenPoints
    of: np.ndarray
    media: Media | None = None
    color: np.ndarray | None = None

    def at(self, which: np.ndarray) -> ClosureLayer:
        """Of some of the points, int (m,), ascending, what of this layer is the surface's own."""
        place = np.searchsorted(which, self.of).clip(max=max(len(which) - 1, 0))
        kept = np.flatnonzero(which[place] == self.of) if len(which) else np.zeros(0, np.int64)
        return ClosureLayer(self.seen.at(kept), place[kept])


def with_all_lobes(scene: Scene, points: ShadingPoints) -> list[ClosureLayer]:
    """The materials of points, a layer for each closure that they mix."""
    if scene.shaders is None:
        return [ClosureLayer(with_lobes(scene, points), np.arange(len(points.pixel)))]
    rows = scene.mesh.material_index[points.triangle]
    return [
        ClosureLayer(SeenPoints(own, lobes, rows[of]), of, media)
        for of, own, lobes, media in closure_layers(scene, points)
    ]

"""Passes that need no light: mist, UV, vectors, mattes, AOVs and roughness, of all that is hit.

They cost nothing where the scene asks for none of them.
"""

from __future__ import annotations

import numpy as np

from ..camera.pixel_motion import TileVectors
from ..geometry.shading import ShadingPoints
from ..scene import HOLDOUT, Scene
from ..surfaces.roughness import TileRoughness
from ..surfaces.shader_values import TileAov
from .catchers import are_whole_holes, plays
from .cryptomatte import TileMattes
from .surface_numbers import TileMist, TileUv

_OF_WHOLE = (TileUv, TileRoughness, TileVectors)  # as whole_surfaces.py says, where it is asked for


class SurfacePasses:
    """Of n pixels of one tile."""

    def __init__(self, scene: Scene, n: int):
        asked = scene.asked
        self._kinds = [TileMattes(matte, scene.mesh, n) for matte in asked.mattes]
        if asked.mist is not None:
            self._kinds.append(TileMist(n))
        if asked.uv is not None:
            self._kinds.append(TileUv(n))
        if asked.roughness:
            self._kinds.append(TileRoughness(n))
        if scene.pixel_motion is not None:
            self._kinds.append(TileVectors(n))
        if scene.shaders is not None:
            self._kinds += [TileAov(aov, n) for aov in scene.shaders.aovs]

    @property
    def wanted(self) -> bool:
        """Whether there is anything to do."""
        return bool(self._kinds)

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray, own=None) -> None:
        """Add points to their pixels, of which holdouts show nothing but what their nodes write.

        scene: at their slice of the shutter's time; place: int32 (k,), -1 = none
        own: of WholeSurfaces; None: all count
        """
        if not self.wanted:
            return
        own = np.ones(len(place), np.float32) if own is None else own
        inside = place >= 0
        if not inside.all():
            points, place, own = points.at(inside), place[inside], own[inside]
        shown = ~plays(scene, points, HOLDOUT)
        solid = shown if scene.asked.solid is None else ~are_whole_holes(scene, points)
        for kind in self._kinds:
            which = solid if isinstance(kind, (TileMist, *_OF_WHOLE)) else shown
            if isinstance(kind, _OF_WHOLE):
                which = which & (own > 0.0)
            if which.all() or isinstance(kind, TileAov):
                kind.add(scene, points, place)
            else:
                kind.add(scene, points.at(which), place[which])

    def add_whole(self, scene: Scene, points: ShadingPoints, place: np.ndarray, weight) -> None:
        """Add WholeSurfaces' points, none of holdouts, to their pixels."""
        for kind in self._kinds:
            if isinstance(kind, _OF_WHOLE):
                kind.add(scene, points, place, weight)

    def add_panes(self, scene: Scene, panes: ShadingPoints, place: np.ndarray, taken) -> None:
        """Add WholeSurfaces' panes, none of holdouts, to their pixels."""
        for kind in self._kinds:
            if isinstance(kind, TileMist):
                kind.add_panes(scene, panes, place, taken)

    def add_missed(self, scene: Scene, place: np.ndarray, directions: np.ndarray) -> None:
        """Add rays that see the world to their pixels, place: int32 (k,), -1 = none."""
        inside = place >= 0
        for kind in self._kinds:
            if isinstance(kind, (TileVectors, TileAov)):
                kind.add_missed(scene, place[inside], directions[inside])

    def write(self, layers: dict[str, np.ndarray], rows, passes: np.ndarray) -> None:
        """Write the layers of a tile. rows: its pixels; passes: int (k,), rays of each."""
        shape, passes = layers["combined"].shape[:2], np.maximum(passes, 1)
        for kind in self._kinds:
            values = kind.values(rows, passes)
            layers[kind.layer] = values.reshape(*shape, -1).astype(np.float32)

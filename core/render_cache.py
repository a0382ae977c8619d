"""What is kept from one render to the next: the BVH, the light, the paper's tables."""

from __future__ import annotations

import numpy as np

from .accel import Accel
from .environment import make_lookup
from .light_rays import Light, make_light
from .paper_tables import PaperTables, TableBuilder
from .pyramid import build_pyramid
from .scene import EnvironmentMap, Scene, TriangleMesh
from .settings import RenderSettings


class RenderCache:
    """What is kept from one render to the next while its source stays the same object."""

    def __init__(self):
        self._accel: Accel | None = None
        self._environment: EnvironmentMap | None = None
        self._light: Light | None = None
        self._builder = TableBuilder()

    def accel(self, mesh: TriangleMesh, cancelled=lambda: False) -> Accel:
        """The BVH of this mesh table, built unless it is the last one's; see Accel."""
        accel = self._accel
        if accel is None or accel.mesh is not mesh:
            self._accel = accel = None  # two hierarchies at once would double the peak
            self._accel = accel = Accel(mesh, cancelled)
        return accel

    def light(self, environment: EnvironmentMap, threads: int, cancelled) -> Light:
        """The quadtree of this environment, built unless it is the last one's."""
        if self._light is None or not _same_light(environment, self._environment):
            lookup = make_lookup(environment)
            self._light = make_light(lookup, build_pyramid(lookup, threads, cancelled))
            self._environment = None if cancelled() else environment
        return self._light

    def tables(
        self, scene: Scene, light: Light, settings: RenderSettings, threads: int, progress
    ) -> tuple[PaperTables, list[str], list[str]]:
        """The paper's tables of a scene, warnings about them, and notes on those built anew."""
        tables = self._builder.tables(light.lookup, scene.materials, settings, threads, progress)
        return tables, self._builder.warnings, self._builder.notes


def _same_light(a: EnvironmentMap, b: EnvironmentMap | None) -> bool:
    return b is not None and (
        (a.projection, a.interpolation) == (b.projection, b.interpolation)
        and np.array_equal(a.world_to_map, b.world_to_map)
        and np.array_equal(a.strength, b.strength)
        and (a.radiance is b.radiance or np.array_equal(a.radiance, b.radiance))
    )

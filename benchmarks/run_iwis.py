"""IWIS on the file that is open in bpy, by its real way: export_scene, then the core's render."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import bpy
from run_cycles import quiet

from iwis.core.film import Film
from iwis.core.render import RenderCache, render
from iwis.core.scene import Scene
from iwis.core.settings import RenderSettings
from iwis.core.stats import RenderStats
from iwis.iwis_addon.export import export_scene

ENGINE = "IWIS_BENCHMARK"


class Exported(NamedTuple):
    """What a final render would have exported."""

    scene: Scene
    warnings: list[str]
    stats: RenderStats  # the phase "export"


def export_open_file(blender_scene) -> Exported:
    """Export from inside a render: only there is the dependency graph that of a final render."""
    found: list[Exported | Exception] = []

    class Engine(bpy.types.RenderEngine):
        bl_idname = ENGINE
        bl_label = "IWIS export for benchmarks"

        def render(self, depsgraph):
            try:
                found.append(_export(depsgraph))
            except Exception as error:  # raised again below: Blender would only print it
                found.append(error)
            width, height = self.resolution_x, self.resolution_y
            self.end_result(self.begin_result(0, 0, width, height))

    before = blender_scene.render.engine
    bpy.utils.register_class(Engine)
    try:
        blender_scene.render.engine = ENGINE
        with quiet():
            bpy.ops.render.render()
    finally:
        blender_scene.render.engine = before
        bpy.utils.unregister_class(Engine)
    if isinstance(found[0], Exception):
        raise found[0]
    return found[0]


def _export(depsgraph) -> Exported:
    warnings: list[str] = []
    stats = RenderStats()
    with stats.phase("export"):
        scene = export_scene(depsgraph, warnings=warnings)
    return Exported(scene, warnings, stats)


class IwisRun:
    """Renders of one exported scene that share the BVH and the light, as frames of a job do."""

    def __init__(self, scene: Scene, base: RenderSettings):
        self.scene, self.base, self.cache = scene, base, RenderCache()

    def render(self, scene: Scene | None = None, **changes) -> tuple[Film, RenderStats]:
        """The picture, with some settings other than the base's, and what it cost.

        scene: another one than the run's, with its mesh and environment
        """
        scene = scene or self.scene
        film = Film(scene.camera.region)
        return film, render(scene, self.settings(**changes), film, self.cache)

    def settings(self, **changes) -> RenderSettings:
        """The base's settings with changes. Raises TypeError or ValueError for wrong ones."""
        return dataclasses.replace(self.base, **changes)

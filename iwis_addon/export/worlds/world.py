"""Blender's world to core.scene.EnvironmentMap: one map, one matrix, one strength.

Where all that varies is Environment Textures looked up the same way, the nodes over them are
evaluated for their texels; another tree is evaluated for the directions of a new map. What is not
the same as in Cycles gets a warning that names world and node. docs/decisions/0018-world-trees.md
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.data.program import Ref, WorldProgram
from ....core.scene import EnvironmentMap
from ..errors import ExportCancelled
from ..images.texel_cache import TexelCache
from ..radiance import STRONGEST, mend_radiance
from ..same import same
from ..shaders.node_values import follow
from ..shaders.program_images import ImageStore
from ..shaders.seen_tree import seen_tree
from . import world_picture
from .world_builder import WorldBuilder, WorldReader
from .world_coordinates import CAMERA_RAYS, LIGHT_RAYS
from .world_picture import Picture, backdrop_of, picture_of_directions, picture_of_texels
from .world_tree import WorldTree, read_tree

# Warnings that mean nothing where lamps light the scene.
NO_LIGHT = "it gives no light: all is black but what emits by itself"
NO_WORLD = "the scene has no world: the background is black; add one in World settings"
_BLACK = np.zeros(3, np.float32)


class WorldExport(NamedTuple):
    """light, backdrop: environment and backdrop of core.scene.Scene."""

    light: EnvironmentMap
    backdrop: EnvironmentMap | WorldProgram | None = None


def world_of(depsgraph_or_scene):
    """The world of a graph's view layer, or of a scene; None if there is none."""
    graph = depsgraph_or_scene
    scene = getattr(graph, "scene_eval", graph)
    override = getattr(getattr(graph, "view_layer_eval", None), "world_override", None)
    if override is None:
        return scene.world
    return override if override.is_evaluated else override.evaluated_get(graph)


def is_in_layer(depsgraph_or_scene) -> bool:
    """Whether the view layer has its world: Environment of its filter."""
    return getattr(getattr(depsgraph_or_scene, "view_layer_eval", None), "use_sky", True)


def read_world(
    depsgraph_or_scene,
    warnings: list[str],
    cache: TexelCache | None = None,
    cancelled=lambda: False,
    least_height: int | None = None,
) -> WorldExport:
    """The world's light. What cannot be read gets Cycles' colour and a warning.

    warnings: gets one line for each thing that is not as in Cycles
    cache: the same object for every frame of an animation; while the texels stay the same,
        EnvironmentMap.radiance is the same array
    least_height: rows of a map that is made, LEAST_HEIGHT by default
    Raises ExportCancelled soon after cancelled() says so, and nothing else.
    """
    cache = cache or TexelCache()
    cache.start_frame()
    cache.skies.begin()
    world = world_of(depsgraph_or_scene)
    if world is None:
        warnings.append(NO_WORLD)
        return WorldExport(_uniform(_BLACK, "no world", True))
    visible = is_visible_to_camera(world)
    if not is_in_layer(depsgraph_or_scene):
        return WorldExport(_uniform(_BLACK, world.name, visible))
    seen = seen_tree(world)
    if seen is None:
        return WorldExport(_uniform(np.array(world.color, np.float32), world.name, visible))
    export = _Export(depsgraph_or_scene, world, seen, warnings, cache)
    return export.read(cancelled, least_height or world_picture.LEAST_HEIGHT)


class _Export:
    """Makes the maps of one world."""

    def __init__(self, depsgraph, world, seen, warnings, cache):
        self._seen = seen
        self._depsgraph, self._world, self._cache = depsgraph, world, cache
        self._warnings, self._reader = warnings, WorldReader(world, warnings)
        self._images = ImageStore(cache)
        self._threads = max(1, getattr(depsgraph, "scene_eval", depsgraph).render.threads)

    def read(self, cancelled, least_height: int) -> WorldExport:
        """See read_world."""
        world, warn = self._world, self._reader.warn
        n_warnings = len(self._warnings)
        output = self._seen.output
        if output is None or follow(output.inputs["Surface"]).node is None:
            if not world.original.is_missing:  # of a library, which is told of by itself
                warn(output, "nothing is linked to the Surface of the World Output: black")
            return WorldExport(_uniform(_BLACK, world.name, is_visible_to_camera(world)))
        if output.inputs["Volume"].is_linked:
            warn(output, "the world's volume is not supported: it is left out")
        if not getattr(getattr(world, "cycles", None), "use_shadows", True):
            warn(None, "Shadows are off: it throws them all the same (Cycles mixes two answers)")
        if _hidden_from(world):
            kinds = " and ".join(_hidden_from(world))
            warn(None, f"ray visibility for {kinds} rays is not supported: they are lit")
        tree, asks_for_rays = self._tree(output, LIGHT_RAYS)
        light = self._exact_map(tree, "light", least_height)
        is_exact = light is not None
        if light is None:
            light = self._map_of_directions(tree, least_height, cancelled)
        if len(self._warnings) == n_warnings and not _gives_light(light):
            warn(None, NO_LIGHT)
        if not light.visible_to_camera:
            return WorldExport(light)
        seen = self._tree(output, CAMERA_RAYS)[0] if asks_for_rays else tree
        if is_exact and same(seen, tree):
            return WorldExport(light)
        backdrop = self._exact_map(seen, "backdrop", least_height)
        return WorldExport(light, backdrop or backdrop_of(self._mended_tree(seen), self._cache))

    def _tree(self, output, rays) -> tuple[WorldTree, bool]:
        """The tree for a kind of rays, and whether it asks for their kind."""
        builder = WorldBuilder(self._reader, self._images, self._depsgraph, rays, self._cache)
        return read_tree(output, builder), builder.asks_for_rays

    def _mended_tree(self, tree: WorldTree) -> WorldTree:
        return tree._replace(strength=self._usable(tree.strength))

    def _exact_map(self, tree: WorldTree, slot: str, least_height) -> EnvironmentMap | None:
        """The map of a tree that is one colour, or one place in its images; else None."""
        if not isinstance(tree.value, Ref):
            color = self._mended(np.float32(tree.value), slot, None) * self._usable(tree.strength)
            return _uniform(color, self._world.name, is_visible_to_camera(self._world))
        picture = picture_of_texels(tree, slot, self._cache, self._threads, least_height)
        return None if picture is None else self._map(picture, tree, slot)

    def _map_of_directions(self, tree: WorldTree, least_height, cancelled) -> EnvironmentMap:
        def pause():
            if cancelled():
                raise ExportCancelled

        own = self._cache, self._threads, least_height, self._reader, pause
        return self._map(picture_of_directions(tree, *own), tree, "light")

    def _map(self, picture: Picture, tree: WorldTree, slot: str) -> EnvironmentMap:
        return EnvironmentMap(
            radiance=self._mended(picture.radiance, slot, picture.name),
            world_to_map=picture.world_to_map,
            projection=picture.projection,
            interpolation=picture.interpolation,
            strength=self._usable(tree.strength),
            visible_to_camera=is_visible_to_camera(self._world),
            name=picture.name or self._world.name,
        )

    def _usable(self, strength):
        if not np.isfinite(strength).all():
            text = f"strength {strength[0]:g} is not a finite number: 0 is used"
            self._reader.warn(None, text)
            return _BLACK
        if np.abs(strength).max() > STRONGEST:
            text = f"strength {strength.max():g} is too large: {STRONGEST:g} is used"
            self._reader.warn(None, text)
        return np.clip(strength, np.float32(-STRONGEST), np.float32(STRONGEST))

    def _mended(self, radiance, slot, name):
        """Radiance that can be rendered, float32; what had to be changed becomes a warning."""
        radiance, notes = self._cache.kept(
            ("mended", slot), radiance, lambda: mend_radiance(radiance)
        )
        for note in notes:
            what = "its colour" if name is None else f'image "{name}":'
            self._reader.warn(None, f"{what} {note}")
        return radiance


def _gives_light(environment: EnvironmentMap) -> bool:
    return bool(environment.strength.any() and environment.radiance.any())


def _hidden_from(world) -> list[str]:
    """Kinds of rays that the world is hidden from in Cycles, and that it lights here."""
    visibility = getattr(world, "cycles_visibility", None)
    return [kind for kind in ("diffuse", "glossy") if not getattr(visibility, kind, True)]


def is_visible_to_camera(world) -> bool:
    """Ray visibility belongs to Cycles' settings, there as long as its add-on is enabled."""
    visibility = getattr(world, "cycles_visibility", None)
    return True if visibility is None else visibility.camera


def _uniform(color, name, visible) -> EnvironmentMap:
    """A world of one colour: a map of one white texel, times the colour."""
    return EnvironmentMap(
        radiance=np.ones((1, 1, 3), np.float32),
        strength=np.asarray(color, np.float32),
        visible_to_camera=visible,
        name=name,
    )

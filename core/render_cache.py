"""What is kept from one render to the next: the BVH, the light, the paper's tables."""

from __future__ import annotations

import operator
from typing import NamedTuple

import numpy as np

from .data.copies import Copies
from .data.lamps import LampLink
from .embree.accel import Accel
from .embree.copied_accel import CopiedAccel
from .embree.copied_rows import CopiedRows
from .embree.moved_accel import Moves, moved, moves_between, settled
from .embree.moving_accel import MovingAccel
from .embree.moving_copies import MovingCopies
from .light.environment import make_lookup, takes_away
from .light.light_cache import light_key, load_light, save_light
from .light.light_tree import build_pyramid
from .light.pyramid import LightPyramid
from .paper_mode.paper_tables import PaperTables, TableBuilder
from .sampling.light_rays import Light, make_light
from .scene import EnvironmentMap, Scene, TriangleMesh
from .see_through.ray_masks import RayMasks, ray_masks
from .see_through.scene_rays import RayParts, SceneRays
from .settings import RenderSettings
from .surfaces.backdrop import Backdrop
from .wavelets.table_cache import table_folder


class _Built(NamedTuple):
    """What hierarchies were made of; programs: of Shaders; places: Scene.object_to_world;
    links: Scene.lamp_links."""

    triangles: np.ndarray
    programs: tuple | None
    flags: np.ndarray | None
    places: np.ndarray | None
    links: tuple[LampLink, ...]

    @classmethod
    def of(cls, scene: Scene) -> _Built:
        programs = None if scene.shaders is None else scene.shaders.programs
        own = scene.object_flags, scene.object_to_world, scene.lamp_links
        return cls(scene.mesh.triangles, programs, *own)

    def moves(self, now: _Built) -> Moves | None:
        """What has moved, where nothing else has changed; else None."""
        if now.triangles is not self.triangles or now.programs is not self.programs:
            return None
        if self.places is None or now.places is None or len(self.places) != len(now.places):
            return None
        if not (self.flags is now.flags or np.array_equal(self.flags, now.flags)):
            return None
        if not _same_links(self.links, now.links):
            return None
        return moves_between(self.places, now.places)


def _differ_by_places(built: Accel | RayParts, mesh: TriangleMesh, copies: Copies | None) -> bool:
    """Whether hierarchies are those of a mesh with copies, which stand elsewhere."""
    if built.mesh is not mesh or built.copies is None:
        return False
    return built.copies.same_originals(copies)


def _same_links(links: tuple[LampLink, ...], others: tuple[LampLink, ...]) -> bool:
    return len(links) == len(others) and all(map(LampLink.same, links, others))


class RenderCache:
    """What is kept from one render to the next while its source stays the same.

    light_warnings: what went wrong in keeping the last light on disk
    takes_away: environment.takes_away of the last light
    """

    def __init__(self):
        self._accel: Accel | None = None
        self._parts: RayParts | None = None
        self._built: _Built | None = None  # what either was made of
        self._masks: tuple[tuple, tuple, RayMasks | None] | None = None
        self._moved = False  # whether either was asked for objects that have moved
        self._environment: EnvironmentMap | None = None
        self._light: Light | None = None
        self._unit: LightPyramid | None = None  # of the light, at strength 1
        self._backdrop: tuple[object, Backdrop] | None = None
        self.light_warnings: list[str] = []
        self.takes_away = False
        self._builder = TableBuilder()

    def accel(
        self, mesh: TriangleMesh, cancelled=lambda: False, copies: Copies | None = None
    ) -> Accel:
        """The BVH of this mesh table, built unless it is the last one's; see Accel."""
        accel = self._accel
        if accel is not None and accel.mesh is mesh and accel.copies is copies:
            return accel
        if accel is not None and _differ_by_places(accel, mesh, copies):
            self._accel = accel.with_copies(copies)
            return self._accel
        if not self._moved:  # two hierarchies at once would double the peak
            self._accel = accel = None
        if copies is None:
            self._accel = Accel(mesh, cancelled)
        else:
            self._accel = CopiedAccel(mesh, copies, None, cancelled)
        return self._accel

    def rays(self, scene: Scene, cancelled=lambda: False, quick: bool = False) -> Accel | SceneRays:
        """What the rays of a scene meet: its Accel, or several where not all see the same.

        quick: where objects have moved, rays may be slower if they are there sooner; until the
        next call (docs/decisions/0026-moved-objects.md)
        """
        if scene.motion is not None:
            return self._moving_rays(scene, cancelled)
        self._settle()
        found = self._moved_rays(scene, cancelled) if quick else None
        if found is not None:
            return found
        masks = self._ray_masks(scene)
        if not self._moved and masks is None:  # two hierarchies at once would double the peak
            self._parts = None
        parts = None if masks is None else self._ray_parts(scene, masks, cancelled)
        accel = self.accel(scene.mesh, cancelled, scene.copies) if masks is None else None
        self._accel, self._parts = accel, parts
        self._built, self._moved = _Built.of(scene), False
        return accel if parts is None else SceneRays(scene, parts)

    def _ray_parts(self, scene: Scene, masks: RayMasks, cancelled) -> RayParts:
        parts = self._parts
        same = parts is not None and parts.mesh is scene.mesh and masks.same(parts.masks)
        if same and parts.copies is scene.copies:
            return parts
        if same and _differ_by_places(parts, scene.mesh, scene.copies):
            return parts.with_copies(scene.copies)
        if not self._moved:
            self._accel = self._parts = parts = None
        return RayParts(scene.mesh, masks, cancelled, copies=scene.copies)

    def _ray_masks(self, scene: Scene) -> RayMasks | None:
        """The last ones while what they are made of is the same: grids take their time."""
        made_of = scene.mesh, scene.materials, scene.shaders, scene.object_flags
        links = scene.lamp_links
        known = self._masks
        if (
            known is None
            or any(map(operator.is_not, made_of, known[0]))
            or not _same_links(links, known[1])
        ):
            self._masks = None
            self._masks = made_of, links, ray_masks(scene)
        return self._masks[2]

    def _settle(self) -> None:
        """End what the last _moved_rays did to the hierarchies that are kept."""
        if self._moved and self._parts is not None:
            self._parts.settle()
        elif self._moved and self._accel is not None:
            settled(self._accel)

    def _moved_rays(self, scene: Scene, cancelled):
        """Rays by the hierarchies of the scene as it was before its objects moved, or None.

        What a world position decides of opacities stays as it was, until they are built anew.
        """
        base = self._accel if self._parts is None else self._parts
        if base is None or base.mesh is scene.mesh:
            return None
        moves = self._built.moves(_Built.of(scene)) if self._built else None
        if moves is None:
            return None
        self._moved = True
        if self._parts is None:
            return moved(base, scene.mesh, moves, cancelled)
        parts = base.moved(scene.mesh, moves, cancelled)
        return None if parts is None else SceneRays(scene, parts)

    def _moving_rays(self, scene: Scene, cancelled) -> MovingAccel | SceneRays:
        """Of a scene whose objects move: nothing of it is kept for the next frame."""
        self._accel = self._parts = None
        self._moved = False
        masks = self._ray_masks(scene)
        mesh, motion, copies = scene.mesh, scene.motion, scene.copies
        if masks is not None:
            return SceneRays(scene, RayParts(mesh, masks, cancelled, motion, copies))
        if copies is None:
            return MovingAccel(mesh, motion, cancelled)
        return MovingCopies(mesh, motion, copies, None, cancelled)

    def light(
        self,
        environment: EnvironmentMap,
        cache_dir: str | None = None,
        progress=lambda fraction, text: None,
    ) -> Light:
        """The light of this environment: the last one's, or out of the cache folder, or built anew.

        cache_dir: of the settings; None: nothing is read or kept on disk
        progress(fraction, text) is told every few milliseconds, and may raise to stop.
        """
        self.light_warnings = []
        before, self._environment = self._environment, None
        if before is not None and _same_map(environment, before):
            lookup = self._light.lookup
        else:
            self._light = self._unit = None  # two lights at once would double the peak
            lookup, self.takes_away = make_lookup(environment), takes_away(environment)
            self._unit = self._read_or_build(
                lookup._replace(strength=_relative(environment.strength)),
                cache_dir,
                lambda fraction: progress(fraction, "Preparing the light"),
            )
        if before is None or self._light is None or _differ(environment.strength, before.strength):
            pyramid, strongest = self._unit, np.abs(environment.strength).max()
            if strongest not in (0.0, 1.0):  # brighter or darker as a whole: the same tree
                pyramid = pyramid._replace(averages=pyramid.averages * strongest)
            self._light = make_light(lookup._replace(strength=environment.strength), pyramid)
        self._environment = environment
        return self._light

    def backdrop(self, scene: Scene) -> Backdrop | None:
        """What the scene's camera sees in place of its light, if there is anything."""
        world, kept = scene.backdrop, self._backdrop
        if world is None:
            self._backdrop = None
        elif kept is None or kept[0] is not world:
            self._backdrop = world, Backdrop(world)
        return None if world is None else self._backdrop[1]

    def _read_or_build(self, lookup, cache_dir, progress) -> LightPyramid:
        if cache_dir is None:
            return build_pyramid(lookup, progress)
        folder = table_folder(cache_dir)
        key = light_key(lookup, progress)
        pyramid = load_light(folder, key)
        if pyramid is None:
            pyramid = build_pyramid(lookup, progress)
            warning = save_light(folder, key, pyramid)
            self.light_warnings = [warning] if warning else []
        return pyramid

    def tables(
        self, scene: Scene, light: Light, settings: RenderSettings, threads: int, progress
    ) -> tuple[PaperTables, list[str], list[str]]:
        """The paper's tables of a scene, warnings about them, and notes on those built anew."""
        tables = self._builder.tables(
            light.lookup, scene.materials, settings, threads, progress, scene.measured
        )
        return tables, self._builder.warnings, self._builder.notes


def with_rows(scene: Scene, accel, settings: RenderSettings, threads: int):
    """(scene, accel) with room for what rays meet of copies; as they were where there are none.

    accel: of RenderCache.rays; threads: that ask it at a time, beside this one
    """
    if scene.copies is None:
        return scene, accel
    table = CopiedRows(scene, settings, threads)
    return table.scene, accel.with_rows(table)


def _relative(strength: np.ndarray) -> np.ndarray:
    """A strength whose largest channel is 1 or -1, or 0 as it was."""
    strongest = np.abs(strength).max()
    return strength / strongest if strongest > 0.0 else strength


def _differ(a: np.ndarray, b: np.ndarray) -> bool:
    return a is not b and not np.array_equal(a, b)


def _same_map(a: EnvironmentMap, b: EnvironmentMap) -> bool:
    """Whether two maps differ by a factor at most."""
    if (a.projection, a.interpolation) != (b.projection, b.interpolation):
        return False
    if _differ(a.world_to_map, b.world_to_map):
        return False
    if _differ(_relative(a.strength), _relative(b.strength)):
        return False
    if a.radiance.shape != b.radiance.shape:
        return False
    # By parts: a comparison of 8K maps would need 100 MB for its answers.
    return a.radiance is b.radiance or not any(
        _differ(a.radiance[i : i + 64], b.radiance[i : i + 64])
        for i in range(0, len(a.radiance), 64)
    )

"""Rays of a scene in which not all see the same: cut-outs, shadow catchers, hidden objects.

There is a hierarchy for each set of triangles that some kind of ray asks for: those that the camera
sees; of those that throw a shadow, the ones that Embree answers for alone, and the others, whose
hits are looked at one by one.
"""

from __future__ import annotations

import copy
import dataclasses
from typing import NamedTuple

import numpy as np

from .accel import MISS, Accel
from .cutouts import MOST_LAYERS, behind, cut_materials, drawn_numbers, passing_shares
from .embree import can_filter
from .embree_filter import Opacity
from .embree_rays import ALL_COLORS
from .moved_accel import Moves, moved, settled
from .moving_accel import MovingAccel
from .object_motion import ObjectMotion
from .opacity import bake_opacity
from .poses import posed_points
from .program_ops import passes_by_place
from .scene import (
    CAMERA_RAYS,
    HOLDOUT,
    SHADOW_CATCHER,
    SHADOW_RAYS,
    Scene,
    TriangleMesh,
)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class RayMasks:
    """Who sees which triangles, bool, one each.

    camera: what the camera sees
    solid: what throws a shadow that Embree knows of, opaque or with a grid of ``opacity``
    cut: what throws a shadow and is looked at hit by hit
    catcher: what catches shadows, and throws none on others of its kind
    linked: for each of Scene.lamp_links what throws shadows of its lamps
    """

    camera: np.ndarray
    solid: np.ndarray
    cut: np.ndarray
    catcher: np.ndarray
    opacity: Opacity | None
    linked: tuple[np.ndarray, ...] = ()

    def same(self, other: RayMasks) -> bool:
        """Whether two are equal."""
        own, others = ((m.camera, m.solid, m.cut, m.catcher, *m.linked) for m in (self, other))
        if len(own) != len(others) or not all(map(np.array_equal, own, others)):
            return False
        return self.opacity is other.opacity or (
            self.opacity is not None and self.opacity.same(other.opacity)
        )


def ray_masks(scene: Scene) -> RayMasks | None:
    """Who sees which triangles; None: all rays see all of them, and nothing lets rays through."""
    materials, objects = cut_materials(scene), scene.object_flags
    plain = CAMERA_RAYS | SHADOW_RAYS
    alike = objects is None or (objects & ~np.uint8(HOLDOUT) == plain).all()
    all_block = all(link.blockers is None for link in scene.lamp_links)
    if materials is None and alike and all_block:
        return None
    mesh = scene.mesh
    every = np.ones(len(mesh.triangles), np.bool_)
    linked = tuple(
        every if link.blockers is None else link.blockers[mesh.object_index]
        for link in scene.lamp_links
    )
    flags = None if objects is None else objects[mesh.object_index]
    camera, shadow = (
        every if flags is None else (flags & kind) != 0 for kind in (CAMERA_RAYS, SHADOW_RAYS)
    )
    catcher = ~every if flags is None else (flags & SHADOW_CATCHER) != 0
    if materials is None:
        return RayMasks(camera, shadow, ~every, catcher, None, linked)
    programs = scene.shaders.programs
    materials &= [program is None or not program.throws_whole_shadow for program in programs]
    able = can_filter()
    pairs = zip(materials, programs, strict=True)
    baked = [able and cut and passes_by_place(program) for cut, program in pairs]
    cut = materials[mesh.material_index]
    with_grid = shadow & np.array(baked)[mesh.material_index]
    # Hits that are looked at one by one answer for all colors, and so do grids beside them.
    colored = not (shadow & cut & ~with_grid).any()
    opacity = bake_opacity(scene, with_grid, colored) if with_grid.any() else None
    if opacity is not None:
        with_grid = opacity.row >= 0
    solid, hit_by_hit = shadow & (~cut | with_grid), shadow & cut & ~with_grid
    return RayMasks(camera, solid, hit_by_hit, catcher, opacity, linked)


class PartAccel:
    """The hierarchy of some of a mesh's triangles."""

    def __init__(self, mesh: TriangleMesh, mask: np.ndarray, cancelled, opacity=None, motion=None):
        self.rows = None if mask.all() else np.flatnonzero(mask).astype(np.int32)
        if self.rows is not None:
            mesh = TriangleMesh(
                vertices=mesh.vertices,
                triangles=mesh.triangles[self.rows],
                corner_normals=mesh.corner_normals[self.rows],
                material_index=mesh.material_index[self.rows],
                object_index=mesh.object_index[self.rows],
            )
            if opacity is not None:
                opacity = opacity._replace(row=opacity.row[self.rows])
            if motion is not None:
                motion = motion.among(self.rows)
        if motion is None:
            self.accel = Accel(mesh, cancelled, opacity)
        else:
            self.accel = MovingAccel(mesh, motion, cancelled, opacity)

    def at(self, number: int) -> PartAccel:
        """The same at a slice of the shutter's time."""
        other = copy.copy(self)
        other.accel = self.accel.at(number)
        return other

    def moved(self, mesh: TriangleMesh, moves: Moves, cancelled) -> PartAccel | None:
        """The same of a mesh that differs by moves; see moved_accel.moved."""
        own = dataclasses.replace(self.accel.mesh, vertices=mesh.vertices)  # rays ask no normals
        other = copy.copy(self)
        other.accel = moved(self.accel, own, moves, cancelled)
        return None if other.accel is None else other

    def intersect(self, origins, directions):
        """See Accel; triangles are counted as in the whole mesh."""
        hit, u, v = self.accel.intersect(origins, directions)
        if self.rows is not None and len(self.rows):
            hit = np.where(hit >= 0, self.rows[hit], np.int32(MISS))
        return hit, u, v


class Shadows(NamedTuple):
    """The hierarchies of what throws shadows: of all objects, or of those linked to some lamps.

    solid, cut: of RayMasks, cut = None where there is nothing; others: solid without catchers
    """

    solid: PartAccel
    cut: PartAccel | None
    others: PartAccel

    def each(self, change) -> Shadows:
        """change(part) of all of them."""
        return Shadows(*(None if part is None else change(part) for part in self))


class RayParts:
    """The hierarchies that masks ask for; equal ones are built once.

    camera: what the camera sees; shadows: of all objects; linked: Shadows of each lamp link
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        masks: RayMasks,
        cancelled=lambda: False,
        motion: ObjectMotion | None = None,
    ):
        built: list[tuple] = []

        def part(mask, opacity) -> PartAccel:
            for own, grids, found in built:
                if grids is opacity and np.array_equal(own, mask):
                    return found
            found = PartAccel(mesh, mask, cancelled, opacity, motion)
            built.append((mask, opacity, found))
            return found

        def shadows(own) -> Shadows:
            solid, cut = masks.solid & own, masks.cut & own
            others = part(solid & ~masks.catcher, masks.opacity)
            return Shadows(
                part(solid, masks.opacity), part(cut, None) if cut.any() else None, others
            )

        self.mesh, self.masks = mesh, masks
        self.shadows = shadows(np.True_)
        same = np.array_equal(masks.camera, masks.solid)
        self.camera = self.shadows.solid if same else part(masks.camera, None)
        self.linked = [shadows(own) for own in masks.linked]

    def _each(self, change) -> RayParts:
        """change(part) of all of them, once each."""
        other, made = copy.copy(self), {}

        def once(part):
            if part not in made:
                made[part] = change(part)
            return made[part]

        other.camera, other.shadows = once(self.camera), self.shadows.each(once)
        other.linked = [shadows.each(once) for shadows in self.linked]
        return other

    def at(self, number: int) -> RayParts:
        """The same at a slice of the shutter's time."""
        return self._each(lambda part: part.at(number))

    def moved(self, mesh: TriangleMesh, moves: Moves, cancelled=lambda: False) -> RayParts | None:
        """The same of a mesh that differs by moves; see moved_accel.moved."""
        failed = []

        def change(part):
            other = part.moved(mesh, moves, cancelled)
            failed.extend([part] if other is None else [])
            return other

        other = self._each(change)
        other.mesh = mesh
        return None if failed else other

    def settle(self) -> None:
        """See moved_accel.settled."""
        self._each(lambda part: settled(part.accel))


class SceneRays:
    """What a render asks of an Accel, for one scene and its materials."""

    def __init__(self, scene: Scene, parts: RayParts, catchers: bool = True, link: int = -1):
        """catchers: whether they throw shadows; link: row of Scene.lamp_links, -1 = all objects
        do"""
        self._scene, self._parts, self._catchers, self._link = scene, parts, catchers, link
        shadows = parts.shadows if link < 0 else parts.linked[link]
        self._solid, self._cut = shadows.solid if catchers else shadows.others, shadows.cut
        self.mesh, self.offset = scene.mesh, parts.camera.accel.offset
        self.traversal = self._solid.accel.traversal
        self.by_rays = self._cut is not None

    def at(self, number: int, scene: Scene) -> SceneRays:
        """The same at a slice of the shutter's time, of which ``scene`` is."""
        return SceneRays(scene, self._parts.at(number), self._catchers, self._link)

    @property
    def without_catchers(self) -> SceneRays:
        """For the shadows that fall on catchers."""
        return SceneRays(self._scene, self._parts, catchers=False, link=self._link)

    def linked(self, link: int) -> SceneRays:
        """For the shadows of lamps that are linked to objects."""
        return SceneRays(self._scene, self._parts, self._catchers, link)

    def intersect(self, origins: np.ndarray, directions: np.ndarray):
        """The nearest hits that the camera sees; see Accel."""
        return self._parts.camera.intersect(origins, directions)

    def occluded(
        self, origins: np.ndarray, directions: np.ndarray, out=None, reach=None, towards=None
    ) -> np.ndarray:
        """Whether a ray ends at anything that throws a shadow; see Accel."""
        answer = self._solid.accel.occluded(origins, directions, out, reach, towards)
        if self._cut is None:
            return answer
        out = answer != 0
        rays = np.flatnonzero(~out)
        origins, directions = origins[rays], directions[rays]
        reach = np.full(len(rays), np.inf, np.float32) if reach is None else reach[rays]
        for _ in range(MOST_LAYERS):
            hit, u, v = self._cut.intersect(origins, directions)
            points = posed_points(self._scene.pose, self._scene.mesh, hit, u, v, directions)
            way = points.position - origins[points.pixel]
            reach = reach[points.pixel] - _length(way) / _length(directions[points.pixel])
            points, reach = points.at(reach > 0.0), reach[reach > 0.0]
            if not len(points.pixel):
                break
            met, rays = points.pixel, rays[points.pixel]
            passing = passing_shares(self._scene, points, shadow=True)
            goes = drawn_numbers(u[met], v[met], directions[met]) < passing
            out[rays[~goes]] = True
            rays, reach = rays[goes], reach[goes]
            directions = directions[met][goes]
            origins, _ = behind(points.at(goes), self.offset)
        else:
            out[rays] = True
        answer[:] = np.where(out, ALL_COLORS, 0)
        return answer


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))

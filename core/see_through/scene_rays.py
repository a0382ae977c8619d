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

from ..data.copies import Copies
from ..data.object_motion import ObjectMotion
from ..embree.accel import MISS, Accel, among
from ..embree.copied_accel import CopiedAccel
from ..embree.copied_rows import CopiedRows
from ..embree.embree_hits import Gone, begin_rays
from ..embree.embree_rays import ALL_COLORS, Traversal
from ..embree.moved_accel import Moves, moved, settled
from ..embree.moving_accel import MovingAccel
from ..embree.moving_copies import MovingCopies
from ..geometry.poses import posed_points
from ..scene import Scene, TriangleMesh
from .cutouts import drawn_numbers, passing_shares
from .ray_masks import RayMasks

# Surfaces that a shadow ray goes through, where its hits are looked at one by one.
_MOST_LAYERS = 64


class PartAccel:
    """The hierarchy of some of a mesh's triangles."""

    def __init__(self, mesh: TriangleMesh, mask, cancelled, opacity=None, motion=None, copies=None):
        """mask: bool, one a triangle; the others as Accel, MovingAccel and CopiedAccel have them"""
        self.rows = None
        if copies is not None:
            own = copies, mask, cancelled, opacity
            still = motion is None
            self.accel = CopiedAccel(mesh, *own) if still else MovingCopies(mesh, motion, *own)
            return
        self.rows = None if mask.all() else np.flatnonzero(mask).astype(np.int32)
        if self.rows is not None:
            mesh = among(mesh, self.rows)
            if opacity is not None:
                opacity = opacity.among(self.rows)
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
        own = dataclasses.replace(self.accel.mesh, vertices=mesh.vertices)
        if self.accel.opacity is not None and len(self.accel.opacity.normals):
            normals = mesh.corner_normals if self.rows is None else mesh.corner_normals[self.rows]
            own = dataclasses.replace(own, corner_normals=normals)
        other = copy.copy(self)
        other.accel = moved(self.accel, own, moves, cancelled)
        return None if other.accel is None else other

    def with_rows(self, table: CopiedRows) -> PartAccel:
        """See CopiedAccel."""
        other = copy.copy(self)
        other.accel = self.accel.with_rows(table)
        return other

    def with_copies(self, copies: Copies) -> PartAccel:
        """See CopiedAccel."""
        other = copy.copy(self)
        other.accel = self.accel.with_copies(copies)
        return other

    def intersect(self, origins, directions, slots=None, gone: Gone | None = None):
        """See Accel; triangles are counted as in the whole mesh."""
        return self._as_rows(*self.accel.intersect(origins, directions, slots, gone))

    def as_triangles(self, face, u, v, instance):
        """See Accel; triangles are counted as in the whole mesh."""
        return self._as_rows(*self.accel.as_triangles(face, u, v, instance))

    def _as_rows(self, hit, u, v):
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

    near: what throws shadows, and all triangles, opaque; None where no node asks
    camera: what the camera sees; shadows: of all objects; linked: Shadows of each lamp link
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        masks: RayMasks,
        cancelled=lambda: False,
        motion: ObjectMotion | None = None,
        copies: Copies | None = None,
    ):
        built: list[tuple] = []

        def part(mask, opacity) -> PartAccel:
            for own, grids, found in built:
                if grids is opacity and np.array_equal(own, mask):
                    return found
            found = PartAccel(mesh, mask, cancelled, opacity, motion, copies)
            built.append((mask, opacity, found))
            return found

        def shadows(own) -> Shadows:
            solid, cut = masks.solid & own, masks.cut & own
            others = part(solid & ~masks.catcher, masks.opacity)
            return Shadows(
                part(solid, masks.opacity), part(cut, None) if cut.any() else None, others
            )

        self.near = None
        if masks.near is not None:
            self.near = part(masks.near, None), part(np.ones_like(masks.near), None)
        self.mesh, self.masks, self.copies = mesh, masks, copies
        self.shadows = shadows(np.True_)
        same = np.array_equal(masks.camera, masks.solid)
        self.camera = self.shadows.solid if same else part(masks.camera, None)
        self.linked = [shadows(own) for own in masks.linked]
        cut = [own.cut for own in (self.shadows, *self.linked) if own.cut is not None]
        for own in {self.camera, *cut} if masks.clear else ():
            own.accel.go_on()

    def _each(self, change) -> RayParts:
        """change(part) of all of them, once each."""
        other, made = copy.copy(self), {}

        def once(part):
            if part not in made:
                made[part] = change(part)
            return made[part]

        other.camera, other.shadows = once(self.camera), self.shadows.each(once)
        other.linked = [shadows.each(once) for shadows in self.linked]
        other.near = None if self.near is None else tuple(map(once, self.near))
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

    def with_copies(self, copies: Copies) -> RayParts:
        """See CopiedAccel."""
        other = self._each(lambda part: part.with_copies(copies))
        other.copies = copies
        return other

    def with_rows(self, table: CopiedRows) -> RayParts:
        """See CopiedAccel."""
        return self._each(lambda part: part.with_rows(table))

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

    def with_rows(self, table: CopiedRows) -> SceneRays:
        """See CopiedAccel; of the scene that has the rows."""
        return SceneRays(table.scene, self._parts.with_rows(table), self._catchers, self._link)

    @property
    def without_catchers(self) -> SceneRays:
        """For the shadows that fall on catchers."""
        return SceneRays(self._scene, self._parts, catchers=False, link=self._link)

    def linked(self, link: int) -> SceneRays:
        """For the shadows of lamps that are linked to objects."""
        return SceneRays(self._scene, self._parts, self._catchers, link)

    @property
    def throwing(self) -> Accel:
        """Of all that throws a shadow, opaque, for nodes that ask what is near."""
        return self._parts.near[0].accel

    @property
    def every(self) -> Accel:
        """Of all triangles, opaque, for these nodes."""
        return self._parts.near[1].accel

    def intersect(
        self, origins: np.ndarray, directions: np.ndarray, slots=None, gone: Gone | None = None
    ):
        """The nearest hits that the camera sees; see Accel."""
        return self._parts.camera.intersect(origins, directions, slots, gone)

    def slots(self, n: int) -> np.ndarray | None:
        """See Accel."""
        return self._parts.camera.accel.slots(n)

    @property
    def looks(self) -> Traversal:
        """Of what the camera sees; see Accel."""
        return self._parts.camera.accel.looks

    def as_triangles(self, face, u, v, instance):
        """Of what the camera sees; see Accel."""
        return self._parts.camera.as_triangles(face, u, v, instance)

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
        gone = begin_rays(len(rays))
        for _ in range(_MOST_LAYERS):
            hit, u, v = self._cut.intersect(origins, directions, gone=gone)
            hit = np.where(gone.far < reach, hit, np.int32(MISS))
            points = posed_points(self._scene.pose, self._scene.mesh, hit, u, v, directions)
            met = points.pixel
            if not len(met):
                break
            passing = passing_shares(self._scene, points, shadow=True)
            goes = drawn_numbers(u[met], v[met], directions[met]) < passing
            out[rays[met[~goes]]] = True
            rays, reach, gone = rays[met[goes]], reach[met[goes]], gone.at(met[goes])
            origins, directions = origins[met[goes]], directions[met[goes]]
        else:
            out[rays] = True
        answer[:] = np.where(out, ALL_COLORS, 0)
        return answer

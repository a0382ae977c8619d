"""Rays of a scene in which not all see the same: cut-outs, shadow catchers, hidden objects.

There is a hierarchy for each set of triangles that some kind of ray asks for: those that the camera
sees; of those that throw a shadow, the ones that Embree answers for alone, and the others, whose
hits are looked at one by one.
"""

from __future__ import annotations

import copy
import dataclasses

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
    """

    camera: np.ndarray
    solid: np.ndarray
    cut: np.ndarray
    catcher: np.ndarray
    opacity: Opacity | None

    def same(self, other: RayMasks) -> bool:
        """Whether two are equal."""
        pairs = (
            (getattr(self, f), getattr(other, f)) for f in ("camera", "solid", "cut", "catcher")
        )
        if not all(np.array_equal(a, b) for a, b in pairs):
            return False
        return self.opacity is other.opacity or (
            self.opacity is not None and self.opacity.same(other.opacity)
        )


def ray_masks(scene: Scene) -> RayMasks | None:
    """Who sees which triangles; None: all rays see all of them, and nothing lets rays through."""
    materials, objects = cut_materials(scene), scene.object_flags
    plain = CAMERA_RAYS | SHADOW_RAYS
    if materials is None and (objects is None or (objects & ~np.uint8(HOLDOUT) == plain).all()):
        return None
    mesh = scene.mesh
    every = np.ones(len(mesh.triangles), np.bool_)
    flags = None if objects is None else objects[mesh.object_index]
    camera, shadow = (
        every if flags is None else (flags & kind) != 0 for kind in (CAMERA_RAYS, SHADOW_RAYS)
    )
    catcher = ~every if flags is None else (flags & SHADOW_CATCHER) != 0
    if materials is None:
        return RayMasks(camera, shadow, ~every, catcher, None)
    programs = scene.shaders.programs
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
    return RayMasks(camera, solid, hit_by_hit, catcher, opacity)


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


_PARTS = ("solid", "camera", "cut", "others")  # of RayParts


class RayParts:
    """The hierarchies that masks ask for; equal ones are built once."""

    def __init__(
        self,
        mesh: TriangleMesh,
        masks: RayMasks,
        cancelled=lambda: False,
        motion: ObjectMotion | None = None,
    ):
        def part(mask, opacity=None):
            return PartAccel(mesh, mask, cancelled, opacity, motion)

        self.mesh, self.masks = mesh, masks
        self.solid = part(masks.solid, masks.opacity)
        same = np.array_equal(masks.camera, masks.solid)
        self.camera = self.solid if same else part(masks.camera)
        self.cut = part(masks.cut) if masks.cut.any() else None
        self.others = self.solid
        if masks.catcher.any():
            self.others = part(masks.solid & ~masks.catcher, masks.opacity)

    def at(self, number: int) -> RayParts:
        """The same at a slice of the shutter's time."""
        other = copy.copy(self)
        for name in _PARTS:
            own = getattr(self, name)
            setattr(other, name, None if own is None else own.at(number))
        return other

    def moved(self, mesh: TriangleMesh, moves: Moves, cancelled=lambda: False) -> RayParts | None:
        """The same of a mesh that differs by moves; see moved_accel.moved."""
        other, made = copy.copy(self), {}
        other.mesh = mesh
        for name in _PARTS:
            own = getattr(self, name)
            if own is not None and own not in made:
                made[own] = own.moved(mesh, moves, cancelled)
            setattr(other, name, made.get(own))
        return None if None in made.values() else other

    def settle(self) -> None:
        """See moved_accel.settled."""
        for name in _PARTS:
            own = getattr(self, name)
            if own is not None:
                settled(own.accel)


class SceneRays:
    """What a render asks of an Accel, for one scene and its materials."""

    def __init__(self, scene: Scene, parts: RayParts, catchers: bool = True):
        """catchers: whether they throw shadows"""
        self._scene, self._parts = scene, parts
        self._solid = parts.solid if catchers else parts.others
        self.mesh, self.offset = scene.mesh, parts.camera.accel.offset
        self.traversal = self._solid.accel.traversal
        self.by_rays = parts.cut is not None

    def at(self, number: int, scene: Scene) -> SceneRays:
        """The same at a slice of the shutter's time, of which ``scene`` is."""
        return SceneRays(scene, self._parts.at(number))

    @property
    def without_catchers(self) -> SceneRays:
        """For the shadows that fall on catchers."""
        return SceneRays(self._scene, self._parts, catchers=False)

    def intersect(self, origins: np.ndarray, directions: np.ndarray):
        """The nearest hits that the camera sees; see Accel."""
        return self._parts.camera.intersect(origins, directions)

    def occluded(
        self, origins: np.ndarray, directions: np.ndarray, out=None, reach=None, towards=None
    ) -> np.ndarray:
        """Whether a ray ends at anything that throws a shadow; see Accel."""
        answer = self._solid.accel.occluded(origins, directions, out, reach, towards)
        if self._parts.cut is None:
            return answer
        out = answer != 0
        rays = np.flatnonzero(~out)
        origins, directions = origins[rays], directions[rays]
        reach = np.full(len(rays), np.inf, np.float32) if reach is None else reach[rays]
        for _ in range(MOST_LAYERS):
            hit, u, v = self._parts.cut.intersect(origins, directions)
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

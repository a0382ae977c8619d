"""Who sees which triangles: the camera, and the shadow rays of all lamps or of some."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..data.program_ops import asks_around, passes_by_angle
from ..embree.embree import can_filter
from ..embree.opacity_grids import Opacity
from ..scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS, Scene
from .clear_materials import cut_materials
from .opacity import bake_opacity


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class RayMasks:
    """Who sees which triangles, bool, one each.

    camera: what the camera sees
    solid: what throws a shadow that Embree knows of, opaque or with a grid of ``opacity``
    cut: what throws a shadow and is looked at hit by hit
    catcher: what catches shadows, and throws none on others of its kind
    linked: for each of Scene.lamp_links what throws shadows of its lamps
    near: what throws a shadow, where nodes ask what is near; None: none does
    clear: whether anything lets the camera's rays through
    """

    camera: np.ndarray
    solid: np.ndarray
    cut: np.ndarray
    catcher: np.ndarray
    opacity: Opacity | None
    linked: tuple[np.ndarray, ...] = ()
    near: np.ndarray | None = None
    clear: bool = False

    def same(self, other: RayMasks) -> bool:
        """Whether two are equal."""
        own, others = (
            (m.camera, m.solid, m.cut, m.catcher, *m.linked, m.near) for m in (self, other)
        )
        if len(own) != len(others) or not all(map(np.array_equal, own, others)):
            return False
        if self.clear != other.clear:
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
    near = shadow if scene.shaders is not None and asks_around(scene.shaders) else None
    catcher = ~every if flags is None else (flags & SHADOW_CATCHER) != 0
    if materials is None:
        return RayMasks(camera, shadow, ~every, catcher, None, linked, near)
    programs = scene.shaders.programs
    materials &= [program is None or not program.throws_whole_shadow for program in programs]
    able = can_filter()
    pairs = zip(materials, programs, strict=True)
    baked = [able and cut and passes_by_angle(program) for cut, program in pairs]
    cut = materials[mesh.material_index]
    with_grid = shadow & np.array(baked)[mesh.material_index]
    # Hits that are looked at one by one answer for all colors, and so do grids beside them.
    colored = not (shadow & cut & ~with_grid).any()
    opacity = bake_opacity(scene, with_grid, colored) if with_grid.any() else None
    if opacity is not None:
        with_grid = opacity.row >= 0
    solid, hit_by_hit = shadow & (~cut | with_grid), shadow & cut & ~with_grid
    return RayMasks(camera, solid, hit_by_hit, catcher, opacity, linked, near, clear=True)

"""Which instances are Embree's: those of a mesh that stands in many places (copies.py)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....core.data.copies import Copies
from ....core.data.program import Program
from ....core.data.program_ops import is_of_corners, ops_behind, passes_by_place
from ....core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_RAYS
from ..shaders.material import MaterialExport
from .instances import Inventory
from .placement import cofactors_of

# Triangles of a mesh, and of all its copies: with less of them rays gain nothing.
_LEAST, _LEAST_OF_ONE = 100, 20_000
# Triangles of all copies, a pixel: to write one out takes as long as these rays do by the way of
# instances (docs/decisions/0043-copies.md). At the least and, for the sake of memory, at the most.
_OF_A_PIXEL, _FEW, _MANY = 5, 500_000, 16_000_000
_PLAIN = CAMERA_RAYS | SHADOW_RAYS
# The part of its longest side that a box must have as its volume's root: else it is as good as flat
# and there is no way back from where it stands.
_LEAST_ROOM = 1e-3


class CopyPlan(NamedTuple):
    """originals: int64 (p,), rows of the inventory's instances; copies: int64 (n,), likewise;
    original: int32 (n,), which of the originals each copy shows."""

    originals: np.ndarray
    copies: np.ndarray
    original: np.ndarray

    def written(self, n: int) -> np.ndarray:
        """bool (n,), one an instance: whether it is in the mesh table."""
        found = np.ones(n, np.bool_)
        found[self.copies] = False
        return found


class Copying(NamedTuple):
    """How copies are looked for.

    materials_of: (materials, their users) -> MaterialExport, asked where there may be any
    pixels: of the picture, 0 in a window, which is to show it at once
    """

    materials_of: Callable[[list, list[list[str]]], MaterialExport]
    pixels: int

    def plan(self, inventory: Inventory, users: list[list[str]]) -> CopyPlan | None:
        """What to leave out of the mesh table; None: nothing. users: of the materials"""
        least = min(max(_OF_A_PIXEL * self.pixels, _FEW), _MANY)
        if not _may_copy(inventory, least):
            return None
        return plan_copies(inventory, self.materials_of(inventory.materials, users), least)


def same_plan(a: CopyPlan | None, b: CopyPlan | None) -> bool:
    """Whether two are equal."""
    if a is None or b is None:
        return a is b
    return all(map(np.array_equal, a, b))


def _may_copy(inventory: Inventory, least: int) -> bool:
    """Whether there may be enough copies, whatever the materials are."""
    sizes = np.array([len(part.triangles) for part in inventory.parts], np.int64)
    users = np.bincount([i.part for i in inventory.instances], minlength=len(sizes))
    more = np.maximum(users - 1, 0) * sizes
    enough = (sizes >= _LEAST) & (more >= _LEAST_OF_ONE)
    return int(more[enough].sum()) >= least


def plan_copies(inventory: Inventory, materials: MaterialExport, least: int) -> CopyPlan | None:
    """What stands in many places and can be told apart by its place alone; None: copies would have
    less than ``least`` triangles."""
    if inventory.links.there:
        return None
    plain = [_is_plain(materials, row) for row in range(len(materials.programs))]
    groups: dict[tuple, list[int]] = defaultdict(list)
    for row, instance in enumerate(inventory.instances):
        if instance.flags & ~HOLDOUT == _PLAIN and all(plain[slot] for slot in instance.slots):
            groups[instance.part, instance.slots].append(row)
    plans, saved = [], 0
    for (part, _), rows in groups.items():
        size = len(inventory.parts[part].triangles)
        if inventory.parts[part].round or size < _LEAST or (len(rows) - 1) * size < _LEAST_OF_ONE:
            continue
        matrices = np.array([inventory.instances[row].object_to_world for row in rows])
        good = _has_room(matrices)
        if good.sum() > 1:
            plans.append((np.array(rows)[good], _best(matrices[good])))
            saved += (int(good.sum()) - 1) * size
    if saved < least:
        return None
    originals = [rows[best] for rows, best in plans]
    copies = [np.delete(rows, best) for rows, best in plans]
    numbers = np.repeat(np.arange(len(plans), dtype=np.int32), [len(own) for own in copies])
    return CopyPlan(np.array(originals), np.concatenate(copies), numbers)


def _is_plain(materials: MaterialExport, row: int) -> bool:
    """Whether a material does nothing that asks for triangles of one's own: shine, move vertices,
    have light under it, or let shadow rays through by more than what the corners say."""
    program = materials.programs[row]
    if materials.displacements[row] is not None or materials.params.emission[row].any():
        return False
    if program is None:
        return True
    if program.emission is not None or any(
        closure.subsurface is not None or closure.hair is not None for closure in program.closures
    ):
        return False
    return program.transparent is None or _has_grids(program)


def _has_grids(program: Program) -> bool:
    ops = ops_behind(program, program.transparent)
    return passes_by_place(program) and all(map(is_of_corners, ops))


def _has_room(matrices) -> np.ndarray:
    """bool (n,): which of the places, float64 (n, 4, 4), have an inverse worth the name."""
    axes = matrices[:, :3, :3]
    longest = np.sqrt(np.einsum("nij,nij->nj", axes, axes)).max(axis=1)
    with np.errstate(all="ignore"):
        room = np.cbrt(np.abs(np.linalg.det(axes))) / longest
        return np.isfinite(matrices).all(axis=(1, 2)) & (room > _LEAST_ROOM)


def _best(matrices) -> int:
    """Which of these places float32 knows the most about: near the origin for its size."""
    size = np.cbrt(np.abs(np.linalg.det(matrices[:, :3, :3])))
    return int(np.argmin(np.linalg.norm(matrices[:, :3, 3], axis=1) / size))


def copies_of(plan: CopyPlan, inventory: Inventory, object_index: np.ndarray) -> Copies | None:
    """Of a mesh table with object_index, int32 (m,), an object's triangles one after another."""
    begins = np.flatnonzero(np.diff(object_index, prepend=-1) != 0)
    ends = np.append(begins[1:], len(object_index))
    span = np.zeros((len(inventory.instances), 2), np.int64)
    span[object_index[begins], 0], span[object_index[begins], 1] = begins, ends
    first, end = span[plan.originals].T
    there = (end > first)[plan.original]  # else nothing of it can be rendered
    copies, original = plan.copies[there], plan.original[there]
    if not len(copies):
        return None
    places = np.array([instance.object_to_world for instance in inventory.instances])
    back = np.linalg.inv(places[plan.originals])
    matrices = (places[copies] @ back[original])[:, :3]
    normals, turned = cofactors_of(matrices)
    own = copies.astype(np.int32), matrices.astype(np.float32)
    return Copies(*map(np.ascontiguousarray, (first, end)), original, *own, normals, turned)

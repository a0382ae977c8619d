"""What changes its shape while the shutter is open, read step by step, as Cycles reads it.

Each mesh, or what else may deform, is read at the steps of its object, and kept only where it
differs from the middle's; there must be as many vertices, else that step is as the middle. A mesh
whose vertices have velocities goes along these. An object's settings (and its instancer's) may keep
it from that: Motion Blur, Deformation.
"""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ....core.data.object_motion import Shapes
from ..free_memory import free_memory_bytes
from ..meshes.local_mesh import LocalMesh
from ..meshes.triangle_normals import make_unit, usable_vertices
from ..placed.mesh import MeshExport
from ..placed.placement import WITHOUT_PLACE, Transforms, corner_order, transform_points, users_of
from ..placed.triangle_rows import Rows, rows_of_instances
from .object_motion import Key, key_of
from .shape_readers import normals_along, reader_of, velocities_of

# Of an object's size: what modifiers that follow other objects round to is below.
_CHANGED = 1e-6
# Embree's hierarchy of a triangle, for each step but one; positions and normals are counted.
_STEP_BYTES = 110
_GIGABYTE = 1e9


class _Part(NamedTuple):
    """What may deform.

    reader: of shape_readers.py; None: it has been read
    rows: of the instances that show it so; steps: times from the first to the last, odd
    read: at each step but the middle: (positions, normals) as LocalMesh has them, in its object's
        own space; None = as in the middle
    """

    name: str
    local: LocalMesh
    reader: object
    rows: list[int]
    steps: int
    read: list[tuple[np.ndarray, np.ndarray] | None]


class ChangingShapes:
    """Made in the middle of the time, where all was exported; look() at each other time; then
    tables(), and lines()."""

    def __init__(self, depsgraph, geometry: MeshExport, steps: dict[Key, int], shutter: float):
        """steps: of Motions, of what may blur at all; shutter: frames from the first to the last"""
        self._geometry, self._parts = geometry, {}
        self._parts_of: dict[Key, list[int]] = defaultdict(list)
        self._other, self._large, self._free = {}, {}, free_memory_bytes()
        self._in_window = depsgraph.mode == "VIEWPORT"
        scene, rows, known = depsgraph.scene_eval, defaultdict(list), {}
        for row, instance in enumerate(geometry.inventory.instances):
            rows[Key(instance.name, instance.number)].append(row)
        for item in depsgraph.object_instances:
            key = key_of(item)
            if key not in rows or not steps.get(key):
                continue
            things = _things(item)
            if things not in known:
                known[things] = _asked(item, scene)
            if known[things].deforms:
                for row in rows.pop(key):
                    self._add(key, row, item, steps[key], known[things].velocities)
        self._by_velocity(scene.render, shutter)

    def _add(self, key: Key, row: int, item, steps: int, velocities) -> None:
        inventory = self._geometry.inventory
        instance = inventory.instances[row]
        number, part = instance.part, self._parts.get(instance.part)
        if part is None:
            local = inventory.parts[number]
            reader = velocities
            if velocities is None or instance.hair or local.diced is not None:
                reader = reader_of(inventory, instance, item, self._in_window)
            part = self._parts[number] = _Part(key.name, local, reader, [], steps, [])
        self._parts[number] = part._replace(steps=max(steps, part.steps), rows=[*part.rows, row])
        self._parts_of[key].append(number)

    def _by_velocity(self, render, shutter: float) -> None:
        """Have what has velocities read at three times, from these; make room for the others."""
        half = 0.5 * shutter * render.fps_base / render.fps
        for number, part in self._parts.items():
            self._parts[number] = part._replace(read=[None] * part.steps)
            if not isinstance(part.reader, np.ndarray):
                continue
            part = self._parts[number] = part._replace(steps=3, read=[None] * 3)
            if len(part.reader) == len(part.local.positions):
                for step, sign in ((0, -half), (2, half)):
                    moved = part.local.positions + np.float32(sign) * part.reader
                    self._keep(part, step, moved, normals_along(part.local, moved))

    def look(self, depsgraph, number: int, times: int) -> None:
        """Read what the graph has now, at time ``number`` of ``times`` from first to last."""
        done = set()
        for item in depsgraph.object_instances if self._parts else ():
            for which in self._parts_of.get(key_of(item), ()):
                part = self._parts[which]
                step, between = divmod(number * (part.steps - 1), times - 1)
                velocities = isinstance(part.reader, np.ndarray)
                if which in done or between or velocities or part.name in self._large:
                    continue
                done.add(which)
                self._read(part, step, item)
            if len(done) == len(self._parts):
                break

    def _read(self, part: _Part, step: int, item) -> None:
        own = part.reader.read(item)
        if own is None:
            self._other[part.name] = None
        else:
            self._keep(part, step, *own)

    def _keep(self, part: _Part, step: int, positions, normals) -> None:
        """Remember a step, if it differs from the middle's and there is room."""
        usable = usable_vertices(positions) & usable_vertices(part.local.positions)
        positions[~usable] = part.local.positions[~usable]
        size = float(np.abs(part.local.positions[usable]).max(initial=0.0))
        moved = np.abs(positions - part.local.positions)[usable].max(initial=0.0)
        if not moved > _CHANGED * size:
            return
        if not any(part.read) and not self._has_room(part):
            return
        part.read[step] = positions, normals

    def _has_room(self, part: _Part) -> bool:
        """Whether a part's steps fit beside those of others; else it is told, and not read on."""
        needed = _bytes_of(part)
        if self._free is not None and needed > self._free:
            self._large[part.name] = part.steps, needed, self._free
            return False
        if self._free is not None:
            self._free -= needed
        return True

    def tables(self) -> tuple[Shapes, ...]:
        """ObjectMotion.shapes: one for each number of steps."""
        changed = [part for part in self._parts.values() if any(part.read)]
        numbers = sorted({part.steps for part in changed})
        groups = [[part for part in changed if part.steps == number] for number in numbers]
        found = [_table(self._geometry, parts, k) for parts, k in zip(groups, numbers, strict=True)]
        return tuple(table for table in found if len(table.triangle))

    def lines(self, scene_name: str) -> list[str]:
        """A warning for each reason why something that changes stays sharp."""
        found = []
        if self._other:
            names = ", ".join(list(self._other)[:3]) + (", ..." if len(self._other) > 3 else "")
            found.append(
                f"Scene {scene_name}: {len(self._other)} objects have other vertices at other "
                "times, and are not blurred there but as in the middle of the time that the "
                f"shutter is open: {names}"
            )
        for name, (steps, needed, free) in self._large.items():
            found.append(
                f"Object {name}: its shapes at {steps} times need {needed / _GIGABYTE:.1f} GB, of "
                f"which {free / _GIGABYTE:.1f} are free: its change of shape is not blurred. Lower "
                "its Motion Blur, Steps, or its subdivision"
            )
        return found


class _Asked(NamedTuple):
    """What is the same for all instances of an object by another. velocities: of velocities_of"""

    deforms: bool
    velocities: np.ndarray | None


def _things(item) -> tuple:
    """Addresses of what _asked depends on."""
    parent = item.parent.as_pointer() if item.is_instance and item.parent else 0
    data = item.object.data
    real = item.instance_object if item.is_instance else item.object
    return real.as_pointer(), data.as_pointer() if data else 0, parent


def _asked(item, scene) -> _Asked:
    if not _wants(item):
        return _Asked(False, None)
    velocities = velocities_of(item)
    return _Asked(velocities is not None or _may_deform(item, scene), velocities)


def _wants(item) -> bool:
    """Whether an object, and what instances it, may be blurred by deformation."""
    owners = [item.object, *([item.parent] if item.is_instance and item.parent else [])]
    settings = (getattr(owner.original, "cycles", None) for owner in owners)
    return all(own is None or own.use_deform_motion for own in settings)


def _may_deform(item, scene) -> bool:
    """Cycles' rule: modifiers, shape keys, ... that may change it; geometry that is not the
    object's own is looked at always."""
    real = item.instance_object if item.is_instance else item.object
    if real.data is None or real.data.as_pointer() != item.object.data.as_pointer():
        return True
    return bool(real.is_deform_modified(scene, "RENDER"))


def _bytes_of(part: _Part) -> int:
    """Of all its steps: as read, and for each instance in world space, with the hierarchy."""
    local = part.local
    instances = len(part.rows)
    arrays = part.steps * 12 * int(_counts(local).sum()) * (1 + instances)
    return arrays + (part.steps - 1) * _STEP_BYTES * len(local.triangles) * instances


def _table(geometry: MeshExport, parts: list[_Part], steps: int) -> Shapes:
    """The shapes of all instances of parts, in world space."""
    part_of = {row: part for part in parts for row in part.rows}
    rows, instances = list(part_of), geometry.inventory.instances
    triangles, users = rows_of_instances(geometry, rows), users_of(geometry.inventory)
    transforms = Transforms.of([instances[row] for row in rows])
    ends = np.cumsum([_counts(part_of[row].local) for row in rows], axis=0)
    positions, normals = (np.empty((steps, n, 3), np.float32) for n in ends[-1])
    columns = []
    for k, row in enumerate(rows):
        part, own = part_of[row], triangles[row]
        first = ends[k] - _counts(part.local)
        places = positions[:, first[0] : ends[k, 0]], normals[:, first[1] : ends[k, 1]]
        moves = transforms.matrices[k], transforms.cofactors[k]
        _place(part, *moves, users[instances[row].part] > 1, *places)
        if geometry.rest is not None and geometry.rest.objects[row]:
            _displace(geometry, part.local, own, transforms.mirrors[k], *places)
        columns.append((own.table, *_corners(part.local, own, transforms.mirrors[k], *first)))
    table, corners, index = (np.concatenate(column) for column in zip(*columns, strict=True))
    order = np.argsort(table, kind="stable")
    corners, index = (np.ascontiguousarray(c[order].astype(np.int32)) for c in (corners, index))
    return Shapes(table[order], corners, positions, normals, index)


def _counts(local: LocalMesh) -> np.ndarray:
    """int64 (2,): how many positions and normals it has."""
    return np.array([len(local.positions), 0 if local.normals is None else len(local.normals)])


def _corners(local: LocalMesh, own: Rows, mirrored, first, first_normal):
    """Shapes.corners and normal_index of one instance; first: where its positions begin."""
    order = corner_order(mirrored)
    corners = local.triangles[own.local][:, order] + first
    index = np.full(corners.shape, -1)
    if local.normals is not None:
        index = local.normal_index[own.local][:, order] + first_normal
        if local.flat is not None:
            index[local.flat[own.local]] = -1
    return corners, index


def _place(part: _Part, matrix, cofactor, shared, positions, normals) -> None:
    """Write positions and normals of all steps, float32 (steps, n, 3) each, under a matrix, float32
    (3, 4)."""
    local = part.local
    turn = matrix * WITHOUT_PLACE if local.radial else cofactor
    for step, own in enumerate(part.read):
        places, vectors = (local.positions, local.normals) if own is None else own
        transform_points(matrix[None], places, positions[step : step + 1])
        if normals.shape[1]:
            transform_points(turn[None], vectors, normals[step : step + 1])
            if not shared:
                make_unit(normals[step])
    broken = ~usable_vertices(local.positions)
    if broken.any():  # no triangle names them
        positions[:, broken] = 0.0


def _displace(geometry, local: LocalMesh, own: Rows, mirrored, positions, normals) -> None:
    """Move all steps of an instance by what its material moves the middle by, as Cycles does, and
    turn normals by as much."""
    mesh, before, order = geometry.mesh, geometry.rest.mesh, corner_order(mirrored)
    corners, offsets = mesh.triangles[own.table], np.zeros_like(positions[0])
    moves = mesh.vertices[corners] - before.vertices[corners]
    offsets[local.triangles[own.local][:, order]] = moves
    positions += offsets
    if not normals.shape[1]:
        return
    smooth = slice(None) if local.flat is None else ~local.flat[own.local]
    index, table = local.normal_index[own.local][smooth][:, order], own.table[smooth]
    turns = np.zeros_like(normals[0])
    turns[index] = mesh.corner_normals[table] - before.corner_normals[table]
    normals += turns
    for step in normals:
        make_unit(step)

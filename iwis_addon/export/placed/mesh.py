"""The geometry of a dependency graph: read, checked, placed, and kept for the next frame."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ....core.data.copies import Copies
from ....core.data.program import AtRest
from ....core.scene import TriangleMesh
from ..images.texel_cache import TexelCache
from ..meshes.adaptive import Dicing
from ..meshes.local_mesh import LiveMeshes, LocalMesh
from ..meshes.mesh_size import check_size
from ..meshes.triangle_normals import usable_vertices
from ..objects.culling import Culling
from .copied import Copying, CopyPlan, copies_of, same_plan
from .instances import Instance, Inventory, collect_instances
from .placement import Placed, move_instances, place_instances

# Metres from the origin where float32 has steps of a centimetre: small triangles lose their area.
_FAR = 1e5
_FEW = 256  # instances that may always be moved one by one: no slower than all anew


class MeshExport(NamedTuple):
    """The geometry of a scene and what its rows mean.

    materials: evaluated bpy materials or None, row = TriangleMesh.material_index
    material_users: names of the objects that have each material in a slot, in their order
    object_pass_index, terminator_offset: float32 (n,), and object_flags: uint8 (n,), as in Scene:
        row = TriangleMesh.object_index
    inventory: where all came from; kept: bool, of all triangles those of mesh, and
        int32, the objects of all; None: all are in it
    rest: what there was before materials have moved vertices (displaced_mesh.py); None: none has
    copies: instances that are not in mesh themselves; None: all are
    """

    mesh: TriangleMesh
    materials: list
    material_users: list[list[str]]
    object_pass_index: np.ndarray
    terminator_offset: np.ndarray
    object_flags: np.ndarray
    inventory: Inventory
    kept: tuple[np.ndarray, np.ndarray] | None
    rest: AtRest | None = None
    copies: Copies | None = None


class _Merged(NamedTuple):
    """A mesh table; kept, copies: as in MeshExport; placed: None where triangles, or copies, were
    left out."""

    mesh: TriangleMesh
    kept: tuple[np.ndarray, np.ndarray] | None
    placed: Placed | None
    copies: Copies | None = None


class _Key(NamedTuple):
    """What an instance's triangles follow from."""

    name: str
    digest: bytes
    slots: tuple[int, ...]
    object_to_world: bytes

    @property
    def but_place(self):
        return self[:3]


class ExportCache:
    """Geometry and texels of the last frame, so that the next one copies only what has changed.

    Every frame of a background render comes with a new dependency graph, which says nothing of the
    last one: so meshes are compared by their content (a hash of all arrays), instances by their
    matrices and slots. When all are equal the very same TriangleMesh is returned, and whoever keeps
    a BVH may compare by ``is``.
    """

    def __init__(self):
        self.parts: dict[bytes, LocalMesh] = {}
        self.key = None
        self.plan: CopyPlan | None = None
        self.mesh: TriangleMesh | None = None
        self.copies: Copies | None = None
        self.placed: Placed | None = None  # only where all of it is in mesh
        self.kept: tuple[np.ndarray, np.ndarray] | None = None
        self.warnings: list[str] = []
        self.displaced = None  # of displaced_mesh.py
        self.texels = TexelCache()
        # Of a window: what need not be read again, and which items it shows (collect_instances).
        self.live: LiveMeshes | None = None
        self.shown = None

    def remember(self, key, plan, parts, merged: _Merged, warnings):
        self.parts = {part.digest: part for part in parts}
        self.key, self.plan, self.warnings = key, plan, warnings
        self.mesh, self.kept, self.placed, self.copies = merged

    def is_of(self, key, plan: CopyPlan | None) -> bool:
        """Whether the last frame's geometry is that of these."""
        return self.mesh is not None and key == self.key and same_plan(plan, self.plan)

    def moved(self, key, plan: CopyPlan | None, inventory: Inventory) -> _Merged | None:
        """What the last frame had, but for the matrices of copies; or where there are none, for
        those of a few, or of less than half, of its instances."""
        before = self.key
        if self.mesh is None or len(before) != len(key) or not same_plan(plan, self.plan):
            return None
        rows = [row for row, new in enumerate(key) if new != before[row]]
        if any(key[r].but_place != before[r].but_place for r in rows):
            return None
        if plan is not None and not plan.written(len(key))[rows].any():
            copies = copies_of(plan, inventory, self.mesh.object_index)
            return _Merged(self.mesh, self.kept, None, copies)
        if self.placed is None or len(rows) > max(_FEW, len(key) // 2):
            return None
        placed = move_instances(self.placed, inventory, rows)
        return None if placed is None else _Merged(placed.mesh, None, placed)


def _drop_triangles(mesh: TriangleMesh, keep, inventory: Inventory, warnings) -> TriangleMesh:
    """Leave out triangles without area and tell which objects had how many.

    Those without area of points and strands, and of what a scale of 0 hides, as animations and
    scatters do, are nobody's fault: not told.
    """
    parts, instances = inventory.parts, inventory.instances
    dropped = np.flatnonzero(~keep)
    if len(dropped) == 0:
        return mesh
    usable_vertex = usable_vertices(mesh.vertices)
    usable = usable_vertex[mesh.triangles[dropped]].all(axis=1)
    far = np.abs(mesh.vertices[usable_vertex]).max(initial=0.0) > _FAR
    advice = ", or bring the scene nearer to the origin" if far else ""
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for kind, chosen in enumerate((dropped[~usable], dropped[usable])):
        for row, n in enumerate(np.bincount(mesh.object_index[chosen], minlength=len(instances))):
            if n and not (kind and _is_meant(instances[row], parts)):
                counts[instances[row].name][kind] += int(n)
    for name, (broken, flat) in counts.items():
        warnings.append(
            f"Object {name}: {broken + flat} triangles left out ({flat} without area, "
            f"{broken} with a vertex that is infinite or not a number): clean up its mesh{advice}"
        )
    mesh.vertices[~usable_vertex] = 0.0  # no triangle names them, but bounds may be taken of all
    return TriangleMesh(
        vertices=mesh.vertices,
        triangles=mesh.triangles[keep],
        corner_normals=mesh.corner_normals[keep],
        material_index=mesh.material_index[keep],
        object_index=mesh.object_index[keep],
    )


def _is_meant(instance: Instance, parts) -> bool:
    """Whether triangles without area are as they should be."""
    return parts[instance.part].round or not instance.object_to_world[:3, :3].any()


def _material_users(inventory: Inventory) -> list[list[str]]:
    users: list[dict[str, None]] = [{} for _ in inventory.materials]
    for instance in inventory.instances:
        for row in instance.slots:
            users[row][instance.name] = None
    return list(map(list, users))


def _merge(inventory: Inventory, plan: CopyPlan | None, warnings, cancelled) -> _Merged:
    written = None if plan is None else plan.written(len(inventory.instances))
    check_size(inventory, written)
    placed = place_instances(inventory, cancelled, written)
    mesh, usable, kept = placed.mesh, placed.usable, None
    if not usable.all():
        kept = usable, mesh.object_index
        mesh = _drop_triangles(mesh, usable, inventory, warnings)
    if plan is not None:
        return _Merged(mesh, kept, None, copies_of(plan, inventory, mesh.object_index))
    return _Merged(mesh, kept, placed if kept is None else None)


def _kept(shown, culling: Culling | None):
    """collect_instances' ``shown``, without what is culled."""
    if culling is None:
        return shown
    return lambda item: (shown is None or shown(item)) and not culling.leaves_out(item)


def export_mesh(
    depsgraph,
    warnings: list[str],
    cache: ExportCache | None = None,
    cancelled=lambda: False,
    copying: Copying | None = None,
    dicing: Dicing | None = None,
    culling: Culling | None = None,
) -> MeshExport:
    """All geometry that the graph renders, in world space; each triangle is finite and has area.

    copying: what may be left out of the mesh table; None: nothing
    dicing: of adaptive subdivision; None: meshes are taken as their modifiers leave them
    culling: what is left out; None: nothing
    warnings: gets a line for each kind of object left out, and for each object with bad triangles
    cache: the same object for every frame of an animation; unchanged geometry is then reused
    Raises ExportError if there is too much, ExportCancelled as soon as cancelled() says so.
    """
    cached = (None,) * 4
    if cache is not None:
        cached = cache.parts, cache.live, cache.shown, cache.texels
    known, live, shown, texels = cached
    rest = live, _kept(shown, culling), texels, dicing
    inventory = collect_instances(depsgraph, warnings, known, cancelled, *rest)
    parts, instances = inventory.parts, inventory.instances
    pass_index = np.array([instance.pass_index for instance in instances], np.float32)
    lift = np.array([instance.terminator_offset for instance in instances], np.float32)
    flags = np.array([instance.flags for instance in instances], np.uint8)
    rest = inventory.materials, _material_users(inventory), pass_index, lift, flags
    plan = None if copying is None else copying.plan(inventory, rest[1])
    if cache is None:
        mesh, kept, _, copies = _merge(inventory, plan, warnings, cancelled)
        return MeshExport(mesh, *rest, inventory, kept, copies=copies)
    key = [
        _Key(i.name, parts[i.part].digest, i.slots, i.object_to_world.tobytes()) for i in instances
    ]
    if not cache.is_of(key, plan):
        lines: list[str] = []
        merged = cache.moved(key, plan, inventory) or _merge(inventory, plan, lines, cancelled)
        cache.remember(key, plan, parts, merged, lines)
    warnings.extend(cache.warnings)
    return MeshExport(cache.mesh, *rest, inventory, cache.kept, copies=cache.copies)

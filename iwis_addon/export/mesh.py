"""The geometry of a dependency graph: read, checked, placed, and kept for the next frame."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ...core.scene import TriangleMesh
from .errors import ExportError
from .instances import Inventory, collect_instances
from .local_mesh import LiveMeshes, LocalMesh
from .placement import place_instances, usable_vertices
from .texel_cache import TexelCache

# The corners of all triangles, three each, are counted in int32.
MOST_TRIANGLES = (1 << 31) // 3
# Metres from the origin where float32 has steps of a centimetre: small triangles lose their area.
_FAR = 1e5


class MeshExport(NamedTuple):
    """The geometry of a scene and what its rows mean.

    materials: evaluated bpy materials or None, row = TriangleMesh.material_index
    material_users: names of the objects that have each material in a slot, in their order
    object_pass_index, terminator_offset: float32 (n,), and object_flags: uint8 (n,), as in Scene:
        row = TriangleMesh.object_index
    inventory: where all came from; kept: bool, of all triangles those of mesh, and
        int32, the objects of all; None: all are in it
    """

    mesh: TriangleMesh
    materials: list
    material_users: list[list[str]]
    object_pass_index: np.ndarray
    terminator_offset: np.ndarray
    object_flags: np.ndarray
    inventory: Inventory
    kept: tuple[np.ndarray, np.ndarray] | None


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
        self.mesh: TriangleMesh | None = None
        self.kept: tuple[np.ndarray, np.ndarray] | None = None
        self.warnings: list[str] = []
        self.texels = TexelCache()
        # Of a window: what need not be read again, and which items it shows (collect_instances).
        self.live: LiveMeshes | None = None
        self.shown = None

    def remember(self, key, parts, mesh, kept, warnings):
        self.parts = {part.digest: part for part in parts}
        self.key, self.mesh, self.kept, self.warnings = key, mesh, kept, warnings


def _drop_triangles(mesh: TriangleMesh, keep, instances, warnings) -> TriangleMesh:
    """Leave out triangles without area and tell which objects had how many."""
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
            if n:
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


def _check_size(inventory: Inventory):
    parts, shares = inventory.parts, defaultdict(int)
    for instance in inventory.instances:
        part = parts[instance.part]
        shares[instance.name] += max(len(part.triangles), len(part.positions))
    total = sum(shares.values())
    if total > MOST_TRIANGLES:
        name = max(shares, key=shares.get)
        raise ExportError(
            f"The scene has {total:,} triangles with all its instances; the most is "
            f"{MOST_TRIANGLES:,}. Object {name} has {shares[name]:,} of them: reduce its copies or "
            f"its subdivision, or hide it from renders"
        )


def _material_users(inventory: Inventory) -> list[list[str]]:
    users: list[dict[str, None]] = [{} for _ in inventory.materials]
    for instance in inventory.instances:
        for row in instance.slots:
            users[row][instance.name] = None
    return list(map(list, users))


def _merge(inventory: Inventory, warnings, cancelled):
    """(mesh, MeshExport.kept)."""
    _check_size(inventory)
    mesh, has_area = place_instances(inventory, cancelled)
    kept = None if has_area.all() else (has_area, mesh.object_index)
    return _drop_triangles(mesh, has_area, inventory.instances, warnings), kept


def export_mesh(
    depsgraph, warnings: list[str], cache: ExportCache | None = None, cancelled=lambda: False
) -> MeshExport:
    """All geometry that the graph renders, in world space; each triangle is finite and has area.

    warnings: gets a line for each kind of object left out, and for each object with bad triangles
    cache: the same object for every frame of an animation; unchanged geometry is then reused
    Raises ExportError if there is too much, ExportCancelled as soon as cancelled() says so.
    """
    cached = (None,) * 3 if cache is None else (cache.parts, cache.live, cache.shown)
    known, live, shown = cached
    inventory = collect_instances(depsgraph, warnings, known, cancelled, live, shown)
    parts, instances = inventory.parts, inventory.instances
    pass_index = np.array([instance.pass_index for instance in instances], np.float32)
    lift = np.array([instance.terminator_offset for instance in instances], np.float32)
    flags = np.array([instance.flags for instance in instances], np.uint8)
    rest = inventory.materials, _material_users(inventory), pass_index, lift, flags
    if cache is None:
        mesh, kept = _merge(inventory, warnings, cancelled)
        return MeshExport(mesh, *rest, inventory, kept)
    key = [(i.name, parts[i.part].digest, i.object_to_world.tobytes(), i.slots) for i in instances]
    if cache.mesh is None or key != cache.key:
        lines: list[str] = []
        cache.remember(key, parts, *_merge(inventory, lines, cancelled), lines)
    warnings.extend(cache.warnings)
    return MeshExport(cache.mesh, *rest, inventory, cache.kept)

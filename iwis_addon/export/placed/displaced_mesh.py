"""The mesh table with the vertices that materials move where they belong."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from ....core.data.program import Displacement, SurfaceData
from ....core.fine_meshes.displacement import Asked, Copied, Displaced, Movable, displaced, torn
from ....core.scene import Camera, TriangleMesh
from ..errors import ExportCancelled
from ..meshes.local_mesh import LocalMesh
from ..meshes.triangle_normals import geometric_normals, make_unit
from ..shaders.material import MaterialExport
from .mesh import ExportCache, MeshExport
from .placement import Transforms, corner_order, transform_points
from .triangle_rows import rows_of_instances


class Kept(NamedTuple):
    """What the last export has displaced.

    values: of the objects, which the programs may ask for
    """

    source: TriangleMesh
    displacements: tuple[Displacement | None, ...]
    values: list[np.ndarray]
    found: Displaced | None


def displaced_geometry(
    geometry: MeshExport,
    materials: MaterialExport,
    surface: SurfaceData | None,
    camera: Camera,
    cache: ExportCache | None,
    cancelled,
) -> MeshExport:
    """The geometry with its vertices moved; the same one where no material moves any.

    surface: what the programs of materials ask for; cache: as for export_mesh: where nothing has
    changed its mesh is the very same one again; warnings: of objects that are too coarse for that
    Raises ExportCancelled soon after cancelled() says so.
    """

    def check():
        if cancelled():
            raise ExportCancelled

    moves = [displacement is not None for displacement in materials.displacements]
    inventory = geometry.inventory
    rows = [
        row
        for row, instance in enumerate(inventory.instances)
        if any(moves[slot] for slot in instance.slots) and not inventory.parts[instance.part].round
    ]
    if not rows:
        return geometry
    asked = Asked(surface, camera, materials.pass_index)
    found = _displaced(geometry, rows, cache, materials.displacements, asked, check)
    return geometry if found is None else geometry._replace(mesh=found.mesh, rest=found.rest)


def _displaced(geometry, rows, cache, displacements, asked: Asked, check) -> Displaced | None:
    kept, source = None if cache is None else cache.displaced, geometry.mesh
    surface = asked.surface
    values = [surface.color, surface.random, surface.pass_index, asked.material_pass_index]
    values += [surface.object_tables[name] for name in sorted(surface.object_tables)]
    known = kept is not None and kept.source is source
    if known and kept.displacements is displacements and _same(kept.values, values):
        return kept.found
    newer, mesh, kinds = bpy.app.version >= (5, 2), source, _movable(geometry, rows)
    if not newer:
        mesh, kinds = torn(source, kinds)
    found = displaced(mesh, displacements, kinds, asked, newer, check)
    if known and None not in (found, kept.found) and _same(_shape(kept.found), _shape(found)):
        found = kept.found
    if cache is not None:
        cache.displaced = Kept(source, displacements, values, found)
    return found


def _shape(found: Displaced):
    rest = found.rest
    return found.mesh.vertices, found.mesh.corner_normals, rest.mesh.corner_normals, rest.objects


def _same(these, others) -> bool:
    return len(these) == len(others) and all(map(np.array_equal, these, others))


def _movable(geometry: MeshExport, rows: list[int]) -> Movable:
    """rows: of instances that are displaced"""
    inventory, mesh = geometry.inventory, geometry.mesh
    instances = [inventory.instances[row] for row in rows]
    triangles, transforms = rows_of_instances(geometry, rows), Transforms.of(instances)
    flags, read = (np.zeros(len(mesh.triangles), np.bool_) for _ in range(3)), {}
    found, firsts, copied = Movable(*flags, np.zeros_like(mesh.vertices)), {}, []
    for k, (row, instance) in enumerate(zip(rows, instances, strict=True)):
        part, own = inventory.parts[instance.part], triangles[row]
        if not len(own.table):
            continue
        if instance.part not in read:
            source = None if part.diced is not None else inventory.sources[instance.part]
            read[instance.part] = _flat(source, part), _vertex_normals(source, part)
        flat, normals = read[instance.part]
        of_points = part.normals is None or part.normal_index is part.triangles
        found.movable[own.table], found.cornered[own.table] = True, not of_points
        found.flat[own.table] = flat[own.local]
        corners = part.triangles[own.local[0]][corner_order(transforms.mirrors[k])]
        first = mesh.triangles[own.table[0], 0] - corners[0]
        out = found.vertex_normals[first : first + len(normals)]
        transform_points(transforms.cofactors[k : k + 1], normals, out[None])
        make_unit(out)
        source, other = firsts.setdefault((instance.part, instance.slots), (first, instance))
        if source != first:
            copied += _copied(other, source, instance, first, len(normals))
    return found._replace(copied=tuple(copied))


def _copied(source, at: int, target, to: int, n: int) -> list[Copied]:
    """n vertices of an instance from ``to`` on, as those of the first one, from ``at`` on; none
    where that one is flat."""
    own, other = (np.array(i.object_to_world).reshape(4, 4) for i in (source, target))
    if abs(np.linalg.det(own[:3, :3])) < 1e-30:
        return []
    return [Copied(at, to, n, (other @ np.linalg.inv(own))[:3])]


def _flat(source, part: LocalMesh) -> np.ndarray:
    """bool (m,): triangles of flat faces, which may have normals of corners all the same."""
    m = len(part.triangles)
    if part.normals is None or part.flat is not None:
        return np.ones(m, np.bool_) if part.normals is None else part.flat
    sharp = None if source is None else source.attributes.get("sharp_face")
    if sharp is None or sharp.domain != "FACE":
        return np.zeros(m, np.bool_)
    flags, faces = np.empty(len(sharp.data), np.bool_), np.empty(m, np.int32)
    sharp.data.foreach_get("value", flags)
    source.loop_triangles.foreach_get("polygon_index", faces)
    return flags[faces]


def _vertex_normals(source, part: LocalMesh) -> np.ndarray:
    """float32 (n, 3), in object space: along these Cycles displaces, of custom normals their means.

    source: the bpy mesh; None: it is being edited, and has gone, or it is diced
    """
    if part.diced is not None:
        return part.normals
    if source is not None:
        normals = np.empty((len(source.vertices), 3), np.float32)
        source.vertex_normals.foreach_get("vector", normals.reshape(-1))
        return normals
    corners = part.positions[part.triangles]
    normals, _ = geometric_normals(*np.ascontiguousarray(corners.transpose(1, 0, 2)))
    found = np.zeros_like(part.positions)
    np.add.at(found, part.triangles, normals[:, None])
    make_unit(found)
    return found

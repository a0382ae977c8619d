"""What programs ask of meshes and objects: UV maps, colours, generated coordinates, tangents.

A table holds the values at the corners of the triangles of each mesh that is asked, once however
many instances it has; each triangle of the scene knows its row.

    uv:NAME         a UV map; "uv:" is the active one     color:NAME   a colour attribute, likewise
    generated       Blender's generated coordinates       tangent:NAME a UV map's tangents, and sign
    attribute:NAME  any attribute
    element:NAME    of points and strands (element_values.py), and of a mesh's shape

A table of objects holds a value for each instance: object:NAME, instancer:NAME and layer:NAME, of
object_properties.py, and origin:NAME, of origins.py.
"""

from __future__ import annotations

import numpy as np

from ....core.data.program import SurfaceData
from ....core.scene import TriangleMesh
from ..meshes.diced_values import DicedReader
from ..meshes.element_values import ElementReader
from ..meshes.mesh_values import MeshReader
from ..objects.object_properties import TABLES, InstanceValues, blocks_of, rgba_of
from ..objects.origins import ORIGIN
from .instances import Inventory


def surface_data(
    inventory: Inventory,
    mesh: TriangleMesh,
    kept: tuple[np.ndarray, np.ndarray] | None,
    requests: tuple[frozenset[str], ...],
) -> SurfaceData:
    """The tables of all that the materials of the scene ask for.

    kept: of MeshExport
    requests: of each material, rows as Inventory.materials
    """
    instances = inventory.instances
    wanted = [frozenset().union(*(requests[row] for row in i.slots)) for i in instances]
    names = sorted(frozenset().union(*wanted)) if wanted else []
    kinds = {ORIGIN, *TABLES.values()}
    of_objects = {name for name in names if name.partition(":")[0] in kinds}
    of_part: dict[int, set[str]] = {}
    for instance, some in zip(instances, wanted, strict=True):
        if not some <= of_objects:
            of_part.setdefault(instance.part, set()).update(some - of_objects)
    first, tables = _tables(inventory, of_part, [n for n in names if n not in of_objects])
    matrices = np.array([i.object_to_world for i in instances]).reshape(-1, 4, 4)
    return SurfaceData(
        row=_rows(inventory, mesh, kept, first),
        tables=tables,
        object_tables={name: _object_values(inventory, name) for name in of_objects},
        object_to_world=matrices,
        mirrored=np.linalg.det(matrices[:, :3, :3]) < 0.0,
        color=np.array([look.color for look in inventory.looks], np.float32).reshape(-1, 4),
        random=np.array([look.random for look in inventory.looks], np.float32),
        pass_index=np.array([i.pass_index for i in instances], np.float32),
    )


def _rows(inventory, mesh, kept, first) -> np.ndarray:
    """int32 (m,): the row in the tables of each triangle of the scene, -1 where it has none."""
    if not first:
        return np.full(len(mesh.triangles), -1, np.int32)
    sizes = np.array([len(inventory.parts[i.part].triangles) for i in inventory.instances])
    objects = mesh.object_index
    if kept is not None:  # rows are counted with the triangles that were left out
        kept, objects = kept
    start = np.full(len(sizes), len(objects), np.int64)
    np.minimum.at(start, objects, np.arange(len(objects)))
    begin = np.array([first.get(i.part, -1) for i in inventory.instances])
    local = np.arange(len(objects)) - start[objects]
    rows = np.where(begin[objects] < 0, -1, begin[objects] + local).astype(np.int32)
    return rows if kept is None else rows[kept]


def _tables(inventory, of_part, names):
    """(first row of each part, name -> float32 (rows, 3, width))."""
    first, parts, row = {}, [], 0
    for part, wanted in of_part.items():
        first[part] = row
        row += len(inventory.parts[part].triangles)
        reader = _reader_of(inventory.sources[part], inventory.parts[part])
        parts.append({name: reader.read(name) for name in wanted})
    tables = {}
    for name in names:
        values = [values.get(name) for values in parts]
        widths = [v.shape[2] for v in values if v is not None]
        if not widths:
            continue
        if len(of_part) == 1:
            tables[name] = np.ascontiguousarray(values[0], np.float32)
            continue
        sizes = [len(inventory.parts[part].triangles) for part in of_part]
        tables[name] = _joined(values, widths, sizes)
    return first, tables


def _joined(values, widths, sizes) -> np.ndarray:
    """float32 (rows, 3, width) of those of some parts, None: it has none, black and opaque.

    Where parts have attributes of several kinds by one name, width is 5 (coordinates.attribute).
    """
    width = widths[0] if len(set(widths)) == 1 else 5
    table, begin = np.zeros((sum(sizes), 3, width), np.float32), 0
    for value, size in zip(values, sizes, strict=True):
        own = table[begin : begin + size]
        begin += size
        if width >= 4:
            own[..., 3] = 1.0
        if value is None:
            continue
        if width < 5 or value.shape[2] != 1:
            own[..., : value.shape[2]] = value
        else:
            own[..., :3] = value
        if width == 5:
            own[..., 4] = value[..., 0] if value.shape[2] < 3 else value[..., :3].mean(-1)
    return table


def _reader_of(source, local):
    if local.round:
        return ElementReader(source, local)
    if local.diced is not None:
        return DicedReader(source.mesh, local)
    return MeshReader(source, local.corners)


def parts_with(inventory: Inventory, name: str) -> np.ndarray:
    """bool (n,): which parts have something of a name of tables, which is read."""
    parts = zip(inventory.sources, inventory.parts, strict=True)
    return np.array([_reader_of(*own).read(name) is not None for own in parts], np.bool_)


def _object_values(inventory, name) -> np.ndarray:
    """float32 (n, 4), by instance. name: a kind of table and what it is to find"""
    kind, _, own = name.partition(":")
    if kind == ORIGIN:
        values = [look.origin.value(own) for look in inventory.looks]
        return np.array(values, np.float32).reshape(-1, 4)
    made, known = InstanceValues(), {}
    values = np.zeros((len(inventory.looks), 4), np.float32)
    for row, look in enumerate(inventory.looks):
        found = made.rgba_of(look.asked, look.origin.index, own) if kind == "instancer" else None
        key = id(look.asked)  # an object's instances share it
        if found is None and key not in known:
            known[key] = rgba_of(blocks_of(kind, look.asked, inventory.layer), own)
        values[row] = known[key] if found is None else found
    return values

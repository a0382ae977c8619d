"""Which triangles of the scene's table are which of an instance's mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .mesh import MeshExport


class Rows(NamedTuple):
    """Of one instance: int32 (m,), its triangles in the table; int64 (m,), in its LocalMesh."""

    table: np.ndarray
    local: np.ndarray


def rows_of_instances(geometry: MeshExport, instances: list[int]) -> dict[int, Rows]:
    """By row of the instance. An object's triangles stand in the order of its LocalMesh."""
    objects, usable = geometry.mesh.object_index, None
    if geometry.kept is not None:
        usable, objects = geometry.kept
    wanted = np.zeros(len(geometry.inventory.instances), np.bool_)
    wanted[instances] = True
    every = np.flatnonzero(wanted[objects])
    own = objects[every]
    every, own = (column[np.argsort(own, kind="stable")] for column in (every, own))
    place = None if usable is None else np.cumsum(usable) - 1
    found = {}
    for row in instances:
        rows = every[slice(*np.searchsorted(own, (row, row + 1)))]
        local = np.arange(len(rows))
        if usable is not None:
            local, rows = local[usable[rows]], place[rows[usable[rows]]]
        found[row] = Rows(rows.astype(np.int32), local)
    return found

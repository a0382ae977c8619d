"""Meshes, strands and points at another time, in the rows of what was exported of them.

A reader is made while the graph shows what was exported; later it gives positions and normals,
float32 (n, 3) and (k, 3), in the object's own space; None where there are other vertices, strands
or points.
"""

from __future__ import annotations

import numpy as np

from ..meshes.diced_mesh import shape_at
from ..meshes.hair_curves import curve_strands
from ..meshes.local_mesh import LocalMesh, read_shape
from ..meshes.particle_hair import ParticleHair, hair_modifiers
from ..meshes.point_cloud import centers_and_radii
from ..meshes.point_spheres import divisions, make_spheres
from ..meshes.strand_tubes import Strands, find_rings, make_tubes
from ..meshes.triangle_normals import geometric_normals, make_unit
from ..placed.instances import Instance, Inventory

# Of a mesh: metres a second of each vertex, which is all that Cycles then takes.
_VELOCITY = "velocity"


def reader_of(inventory: Inventory, instance: Instance, item, in_window: bool):
    """The reader of an instance's part. item: of depsgraph.object_instances that shows it;
    in_window: of ParticleHair"""
    local, source = inventory.parts[instance.part], inventory.sources[instance.part]
    if local.diced is not None:
        return DicedShape(local)
    if not local.round:
        return MeshShape(local)
    if local.radial:
        return PointsShape(local, item.object.data)
    return StrandsShape(source.strands, source.shape, instance.hair, in_window)


class MeshShape:
    """Of an evaluated bpy mesh."""

    def __init__(self, local: LocalMesh):
        self._local = local

    def read(self, item):
        """See above. item: of depsgraph.object_instances"""
        return read_shape(item.object.data, self._local)


class DicedShape:
    """Of an evaluated bpy mesh that is subdivided adaptively: the same micropolygons elsewhere."""

    def __init__(self, local: LocalMesh):
        self._local = local

    def read(self, item):
        """See above."""
        return shape_at(self._local, item.instance_object if item.is_instance else item.object)


class PointsShape:
    """Of an evaluated bpy point cloud: the same spheres, elsewhere and of other sizes."""

    def __init__(self, local: LocalMesh, data):
        self._normals = local.normals
        _, radii = centers_and_radii(data)
        self._sized = np.flatnonzero(radii > 0.0)
        self._divided, self._count = divisions(radii[self._sized]), len(radii)

    def read(self, item):
        """See above."""
        if item.object.type != "POINTCLOUD" or len(item.object.data.points) != self._count:
            return None
        centers, radii = centers_and_radii(item.object.data)
        own = centers[self._sized], radii[self._sized], self._divided
        return make_spheres(*own).positions, self._normals


class StrandsShape:
    """Of curves, or of the hair of a modifier: tubes with as many sides, turned alike."""

    def __init__(self, strands: Strands, shape, hair: str, in_window: bool):
        self._middle, self._shape, self._hair = strands, shape, hair
        self._in_window = in_window
        self._rings = find_rings(strands, shape)

    def read(self, item):
        """See above."""
        strands = self._strands(item)
        if strands is None or not np.array_equal(strands.first, self._middle.first):
            return None
        made = make_tubes(strands, self._shape, self._rings, self._middle)
        return made.positions, made.normals

    def _strands(self, item) -> Strands | None:
        if not self._hair:
            return curve_strands(item.object.data) if item.object.type == "CURVES" else None
        emitter = item.instance_object if item.is_instance else item.object
        for modifier in hair_modifiers(emitter, self._in_window):
            if modifier.name == self._hair:
                return ParticleHair(emitter, modifier, self._in_window).read()
        return None


def velocities_of(item) -> np.ndarray | None:
    """float32 (n, 3), metres a second of the vertices of a mesh, if it says so."""
    data = item.object.data if item.object.type == "MESH" else None
    attribute = None if data is None else data.attributes.get(_VELOCITY)
    if attribute is None or (attribute.domain, attribute.data_type) != ("POINT", "FLOAT_VECTOR"):
        return None
    values = np.empty((len(attribute.data), 3), np.float32)
    attribute.data.foreach_get("vector", values.reshape(-1))
    return values


def normals_along(local: LocalMesh, positions: np.ndarray) -> np.ndarray | None:
    """LocalMesh.normals where its vertices have gone along velocities: means of the unit normals of
    a vertex' triangles, as Cycles makes them; of face corners as they were."""
    if local.normals is None or local.normal_index is not local.triangles:
        return local.normals
    flat, _ = geometric_normals(*(positions[corner] for corner in local.triangles.T))
    sums = np.empty_like(local.normals)
    for axis in range(3):
        weights = np.repeat(flat[:, axis], 3)
        sums[:, axis] = np.bincount(local.triangles.reshape(-1), weights, len(sums))
    good = make_unit(sums)
    return np.where(good[:, None], sums, local.normals)

"""What nodes ask of an evaluated bpy mesh, at the corners of its triangles: names of
surface_data.py."""

from __future__ import annotations

import numpy as np

from ....core.nodes.images import srgb_decode
from .element_values import READ
from .element_values import read_values as _get
from .mesh_shape import islands, pointiness
from .tangents import uv_tangents


class MeshReader:
    """Corner values of one evaluated bpy mesh (None: there is none), triangle by triangle."""

    def __init__(self, mesh, corners):
        self._mesh, self._corners = mesh, corners

    def read(self, name) -> np.ndarray | None:
        """float32 (m, 3, width), or None where the mesh has nothing of this name."""
        if self._mesh is None:
            return None
        kind, _, rest = name.partition(":")
        return getattr(self, f"_{kind}")(rest)

    def _of_corners(self, values):
        # "clip": indexing takes three times as long for rows so short.
        return np.take(values, self._corners, axis=0, mode="clip")

    def _of_points(self, values):
        vertices = _get(self._mesh.attributes[".corner_vert"].data, "value", 1, np.int32)[:, 0]
        return values[self._of_corners(vertices)]

    def _of_faces(self, values):
        polygons = _get(self._mesh.loop_triangles, "polygon_index", 1, np.int32)[:, 0]
        return np.repeat(values[polygons][:, None], 3, 1)

    def _uv(self, name):
        layers = self._mesh.uv_layers
        layer = layers.get(name) if name else next((x for x in layers if x.active_render), None)
        if layer is None:
            return None
        return self._of_corners(_get(layer.uv, "vector", 2, np.float32))

    def _color(self, name):
        colors = self._mesh.color_attributes
        index = colors.render_color_index
        if not name and not 0 <= index < len(colors):
            return None
        return self._attribute(name or colors[index].name)

    def _attribute(self, name):
        attribute = self._mesh.attributes.get(name)
        if attribute is None or attribute.data_type not in READ:
            return None
        values = _get(attribute.data, *READ[attribute.data_type]).astype(np.float32)
        if attribute.domain == "POINT":
            return self._of_points(values)
        if attribute.domain == "CORNER":
            return self._of_corners(values)
        if attribute.domain == "FACE":
            return self._of_faces(values)
        if attribute.data_type == "BYTE_COLOR":
            values = _get(attribute.data, "color_srgb", 4, np.float32)
        return self._of_points(self._mean_of_edges(values, attribute.data_type))

    def _mean_of_edges(self, values, kind) -> np.ndarray:
        """What vertices have of their edges, as Blender brings it there: the mean, rounded
        where it is whole, of truth any; of bytes of colors, cut off."""
        ends, n = _get(self._mesh.edges, "vertices", 2, np.int32).T, len(self._mesh.vertices)
        at, twice = ends.ravel(), np.tile(values.reshape(len(values), -1), (2, 1))
        sums = np.stack([np.bincount(at, column, n) for column in twice.T], -1)
        means = sums / np.maximum(np.bincount(at, minlength=n), 1)[:, None]
        if kind == "BOOLEAN":
            means = sums > 0.0
        elif kind.startswith("INT"):
            means = np.floor(means + 0.5)
        elif kind == "BYTE_COLOR":
            means = np.floor(means * 255.0 + 1e-3) / 255.0
            means[:, :3] = srgb_decode(means[:, :3])
        return means.reshape(n, *values.shape[1:]).astype(np.float32)

    def _generated(self, _):
        mesh = self._mesh
        values = _get(mesh.vertices, "undeformed_co", 3, np.float32)
        size, location = np.array(mesh.texspace_size), np.array(mesh.texspace_location)
        size = np.where(size != 0.0, size, 1.0)
        return self._of_points(((values - location) / (2.0 * size) + 0.5).astype(np.float32))

    def _element(self, name):
        if name == "Pointiness":
            return self._of_points(pointiness(self._mesh))
        if name == "Random Per Island":
            return self._of_points(islands(self._mesh))
        return None  # of points and strands alone

    def _tangent(self, name):
        return uv_tangents(self._mesh, name, self._corners)

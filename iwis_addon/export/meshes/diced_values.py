"""What nodes ask of a mesh that is diced: values of its cage, carried over to micropolygons.

As in Cycles all values are linear between the cage's, but for UV maps, which are smoothed as the
modifier says, and generated coordinates, as places are; islands and Pointiness are the cage's own.
"""

from __future__ import annotations

import numpy as np

from ....core.fine_meshes.bezier_patches import smooth_patches
from ....core.fine_meshes.subdivision import FOR_EVER, Control, make_control, with_sharp_corners
from .cage import after_steps, control_of, on_patches
from .diced_mesh import Diced
from .local_mesh import LocalMesh
from .mesh_values import MeshReader
from .tangents import flat_tangents

# Of the modifier's uv_smooth: corners of islands stay.
_CORNERS = (
    "PRESERVE_CORNERS",
    "PRESERVE_CORNERS_AND_JUNCTIONS",
    "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE",
)


class DicedReader(MeshReader):
    """Values at the corners of a part's triangles. mesh: its cage, a bpy mesh"""

    def __init__(self, mesh, local: LocalMesh):
        super().__init__(mesh, np.arange(len(local.diced.cage.corners)))
        self._local, self._diced = local, local.diced

    def read(self, name) -> np.ndarray | None:
        """float32 (m, 3, width), or None where the mesh has nothing of this name."""
        kind, _, rest = name.partition(":")
        if kind == "tangent":
            return self._tangent(rest)
        values = super().read(name)
        if values is None or kind in ("uv", "generated"):
            return values
        return self._carried(values)

    def _carried(self, values) -> np.ndarray:
        return _at_corners(on_patches(values, self._diced.cage.starts), self._diced)

    def _of_faces(self, values):
        return np.repeat(values, np.diff(self._diced.cage.starts), axis=0)

    def _uv(self, name):
        values = super()._uv(name)
        fineness = self._diced.fineness
        if values is None or fineness.linear or fineness.uv_smooth == "NONE":
            return None if values is None else self._carried(values)
        control = after_steps(self._uv_control(values), False, self._diced.steps_in_all)
        return _at_corners(_limits(control), self._diced, self._diced.steps)

    def _generated(self, rest):
        return self._smooth(super()._generated(rest))

    def _smooth(self, values):
        if values is None or self._diced.fineness.linear:
            return None if values is None else self._carried(values)
        cage = self._diced.cage
        points = np.zeros((len(cage.positions), values.shape[1]))
        points[cage.corners] = values
        control = control_of(cage, self._diced.fineness, points)
        control = after_steps(control, False, self._diced.steps_in_all)
        return _at_corners(_limits(control), self._diced, self._diced.steps)

    def _uv_control(self, values) -> Control:
        """The map as a mesh of its own, whose boundaries are its seams."""
        cage, fineness = self._diced.cage, self._diced.fineness
        whole = control_of(cage, fineness, cage.positions)
        rows = np.column_stack([cage.corners, np.ascontiguousarray(values).view(np.int32)])
        points, first, corners = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        made = make_control(values[first], corners.reshape(-1).astype(np.int32), cage.starts)
        sharp, points = made.sharp, whole.sharp_points[points[:, 0]]
        seams = sharp == FOR_EVER
        sharp[made.edge_of] = np.maximum(sharp[made.edge_of], whole.sharp[whole.edge_of])
        if fineness.uv_smooth == "PRESERVE_BOUNDARIES":
            points[made.ends[seams]] = FOR_EVER
        made = made._replace(sharp=sharp, sharp_points=points)
        return with_sharp_corners(made) if fineness.uv_smooth in _CORNERS else made

    def _tangent(self, name):
        """Of each micropolygon by itself: they are as small as pixels."""
        uv = self._uv(name)
        if uv is None:
            return None
        return flat_tangents(uv, self._local.positions[self._local.triangles])


def _at_corners(values, diced: Diced, steps: int = 0) -> np.ndarray:
    from ....core.fine_meshes.patch_values import at_corners  # the exporters load without numba

    return at_corners(values, diced.made, steps)


def _limits(control: Control) -> np.ndarray:
    """float32 (f, 4, d): where the corners of quads go in the limit."""
    points = smooth_patches(control)
    return np.stack([points[:, 0, 0], points[:, 0, 3], points[:, 3, 3], points[:, 3, 0]], 1)

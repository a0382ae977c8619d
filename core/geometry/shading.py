"""Hits -> shading points: position, normals, materials, all as arrays over the points of a tile."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..data.rows import any_in_row, rows_of
from ..scene import MaterialParams, TriangleMesh
from .terminator import patch_height


class ShadingPoints(NamedTuple):
    """Points that light is gathered at. All in world space.

    pixel: int32 (n,), index of the pixel in its tile, row by row
    triangle: int32 (n,)
    position: float32 (n, 3); wo: float32 (n, 3), unit, towards the camera
    geometric_normal, normal: float32 (n, 3), unit; of the face and interpolated, both on the side
        that the camera sees
    lift: float32 (n, 3), metres, from the face to the smooth patch over it; lift_below: float32
        (n,), the cosine below which a shadow ray gets part of it, 0 = none (terminator.py)
    through: float32 (n, 3), factor of what the camera sees of the point: colour of the cut-outs
        that its ray has gone through, over the probability of that (cutouts.py); 1 of none
    passed: int32 (n,), how many surfaces its ray has gone through; below 0: as many as it may, ~
        of their number, and of what it meets then it shows what glows alone
    """

    pixel: np.ndarray
    triangle: np.ndarray
    position: np.ndarray
    wo: np.ndarray
    geometric_normal: np.ndarray
    normal: np.ndarray
    lift: np.ndarray
    lift_below: np.ndarray
    through: np.ndarray
    passed: np.ndarray

    @property
    def reflecting(self) -> np.ndarray:
        """float32 (n, 3): through, of what reflects: 0 where only what glows is seen."""
        ended = self.passed < 0
        return (
            np.where(ended[:, None], np.float32(0.0), self.through) if ended.any() else self.through
        )

    def at(self, which) -> ShadingPoints:
        """Those of a slice, a mask or indices."""
        return ShadingPoints(*rows_of(self, which))

    def from_behind(self, which: np.ndarray) -> ShadingPoints:
        """The same, those of a mask, bool (n,), on the other side of their surface.

        There is no patch over that side (terminator.py): where a surface bulges, none would be.
        """
        side = np.where(which, np.float32(-1.0), np.float32(1.0))
        own = np.where(which, np.float32(0.0), np.float32(1.0))
        return self._replace(
            geometric_normal=self.geometric_normal * side[:, None],
            normal=self.normal * side[:, None],
            lift=self.lift * own[:, None],
            lift_below=self.lift_below * own,
        )

    def facing_viewer(self) -> ShadingPoints:
        """The same, none from behind."""
        away = np.einsum("ij,ij->i", self.geometric_normal, self.wo) < 0.0
        return self.from_behind(away) if away.any() else self


@kernel
def _interpolate(vertices, triangles, corner_normals, hit, u, v, directions, points):
    """Fill all but pixel, lift_below, through and passed."""
    for k in range(len(points.pixel)):
        pixel = points.pixel[k]
        triangle = hit[pixel]
        bu, bv = u[pixel], v[pixel]
        bw = np.float32(1.0) - bu - bv
        i0, i1, i2 = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
        ax = vertices[i1, 0] - vertices[i0, 0]
        ay = vertices[i1, 1] - vertices[i0, 1]
        az = vertices[i1, 2] - vertices[i0, 2]
        bx = vertices[i2, 0] - vertices[i0, 0]
        by = vertices[i2, 1] - vertices[i0, 1]
        bz = vertices[i2, 2] - vertices[i0, 2]
        gx, gy, gz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        inverse = np.float32(1.0) / np.sqrt(gx * gx + gy * gy + gz * gz)
        gx, gy, gz = gx * inverse, gy * inverse, gz * inverse
        facing = gx * directions[pixel, 0] + gy * directions[pixel, 1] + gz * directions[pixel, 2]
        side = np.float32(-1.0) if facing > 0.0 else np.float32(1.0)
        length = np.float32(0.0)
        for a in range(3):
            points.position[k, a] = (
                bw * vertices[i0, a] + bu * vertices[i1, a] + bv * vertices[i2, a]
            )
            points.wo[k, a] = -directions[pixel, a]
            normal = (
                bw * corner_normals[triangle, 0, a]
                + bu * corner_normals[triangle, 1, a]
                + bv * corner_normals[triangle, 2, a]
            )
            points.normal[k, a] = normal
            length += normal * normal
        points.geometric_normal[k, 0] = side * gx
        points.geometric_normal[k, 1] = side * gy
        points.geometric_normal[k, 2] = side * gz
        height = patch_height(
            vertices, i0, i1, i2, corner_normals, triangle, bu, bv, points.position, k, side
        )
        scale = side / np.sqrt(length)
        for a in range(3):
            points.lift[k, a] = side * height * points.normal[k, a]
            points.normal[k, a] = (
                points.normal[k, a] * scale if length > 0.0 else points.geometric_normal[k, a]
            )


def shading_points(
    mesh: TriangleMesh, hit, u, v, directions, terminator_offset: np.ndarray | None = None
) -> ShadingPoints:
    """The points of those rays that hit.

    hit: int32 (n,); u, v: float32 (n,); directions: float32 (n, 3)
    terminator_offset: float32, one an object (Scene.terminator_offset); None: 0 for all
    """
    pixel = np.flatnonzero(hit >= 0).astype(np.int32)
    n = len(pixel)
    vectors = (np.empty((n, 3), np.float32) for _ in range(5))
    through, passed = np.ones((n, 3), np.float32), np.zeros(n, np.int32)
    points = ShadingPoints(pixel, hit[pixel], *vectors, np.zeros(n, np.float32), through, passed)
    _interpolate(mesh.vertices, mesh.triangles, mesh.corner_normals, hit, u, v, directions, points)
    if terminator_offset is not None:
        # A flat face has no patch over it.
        lifted = any_in_row(points.lift)
        points.lift_below[:] = lifted * terminator_offset[mesh.object_index[points.triangle]]
    return points


def points_within(points: ShadingPoints, origins, reach) -> ShadingPoints:
    """The points within reach of where their rays began.

    origins: float32 (rays, 3); reach: float32 (rays,), metres
    """
    near_enough = np.empty(len(points.pixel), np.bool_)
    _find_within(points, origins, reach, near_enough)
    return points if near_enough.all() else points.at(near_enough)


@kernel
def _find_within(points, origins, reach, out):
    """Write whether points are within reach, bool (n,)."""
    for k in range(len(out)):
        ray, way = points.pixel[k], np.float32(0.0)
        for a in range(3):
            way += (origins[ray, a] - points.position[k, a]) * points.wo[k, a]
        out[k] = way <= reach[ray]


def params_at(materials: MaterialParams, rows: np.ndarray) -> MaterialParams:
    """One row of parameters for each shading point: materials taken at int32 rows (n,)."""
    return MaterialParams(*rows_of(materials, rows))

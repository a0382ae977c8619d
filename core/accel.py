"""Rays against triangles. The only file that knows Embree.

What embreex 4.4 is like: float32 only; no near distance, so origins are moved off the surface here
and nowhere else; the scene is committed by the first query, which is not safe in threads.
"""

import numpy as np
from embreex.mesh_construction import TriangleMesh as EmbreeMesh
from embreex.rtcore_scene import EmbreeScene

from ._jit import kernel
from .scene import TriangleMesh
from .terminator import lift_share

MISS = -1


class Accel:
    """The bounding volume hierarchy of one mesh table; queries release the GIL."""

    def __init__(self, mesh: TriangleMesh):
        self.mesh = mesh
        self.offset = ray_offset(mesh.vertices)
        self._scene = None
        if len(mesh.triangles):
            self._scene = EmbreeScene()
            EmbreeMesh(self._scene, mesh.vertices, mesh.triangles)
            self.occluded(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))

    def intersect(self, origins: np.ndarray, directions: np.ndarray):
        """The nearest hits: (triangle int32 (n,), MISS where none; u, v float32 (n,)).

        origins, directions: float32 (n, 3), world space. u and v weigh the triangle's second and
        third corner.
        """
        n = len(origins)
        if self._scene is None or n == 0:
            empty = np.zeros(n, np.float32)
            return np.full(n, MISS, np.int32), empty, empty
        hit = self._scene.run(origins, directions, query="INTERSECT", output=True)
        return hit["primID"].astype(np.int32), hit["u"], hit["v"]

    def occluded(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """bool (n,): whether anything lies on the ray. origins, directions: float32 (n, 3)."""
        n = len(origins)
        if self._scene is None or n == 0:
            return np.zeros(n, np.bool_)
        return self._scene.run(origins, directions, query="OCCLUDED") == 0


def ray_offset(vertices: np.ndarray) -> float:
    """How far a ray starts off its surface, in metres.

    Embree rounds to float32: a position is off by about 2^-24 of the largest coordinate, and the
    rays' own arithmetic by a few times that.
    """
    if len(vertices) == 0:
        return 0.0
    largest = float(np.abs(vertices).max())
    return max(largest, 1e-3) * 2.0**-19


@kernel(forceinline=True)
def start_shadow_ray(points, p, wx, wy, wz, lifted, offset, out, k):
    """Write to out[k] where a ray from shading point p to direction (wx, wy, wz) starts.

    points: ShadingPoints; offset: metres; lifted: from the smooth patch (terminator.py), not from
    the face. Returns False, and writes nothing, where it is the face and the direction is below
    it: what comes from there is occluded, whatever the interpolated normal says
    (docs/decisions/0005-light-from-below-the-face.md).
    """
    face, normal, position = points.geometric_normal, points.normal, points.position
    above = face[p, 0] * wx + face[p, 1] * wy + face[p, 2] * wz
    if lifted:
        cosine = normal[p, 0] * wx + normal[p, 1] * wy + normal[p, 2] * wz
        share = lift_share(above, cosine, points.lift_below[p])
        for a in range(3):
            out[k, a] = position[p, a] + offset * face[p, a] + share * points.lift[p, a]
        return True
    if above <= np.float32(0.0):
        return False
    for a in range(3):
        out[k, a] = position[p, a] + offset * face[p, a]
    return True

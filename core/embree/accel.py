"""Rays against triangles: the nearest hit, and whether there is any.

Embree is called directly (embree.py, embree_rays.py); where its library is not found, embreex's
Python layer stands in for it. Embree knows float32 only: shadow rays start off their surface, and
origins are moved in this file and nowhere else. Looks go on behind what they have met (Gone).
"""

from __future__ import annotations

import ctypes
import logging

import numpy as np

from .._jit import kernel
from ..geometry.terminator import lift_share
from ..machine.turns import aside
from ..machine.watch import Cancelled
from ..scene import TriangleMesh
from .embree import EmbreeScene, can_filter
from .embree_filter import LookFilter, ShadowFilter
from .embree_hits import Gone, begin_rays, intersect_block, intersect_together
from .embree_rays import ALL_COLORS, NOTHING, Traversal, occluded_block, occluded_within
from .opacity_grids import Opacity
from .triangle_pairs import Pairs, count_as_triangles, paired

log = logging.getLogger(__name__)

MISS = -1
_GREEN = 2
# Edges of so small a part of a triangle's coordinates are tiny; looked at: some triangles.
_TINY, _MOST_TINY, _SOME = 2.0**-16, 0.01, 4096


class Accel:
    """The bounding volume hierarchy of one mesh table; queries release the GIL.

    mesh: the table; opacity: as given; offset: metres that a ray must start off its surface;
    pairs: its triangles two by two, if that is how Embree has them;
    traversal: for kernels that trace rays themselves (embree_rays.py), while the Accel is held;
    by_rays: whether a subclass wants to be asked for every shadow ray by occluded() instead, which
    is slower
    """

    by_rays = False
    copies = None  # of Scene.copies, where it knows them
    _goes_on = False

    def __init__(self, mesh: TriangleMesh, cancelled=lambda: False, opacity: Opacity | None = None):
        """Build it, on all processors. Raises Cancelled soon after ``cancelled`` says so.

        opacity: what lets shadow rays through; only where embree.can_filter says so
        """
        self.mesh, self.opacity = mesh, opacity
        self.offset = ray_offset(mesh.vertices)
        self._scene, self.traversal, self.pairs = None, NOTHING, None
        if len(mesh.triangles) == 0:
            return
        try:
            self._scene = self._new_scene()
        except OSError as error:
            log.warning("IWIS: rays take the slow way, through embreex: %s", error)
            self._scene, self.pairs = EmbreexScene(mesh.vertices, mesh.triangles), None
        if not self._scene.commit(cancelled) or cancelled():
            raise Cancelled
        self.traversal = self._scene.traversal()

    def _new_scene(self) -> EmbreeScene:
        vertices, triangles = self.mesh.vertices, self.mesh.triangles
        if self.opacity is not None:  # its filter asks for triangles, and is asked once a surface
            return EmbreeScene(vertices, triangles, self.own_filter)
        if np.isfinite(vertices).all():  # a corner that is nowhere would take its whole quad
            self.pairs = paired(triangles)
        faces = triangles if self.pairs is None else self.pairs.corners
        return EmbreeScene(vertices, faces, aside=aside_of(vertices, triangles))

    @property
    def scene(self) -> EmbreeScene | None:
        """The hierarchy; None where there is no triangle, or embreex stands in."""
        return self._scene if isinstance(self._scene, EmbreeScene) else None

    def intersect(
        self, origins: np.ndarray, directions: np.ndarray, slots=None, gone: Gone | None = None
    ):
        """The nearest hits: (triangle int32 (n,), MISS where none; u, v float32 (n,)).

        origins, directions: float32 (n, 3), world space. u and v weigh the triangle's second and
        third corner. slots: of these rays; None: what is said of triangles of copies holds until
        the thread's next question. gone: behind which they are, and gets how far they are; None:
        rays begin
        """
        return self.as_triangles(*nearest_hits(self.looks, origins, directions, gone), slots)

    @property
    def own_filter(self) -> LookFilter | None:
        """What its hierarchies are to ask."""
        if self.opacity is not None:
            return ShadowFilter(self.opacity)
        return LookFilter() if self._goes_on else None

    @property
    def _hierarchies(self) -> list[EmbreeScene]:
        """Of triangles, as Embree has them."""
        return [] if self.scene is None else [self.scene]

    def go_on(self) -> None:
        """Have looks that go on behind a face meet what lies in its plane: they are a bit slower.

        Before it is asked for anything.
        """
        self._goes_on = True
        for scene in self._hierarchies if can_filter() else ():
            scene.go_on()

    def slots(self, n: int) -> np.ndarray | None:
        """int32 (n,), a row of the scene's tables for each of n rays (CopiedRows); None: they need
        none."""
        return None

    @property
    def every(self) -> Accel:
        """Of all triangles, opaque: see SceneRays."""
        return self

    throwing = every

    @property
    def looks(self) -> Traversal:
        """``traversal``, for kernels that ask for nearest hits themselves (embree_hits.py)."""
        return self.traversal

    def as_triangles(self, face, u, v, instance, slots=None):
        """What intersect gives, of what Embree says of rays that look: int32 and float32 (n,).

        The arrays may be written to.
        """
        to_triangles(self.pairs, face, u, v)
        return face, u, v

    @aside()
    def occluded(
        self, origins: np.ndarray, directions: np.ndarray, out=None, reach=None, towards=None
    ) -> np.ndarray:
        """bool (n,): whether anything lies on the ray. origins, directions: float32 (n, 3).

        out: bool (>= n,), written and returned as far as it was, instead of a new array; or uint8,
            which of red, green, blue is blocked: bits. Bool is green's answer.
        reach: float32 (n,), lengths of ``directions`` beyond which nothing counts; None: no end
        towards: int32 (n,), where rays of some reach go to, that those to the same may be compared
            (occluded_within); None: all to one place
        """
        n = len(origins)
        out = np.empty(n, np.bool_) if out is None else out[:n]
        colors = _GREEN if out.dtype == np.bool_ else ALL_COLORS
        if reach is None:
            occluded_block(self.traversal, origins, directions, n, colors, out)
        else:
            towards = np.zeros(n, np.int32) if towards is None else towards
            open_way = np.zeros(int(towards.max(initial=0)) + 1, np.bool_)
            rays = origins, directions, reach, towards, open_way
            occluded_within(self.traversal, *rays, n, colors, out)
        return out


def among(mesh: TriangleMesh, rows: np.ndarray) -> TriangleMesh:
    """Some of a mesh's triangles, int (k,), with all its vertices."""
    return TriangleMesh(
        vertices=mesh.vertices,
        triangles=mesh.triangles[rows],
        corner_normals=mesh.corner_normals[rows],
        material_index=mesh.material_index[rows],
        object_index=mesh.object_index[rows],
    )


def to_triangles(pairs: Pairs | None, hit: np.ndarray, u: np.ndarray, v: np.ndarray) -> None:
    """Make Accel.intersect's arrays of nearest_hits', in place."""
    if pairs is not None:
        count_as_triangles(pairs.first, pairs.turn, hit, u, v)


@aside()
def nearest_hits(
    traversal: Traversal, origins: np.ndarray, directions: np.ndarray, gone: Gone | None = None
):
    """Embree's own (face, u, v) of the nearest hits, and the instance's number, int32 (n,)."""
    n = len(origins)
    triangle, instance = np.empty(n, np.int32), np.empty(n, np.int32)
    u, v = np.empty(n, np.float32), np.empty(n, np.float32)
    found = triangle, instance, u, v
    if gone is None and traversal.intersect8 != 0:
        intersect_together(traversal, origins, directions, np.empty(n, np.float32), *found)
    else:
        gone = begin_rays(n) if gone is None else gone
        intersect_block(traversal, origins, directions, gone, *found)
    return triangle, u, v, instance


class EmbreexScene:
    """EmbreeScene by way of embreex: Python functions that look like Embree's own.

    It takes Python's lock for each packet of rays, and cannot be cancelled.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray):
        from embreex.mesh_construction import TriangleMesh as EmbreeMesh
        from embreex.rtcore_scene import EmbreeScene as Scene

        self._scene = Scene()
        EmbreeMesh(self._scene, vertices, triangles)
        word = ctypes.c_size_t
        self._functions = (
            ctypes.CFUNCTYPE(None, word, word, word)(lambda _, ray, __: self._occlude(ray, 1)),
            ctypes.CFUNCTYPE(None, *[word] * 4)(lambda _, __, rays, ___: self._occlude(rays, 8)),
            ctypes.CFUNCTYPE(None, word, word, word)(lambda _, ray, __: self._intersect(ray)),
        )

    def commit(self, cancelled) -> bool:
        """embreex builds when it is first asked."""
        self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
        return True

    def traversal(self) -> Traversal:
        """See EmbreeScene."""
        return Traversal(1, *(ctypes.cast(f, ctypes.c_void_p).value for f in self._functions))

    def _occlude(self, place: int, width: int) -> None:
        rays = _numbers_at(place, 12, width)
        origins, directions = np.ascontiguousarray(rays[:3].T), np.ascontiguousarray(rays[4:7].T)
        reach = rays[8].copy()  # embreex writes to it
        hit = self._scene.run(origins, directions, reach, query="OCCLUDED") == 0
        rays[8, hit] = -np.inf

    def _intersect(self, place: int) -> None:
        ray = _numbers_at(place, 18, 1)
        origin, near = ray[:3].T, float(ray[3, 0])
        if near > 0.0:  # embreex knows no such distance
            origin = origin + near * ray[4:7].T
            near += ray_offset(origin)
            origin = ray[:3].T + np.float32(near) * ray[4:7].T
        found = self._scene.run(origin, ray[4:7].T, query="INTERSECT", output=True)
        ray[15], ray[16], ray.view(np.int32)[17] = found["u"], found["v"], found["primID"]
        ray[8] = near + found["tfar"]


def _numbers_at(place: int, rows: int, width: int) -> np.ndarray:
    numbers = (ctypes.c_float * (rows * width)).from_address(place)
    return np.frombuffer(numbers, np.float32).reshape(rows, width)


def ray_offset(vertices: np.ndarray) -> float:
    """How far a ray starts off its surface, in metres.

    Embree rounds to float32: a position is off by about 2^-24 of the largest coordinate, and the
    rays' own arithmetic by a few times that.
    """
    if len(vertices) == 0:
        return 0.0
    largest = float(np.abs(vertices).max())
    return max(largest, 1e-3) * 2.0**-19


def aside_of(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Traversal.aside of a hierarchy that lets a ray in a million through, but is faster; or 0.

    Half an offset: eight times the gaps, and a ray stays above the face that it starts from. 0
    where triangles are so small, for where they are, that it were a ray in ten thousand.
    """
    some = vertices[triangles[:: max(1, len(triangles) // _SOME)]]
    longest = np.abs(some - np.roll(some, 1, axis=1)).max(axis=(1, 2))
    tiny = longest < _TINY * np.abs(some).max(axis=(1, 2))
    return 0.0 if tiny.mean() > _MOST_TINY else 0.5 * ray_offset(vertices)


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

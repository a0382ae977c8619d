"""What a node may ask of the shading points that it is evaluated at."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..data.program import SurfaceData
from ..data.rows import rows_of
from ..scene import Camera, TriangleMesh
from .from_camera import footprint_at, from_camera, ray_length_at
from .places import barycentric_of, in_shape, kernels, tangents_of
from .values import as_vector, column, dot, length, normalized, vector


class ShadeContext:
    """n points on triangles; what is costly is computed when it is first asked for.

    triangle: int32 (n,); barycentric: float32 (n, 2), weights of the second and third corner
    position, wo, normal, geometric_normal: float32 (n, 3), world space, as in ShadingPoints
    shadow: whether a shadow ray asks, and not the camera
    shape: (a mesh that has the triangles where the points lie on them, int32 (n,), their rows in
        it); None: mesh has them there
    near: near_rays.NearPoints, whom nodes ask what is around; None: nothing is
    rest: program.AtRest, of what was displaced; None: nothing was
    now: of points at_rest: where they are; None: they are there
    unmoved: of points that are moved for a bump: where they were; None: they are there
    passed: of ShadingPoints; None: nobody's ray has gone through anything
    """

    near = rest = now = unmoved = passed = None

    def __init__(
        self,
        mesh: TriangleMesh,
        surface: SurfaceData,
        camera: Camera,
        material_pass_index: np.ndarray,
        triangle,
        barycentric,
        position,
        wo,
        normal,
        geometric_normal,
        shadow=False,
        distance=None,
        shape=None,
    ):
        self.mesh, self.surface, self.camera = mesh, surface, camera
        self._material_pass_index = material_pass_index
        self.triangle, self.barycentric, self.position = triangle, barycentric, position
        self.wo, self.normal, self.geometric_normal = wo, normal, geometric_normal
        self.shadow = shadow
        self._distance = distance
        self._shape, self._faces = (mesh, triangle) if shape is None else shape

    @property
    def camera_ray(self) -> bool:
        """Whether the camera asks."""
        return not self.shadow

    @property
    def transparent_depth(self) -> np.ndarray | np.float32:
        """float32 (n,), or 0: how many surfaces rays have gone through."""
        if self.passed is None:
            return np.float32(0.0)
        return np.where(self.passed < 0, ~self.passed, self.passed).astype(np.float32)

    @classmethod
    def of_points(cls, scene, points, shadow=False, there=None) -> ShadeContext:
        """Of ShadingPoints of a Scene with shaders.

        there: the same where they are in the scene's pose, if nodes may ask what is around them
        """
        mesh, shaders = scene.mesh, scene.shaders
        shape, faces = in_shape(scene.pose, mesh, points.triangle)
        found = cls(
            mesh,
            shaders.surface,
            scene.camera,
            shaders.material_pass_index,
            points.triangle,
            barycentric_of(shape, faces, points.position),
            points.position,
            points.wo,
            points.normal,
            points.geometric_normal,
            shadow,
            shape=(shape, faces),
        )
        found.rest, found.passed = shaders.rest, points.passed
        if shaders.near is not None and there is not None:
            found.near = shaders.near.points(there)
        return found

    def __len__(self):
        return len(self.triangle)

    def take(self, which) -> ShadeContext:
        """Some of the points."""
        arrays = (self.triangle, self.barycentric, self.position, self.wo)
        arrays += (self.normal, self.geometric_normal)
        distance = None if self._distance is None else self._distance[which]
        taken = ShadeContext(
            self.mesh,
            self.surface,
            self.camera,
            self._material_pass_index,
            *rows_of(arrays, which),
            self.shadow,
            distance,
            (self._shape, self._faces[which]),
        )
        taken.near, taken.rest = None if self.near is None else self.near.at(which), self.rest
        taken.passed = None if self.passed is None else self.passed[which]
        return taken

    @cached_property
    def object(self) -> np.ndarray:
        """Row of the object, int (n,)."""
        return self.mesh.object_index[self.triangle]

    @cached_property
    def material_index(self) -> np.ndarray:
        return self._material_pass_index[self.mesh.material_index[self.triangle]]

    @cached_property
    def _world_to_object(self):
        """float64 (m, 4, 4): of the points' objects; rows of the others are not set."""
        matrices = self.surface.object_to_world
        inverses = np.empty_like(matrices)
        done = np.zeros(len(matrices), np.bool_)
        kernels().invert(matrices, self.object, done, inverses)
        return inverses

    @property
    def corners(self) -> np.ndarray | None:
        """float32 (n, 3, 3): of the points' triangles, world space; None: they are on none."""
        return self._shape.vertices[self._shape.triangles[self._faces]]

    @cached_property
    def backfacing(self) -> np.ndarray:
        """float32 (n,): 1 where the camera sees the back."""
        shape = self._shape
        a, b, c = (shape.vertices[corner] for corner in shape.triangles[self._faces].T)
        winding = dot(np.cross(b - a, c - a), self.geometric_normal) < 0.0
        return winding.astype(np.float32)

    @cached_property
    def object_position(self) -> np.ndarray:
        """float32 (n, 3), in the object's own space."""
        moved = np.empty((len(self), 3), np.float32)
        position = np.ascontiguousarray(self.position, np.float32)
        kernels().place(self._world_to_object, self.object, position, moved)
        return moved

    @cached_property
    def object_normal(self) -> np.ndarray:
        """float32 (n, 3): of the mesh's front, in the object's own space; between the corners it is
        shorter than 1, as what Cycles gives to normal maps."""
        normal = np.empty((len(self), 3), np.float32)
        corners = self._shape.corner_normals, self._faces, self.barycentric
        matrices = self.surface.object_to_world, self.object
        kernels().corner_normals_at(*corners, *matrices, normal)
        return normal

    def normal_to_object(self, vectors) -> np.ndarray:
        """World normals in the object's space, unit."""
        return self._turned(self.surface.object_to_world, vectors, True, True)

    def normal_to_world(self, vectors) -> np.ndarray:
        """Object normals in world space, unit."""
        return self._turned(self._world_to_object, vectors, True, True)

    def vector_to_world(self, vectors) -> np.ndarray:
        return self._turned(self.surface.object_to_world, vectors, False, False)

    def vector_to_object(self, vectors) -> np.ndarray:
        return self._turned(self._world_to_object, vectors, False, False)

    def _turned(self, matrices, vectors, transposed, unit) -> np.ndarray:
        vectors, turned = as_vector(vectors, len(self)), np.empty((len(self), 3), np.float32)
        kernels().turn(matrices, self.object, vectors, transposed, unit, turned)
        return turned

    def attribute(self, name: str) -> np.ndarray | None:
        """Corner values interpolated, float32 (n, width); zeros where a mesh has none of them."""
        table = self.surface.tables.get(name)
        if table is None:
            return None
        value = np.empty((len(self), table.shape[2]), np.float32)
        flipped = self.surface.mirrored[self.object]
        own = self.surface.row, self.triangle, flipped, self.barycentric
        kernels().interpolate(table, *own, value)
        return value

    def of_object(self, name: str) -> np.ndarray:
        """float32 (n, 4): what objects have of that name; 0 where none has."""
        table = self.surface.object_tables.get(name)
        return np.zeros((len(self), 4), np.float32) if table is None else table[self.object]

    def uv(self, name: str = "") -> np.ndarray:
        """float32 (n, 3) of a UV map, of the active one for ""; 0 where there is none."""
        found, value = np.zeros((len(self), 3), np.float32), self.attribute(f"uv:{name}")
        if value is not None:
            found[:, :2] = value
        return found

    @cached_property
    def generated(self) -> np.ndarray:
        value = self.attribute("generated")
        return self.object_position if value is None else value

    @property
    def parametric(self) -> np.ndarray:
        """float32 (n, 3): Cycles' own weights of a triangle's first and second corner, and 0."""
        u, v = self.barycentric[:, 0], self.barycentric[:, 1]
        flipped = self.surface.mirrored[self.object]
        u, v = np.where(flipped, v, u), np.where(flipped, u, v)
        return vector(1.0 - u - v, u, 0.0 * u)

    @cached_property
    def camera_position(self) -> np.ndarray:
        """float32 (n, 3): right, up, away from the camera."""
        return from_camera(self.camera, self.position)

    @cached_property
    def footprint(self) -> np.ndarray:
        """float32 (n,), metres that a pixel covers at the point, seen straight on."""
        if self.now is not None:
            return self.now.footprint
        return footprint_at(self.camera, self.camera_position)

    @property
    def ray_length(self) -> np.ndarray:
        """float32 (n,), metres from where the ray began."""
        if self._distance is not None:
            return self._distance
        return ray_length_at(self.camera, self.camera_position)

    def tangents(self, size) -> tuple[np.ndarray, np.ndarray]:
        """See places.tangents_of, of their faces."""
        return tangents_of(self.geometric_normal, size)

    def at_rest(self) -> ShadeContext:
        """The same points where they were before they were displaced, with their normals."""
        if self.rest is None:
            return self
        other, side = self.take(slice(None)), column(1.0 - 2.0 * self.backfacing)
        other._shape, other._faces, other.now = self.rest.mesh, self.triangle, self
        u, v = self.barycentric.T
        weights = np.stack([1.0 - u - v, u, v], -1)[:, :, None]
        a, b, c = other.corners.transpose(1, 0, 2)
        other.position = (weights * other.corners).sum(axis=1)
        normals = other._shape.corner_normals[self.triangle]
        other.normal = side * normalized((weights * normals).sum(axis=1))
        other.geometric_normal = side * normalized(np.cross(b - a, c - a))
        return other

    def steps(self, size, rescaled=False):
        """(two steps in the planes of the faces, two by which positions move) to where bumps look.

        size: float32 (n,), metres, on faces as they are now. Steps of points at_rest go along with
        these, positions as if they had not turned: as far, or rescaled to steps before Blender 5.2.
        """
        if self.now is None:
            return (self.tangents(size),) * 2
        a, b, c = self.corners.transpose(1, 0, 2)
        places = self.now.tangents(size)
        by = ((self.now.moved(step).barycentric - self.barycentric).T for step in places)
        found = [column(u) * (b - a) + column(v) * (c - a) for u, v in by]
        if rescaled:
            places = self.now.tangents(0.5 * (length(found[0]) + length(found[1])))
        return found, places

    def moved(self, offset, place=None) -> ShadeContext:
        """The same points moved in the planes of their faces. offset: float32 (n, 3), and place, of
        their positions, where that is another one"""
        other, shape = self.take(slice(None)), self._shape
        other.unmoved = self
        other.position = self.position + (offset if place is None else place)
        other.barycentric = other.barycentric.copy()
        own = shape.vertices, shape.triangles, self._faces
        kernels().move_barycentric(*own, as_vector(offset, len(self)), other.barycentric)
        return other

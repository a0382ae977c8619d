"""Vertices moved by their materials, before any ray: Cycles' displacement of settings Displacement
Only and Displacement and Bump.

A vertex goes where the first of its triangles with such a material sends it, evaluated at that
triangle's corner and with the normal of the vertex, of flat faces too (where corners have normals
of their own, with the corner's); all instances of a mesh have the shape of the first. Normals
follow the vertices, or stay where a bump turns them besides. Normals of face corners (sharp edges,
custom ones) turn by as much as those of their vertices do.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from ..data.program import AtRest, Displacement, SurfaceData
from ..nodes import Evaluation, ShadeContext
from ..nodes.values import normalized
from ..scene import Camera, TriangleMesh

_CHUNK = 1 << 16  # vertices evaluated together
_FARTHEST = 1e18  # metres: squares of distances would overflow
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], np.float32)  # barycentric


class Displaced(NamedTuple):
    """A mesh table with its vertices moved, and what there was before."""

    mesh: TriangleMesh
    rest: AtRest


class Copied(NamedTuple):
    """Vertices that go where others of the table go: of another instance of the same mesh.

    source, target: first vertices, of n each; matrix: float64 (3, 4), from the ones to the others
    """

    source: int
    target: int
    n: int
    matrix: np.ndarray


class Movable(NamedTuple):
    """What a mesh table does not tell of its triangles, bool (m,) each, and of its vertices.

    movable: whether a material may move them; flat: they have their geometric normal; cornered:
    they have normals of their corners, which may differ at one vertex
    vertex_normals: float32 (n, 3), unit, of the vertices of movable ones, however these are shaded
    copied: of instances that are moved as the first one of their mesh is
    """

    movable: np.ndarray
    flat: np.ndarray
    cornered: np.ndarray
    vertex_normals: np.ndarray
    copied: tuple[Copied, ...] = ()


class Asked(NamedTuple):
    """What displacements may ask for, beside the mesh: as in Shaders and Scene."""

    surface: SurfaceData
    camera: Camera
    material_pass_index: np.ndarray


def torn(mesh: TriangleMesh, kinds: Movable) -> tuple[TriangleMesh, Movable]:
    """Both with vertices of their own on either side of sharp edges, where normals of corners
    differ: Cycles before Blender 5.2 cuts such meshes there, and their sides come apart."""
    own = np.flatnonzero(kinds.cornered & kinds.movable)
    if not len(own):
        return mesh, kinds
    at, normals = mesh.triangles[own].ravel(), mesh.corner_normals[own].reshape(-1, 3)
    _, first, which = np.unique(_hashes(at, normals), return_index=True, return_inverse=True)
    vertex, n = at[first], len(mesh.vertices)
    _, keep = np.unique(vertex, return_index=True)
    number, extra = vertex.copy(), np.ones(len(vertex), np.bool_)
    extra[keep] = False
    number[extra] = np.arange(n, n + extra.sum(), dtype=np.int32)
    triangles = mesh.triangles.copy()
    triangles[own] = number[which].reshape(-1, 3)
    vertex_normals = np.concatenate([kinds.vertex_normals, normals[first][extra]])
    vertex_normals[number] = normalized(normals[first])
    cut = {"vertices": np.concatenate([mesh.vertices, mesh.vertices[vertex[extra]]])}
    kinds = kinds._replace(cornered=np.zeros_like(kinds.cornered), vertex_normals=vertex_normals)
    return dataclasses.replace(mesh, triangles=triangles, **cut), kinds


def _hashes(vertex, normal) -> np.ndarray:
    """uint64 (n,), the same for the same vertices with normals that are the same to 1e-4."""
    parts = (vertex, *np.rint(normal * np.float32(1e4)).T)
    primes = 0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93
    columns = [a.astype(np.int64).view(np.uint64) for a in parts]
    mixed = np.zeros(len(vertex), np.uint64)
    for column, prime in zip(columns, primes, strict=True):
        mixed = (mixed ^ column) * np.uint64(prime)  # wraps
        mixed ^= mixed >> np.uint64(29)
    return mixed


def displaced(
    mesh: TriangleMesh,
    displacements: tuple[Displacement | None, ...],
    kinds: Movable,
    asked: Asked,
    bumps_at_rest: bool = True,
    check=lambda: None,
) -> Displaced | None:
    """The mesh with its vertices moved; None where no material moves any.

    displacements: one a material; bumps_at_rest: whether bumps on flat faces begin with their
    normals at rest, as Cycles of Blender 5.2 does; else with those that they have now
    check() is called every few milliseconds, and may raise to stop.
    """
    moving = np.array([d is not None for d in displacements], np.bool_)[mesh.material_index]
    moving &= kinds.movable
    faces = np.flatnonzero(moving)
    if not len(faces):
        return None
    keeps = np.array([d is not None and d.keeps_normals for d in displacements], np.bool_)
    follows = moving & ~keeps[mesh.material_index]
    vertices = _moved_vertices(mesh, displacements, kinds, faces, asked, check)
    check()
    normals = _normals(mesh, vertices, kinds, moving, follows)
    begun, flat = mesh.corner_normals, np.flatnonzero(moving & ~follows & kinds.flat)
    if len(flat) and not bumps_at_rest:
        begun = begun.copy()
        begun[flat] = normals[flat]
    objects = np.zeros(len(asked.surface.mirrored), np.bool_)
    objects[mesh.object_index[faces]] = True
    smooth = kinds.movable & ~kinds.flat & objects[mesh.object_index]
    return Displaced(
        dataclasses.replace(mesh, vertices=vertices, corner_normals=normals),
        AtRest(dataclasses.replace(mesh, corner_normals=begun), objects, smooth),
    )


def _moved_vertices(mesh, displacements, kinds: Movable, faces, asked: Asked, check) -> np.ndarray:
    """TriangleMesh.vertices, those of some faces moved. What is no number moves nothing, as in
    Cycles, and so does what is too far to be rendered."""
    vertex, first = np.unique(mesh.triangles[faces], return_index=True)
    if kinds.copied:
        asks = np.ones(len(mesh.vertices), np.bool_)
        for copy in kinds.copied:
            asks[copy.target : copy.target + copy.n] = False
        vertex, first = vertex[asks[vertex]], first[asks[vertex]]
    face, corner = faces[first // 3].astype(np.int32), (first % 3).astype(np.int32)
    vertices = mesh.vertices.copy()
    for begin in range(0, len(vertex), _CHUNK):
        check()
        some = slice(begin, begin + _CHUNK)
        own, before = vertex[some], mesh.vertices[vertex[some]]
        at = face[some], corner[some]
        corners = kinds.cornered[at[0]][:, None]
        normals = np.where(corners, normalized(mesh.corner_normals[at]), kinds.vertex_normals[own])
        seen = *at, normals
        places = before + _offsets(mesh, displacements, asked, *seen)
        near = (np.abs(places) < _FARTHEST).all(axis=1, keepdims=True)
        vertices[own] = np.where(near, places, before)
    for copy in kinds.copied:
        check()
        moved = vertices[copy.source : copy.source + copy.n] @ copy.matrix[:, :3].T
        vertices[copy.target : copy.target + copy.n] = moved + copy.matrix[:, 3]
    return vertices


def _offsets(mesh, displacements, asked: Asked, face, corner, normal) -> np.ndarray:
    """float32 (n, 3), metres, at corners of faces, which have vertex normals."""
    offsets = np.zeros((len(face), 3), np.float32)
    rows = mesh.material_index[face]
    geometric = _face_normals(mesh.vertices, mesh.triangles[face])
    position = mesh.vertices[mesh.triangles[face, corner]]
    seen = face, _CORNERS[corner], position, geometric, normal, geometric
    context = ShadeContext(mesh, *asked, *seen)
    for row in np.unique(rows):
        which = np.flatnonzero(rows == row)
        displacement = displacements[row]
        evaluation = Evaluation(displacement.program, context.take(which))
        offsets[which] = evaluation.vector(displacement.value)
    return offsets


def _face_normals(vertices, triangles) -> np.ndarray:
    """float32 (m, 3), unit; 0 of what has no area."""
    a, b, c = (vertices[corner].astype(np.float64) for corner in triangles.T)
    return normalized(np.cross(b - a, c - a)).astype(np.float32)


def _vertex_normals(vertices, triangles) -> np.ndarray:
    """float32 (n, 3), unit: the sums of the unit normals of triangles; 0 of other vertices."""
    faces = np.repeat(_face_normals(vertices, triangles), 3, axis=0)
    at, n = triangles.ravel(), len(vertices)
    sums = [np.bincount(at, weights=axis, minlength=n) for axis in faces.T]
    return normalized(np.stack(sums, -1)).astype(np.float32)


def _normals(mesh: TriangleMesh, vertices, kinds: Movable, moving, follows):
    """TriangleMesh.corner_normals of moved vertices.

    moving: bool (m,), triangles whose materials displace; follows: of these those whose normals do
    not stay
    """
    normals, triangles = mesh.corner_normals.copy(), mesh.triangles
    # A vertex has one normal, which faces of other materials beside it have too.
    shared = np.zeros(len(vertices), np.bool_)
    shared[triangles[follows]] = True
    own = kinds.movable & ~kinds.flat & ~kinds.cornered
    smooth = np.flatnonzero(own & shared[triangles].any(axis=1))
    if len(smooth):
        whole, at = _vertex_normals(vertices, triangles[follows]), triangles[smooth]
        normals[smooth] = np.where(shared[at][..., None], whole[at], normals[smooth])
    objects = np.unique(mesh.object_index[moving & kinds.cornered])
    if len(objects):
        own = np.flatnonzero(np.isin(mesh.object_index, objects))
        before, after = (_vertex_normals(v, triangles[own]) for v in (mesh.vertices, vertices))
        own = own[kinds.cornered[own] & ~kinds.flat[own]]
        at = triangles[own]
        normals[own] = normalized(normals[own] + after[at] - before[at])
    moved = np.zeros(len(vertices), np.bool_)
    moved[triangles[moving]] = True
    flat = np.flatnonzero(moved[triangles].any(axis=1) & kinds.flat)
    normals[flat] = _face_normals(vertices, triangles[flat])[:, None]
    return normals

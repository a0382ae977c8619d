"""Tangents at the corners of a bpy mesh, along a UV map's u, as Cycles has them of Blender.

Of a mesh without UV maps they go round the object's axis z: along u of its undeformed vertices as
seen from the middle of the object, by MikkTSpace's means over the triangles of each vertex.
"""

from __future__ import annotations

import bpy
import numpy as np

from .element_values import read_values


def uv_tangents(mesh, name: str, corners) -> np.ndarray | None:
    """float32 (m, 3, 4): tangent and the bitangent's sign at the corners of its triangles.

    name: of a UV map; "": the active one; None: there is none of that name
    corners: int32 (m, 3), of LocalMesh
    """
    layers = mesh.uv_layers
    layer = layers.get(name) if name else next((x for x in layers if x.active_render), None)
    if layer is None:
        return None if name or len(layers) else _around_z(mesh, corners)
    try:
        mesh.calc_tangents(uvmap=layer.name)
    except RuntimeError:  # a face has more than four corners
        uv = read_values(layer.uv, "vector", 2, np.float32)[corners]
        return flat_tangents(uv, _places(mesh, "co")[_vertices(mesh, corners)])
    tangents = read_values(mesh.loops, "tangent", 3, np.float32)
    signs = read_values(mesh.loops, "bitangent_sign", 1, np.float32)
    mesh.free_tangents()
    return np.take(np.concatenate([tangents, signs], -1), corners, axis=0, mode="clip")


def flat_tangents(uv, p) -> np.ndarray:
    """float32 (m, 3, 4), of each triangle by itself. uv, p: (m, 3, 2) and (m, 3, 3), its corners"""
    values = np.concatenate(_of_triangles(uv, p), 1)
    return np.repeat(values[:, None], 3, 1).astype(np.float32)


def _places(mesh, name):
    return read_values(mesh.vertices, name, 3, np.float32)


def _vertices(mesh, corners):
    return read_values(mesh.attributes[".corner_vert"].data, "value", 1, np.int32)[corners, 0]


def _of_triangles(uv, p):
    """(m, 3), unit length or 0, and (m, 1): of each triangle by itself."""
    (du1, dv1), (du2, dv2) = ((uv[:, k] - uv[:, 0]).T for k in (1, 2))
    along = (p[:, 1] - p[:, 0]) * dv2[:, None] - (p[:, 2] - p[:, 0]) * dv1[:, None]
    sign = np.sign(du1 * dv2 - du2 * dv1)[:, None]
    return _unit(along * sign), sign


def _unit(vectors):
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0.0)


def _around_z(mesh, corners):
    """By the sphere that the vertices are seen on, as Cycles maps textures to one."""
    vertices, places = _vertices(mesh, corners), _places(mesh, "co")
    x, y, z = _unit(_places(mesh, "undeformed_co").astype(np.float64)).T
    u = np.where((x == 0.0) & (y == 0.0), 0.0, 0.5 - np.arctan2(x, y) / (2.0 * np.pi))
    uv = np.stack([u, 1.0 - np.arccos(np.clip(z, -1.0, 1.0)) / np.pi], -1)
    p = places[vertices].astype(np.float64)
    uv = uv[vertices]
    if bpy.app.version >= (5, 0):  # Cycles of before has a seam
        uv[..., 0] -= np.rint(uv[..., 0] - uv[:, :1, 0])
    along, sign = _of_triangles(uv, p)
    normals = _normals(mesh, corners, p)
    own = _unit(_beside(np.repeat(along[:, None], 3, 1), normals))
    weights = _angles(p, normals)
    # Corners of one vertex that have one normal and lie one way round are one.
    keys = np.concatenate([np.round(normals, 4), np.repeat(sign[:, None], 3, 1)], -1)
    keys = np.concatenate([vertices[..., None], keys], -1).reshape(-1, 5)
    _, groups = np.unique(keys, axis=0, return_inverse=True)
    weighted = (own * weights).reshape(-1, 3)
    sums = np.stack([np.bincount(groups.ravel(), column) for column in weighted.T], -1)
    values = [_unit(sums)[groups.ravel()].reshape(own.shape), np.repeat(sign[:, None], 3, 1)]
    return np.concatenate(values, -1).astype(np.float32)


def _normals(mesh, corners, p):
    """(m, 3, 3), at the corners; of flat faces each triangle's own."""
    normals = read_values(mesh.corner_normals, "vector", 3, np.float32)[corners].astype(np.float64)
    sharp = mesh.attributes.get("sharp_face")
    if sharp is None:
        return normals
    faces = read_values(mesh.loop_triangles, "polygon_index", 1, np.int32)[:, 0]
    flat = read_values(sharp.data, "value", 1, bool)[faces]
    own = _unit(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]))
    return np.where(flat[..., None], own[:, None], normals)


def _beside(vectors, normals):
    return vectors - normals * (vectors * normals).sum(-1, keepdims=True)


def _angles(p, normals):
    """(m, 3, 1): of a triangle's sides at its corners, as the normals see them."""
    ways = [_unit(_beside(np.roll(p, -k, 1) - p, normals)) for k in (1, 2)]
    return np.arccos(np.clip((ways[0] * ways[1]).sum(-1, keepdims=True), -1.0, 1.0))

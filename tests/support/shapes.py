"""Shapes that change while the shutter is open, and the slow way to a mesh in one of them."""

import dataclasses

import numpy as np

from iwis.core.data.object_motion import ObjectMotion, Shapes
from iwis.core.scene import CameraMotion

SLICES, STEPS = 64, 5
TIMES = (np.arange(SLICES) + 0.5) / SLICES


def shapes_of(mesh, objects, change, steps=STEPS) -> Shapes:
    """change(vertices, t): where they are at t of -0.5 ... 0.5, float64 (n, 3)."""
    rows = np.flatnonzero(np.isin(mesh.object_index, objects)).astype(np.int32)
    which, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    times = np.linspace(-0.5, 0.5, steps)
    positions = np.float32([change(mesh.vertices[which].astype(float), t) for t in times])
    positions[steps // 2] = mesh.vertices[which]
    # Normals that turn about z; half of the triangles have none of their own.
    turns = np.array(
        [[[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1]] for t in times]
    )
    normals = np.einsum("kij,nj->kni", turns, mesh.corner_normals[rows].reshape(-1, 3))
    index = np.arange(3 * len(rows), dtype=np.int32).reshape(-1, 3)
    index[::2] = -1
    corners = corners.reshape(-1, 3).astype(np.int32)
    return Shapes(rows, corners, positions, normals.astype(np.float32), index)


def standing(shapes, objects=(), matrices=None) -> ObjectMotion:
    """Motion of shapes, and of objects under matrices of -0.5 ... 0.5."""
    placed = np.zeros((SLICES, 0, 4, 4))
    if len(objects):
        placed = np.array([[f(t - 0.5) for f in matrices] for t in TIMES])
    return ObjectMotion(np.array(objects, np.int32), TIMES, placed, tuple(shapes))


def bent(vertices, t):
    """Sheared by the square of the height, and stretched."""
    x, y, z = vertices.T
    return np.stack([x + 1.5 * t * z * z, y * (1.0 + t), z + 0.3 * t * x], -1)


def shift(t):
    """A matrix."""
    matrix = np.eye(4)
    matrix[:3, 3] = (0.3 * t, -0.2 * t, 0.1 * t)
    return matrix


def standing_camera(camera):
    """The camera as one that moves has to be, where objects do."""
    motion = CameraMotion(
        camera.camera_to_world[None], np.array([camera.window]), np.linspace(0.0, 1.0, 2)
    )
    return dataclasses.replace(camera, motion=motion)


def mesh_at(scene, number):
    """The mesh table as it is in a slice: the slow way."""
    mesh, motion = scene.mesh, scene.motion
    time = motion.times[number]
    vertices, normals = mesh.vertices.astype(float), mesh.corner_normals.astype(float)
    for shapes in motion.shapes:
        place = time * (len(shapes.positions) - 1)
        i, part = int(place), place - int(place)
        positions = (1 - part) * shapes.positions[i] + part * shapes.positions[i + 1]
        vertices[mesh.triangles[shapes.triangle]] = positions[shapes.corners]
        own = (1 - part) * shapes.normals[i] + part * shapes.normals[i + 1]
        own = (own / np.linalg.norm(own, axis=1, keepdims=True))[shapes.normal_index]
        a, b, c = (positions[column] for column in shapes.corners.T)
        flat = np.cross(b - a, c - a)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        smooth = (shapes.normal_index >= 0).all(axis=1)[:, None, None]
        normals[shapes.triangle] = np.where(smooth, own, flat[:, None])
    for k, row in enumerate(motion.objects):
        matrix, own = motion.matrices[number, k], mesh.object_index == row
        which = np.unique(mesh.triangles[own])
        vertices[which] = vertices[which] @ matrix[:3, :3].T + matrix[:3, 3]
    return dataclasses.replace(
        mesh, vertices=vertices.astype(np.float32), corner_normals=normals.astype(np.float32)
    )

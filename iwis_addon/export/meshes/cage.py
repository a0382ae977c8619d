"""The mesh before its last modifier, which is diced, and values of its corners on the patches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.fine_meshes.subdivision import (
    FOR_EVER,
    Control,
    around,
    make_control,
    mean_of_faces,
    refined,
    with_sharp_corners,
)
from .adaptive import Fineness
from .element_values import read_values

# Creases of Blender, 0 to 1, as steps of OpenSubdiv, of which 10 are for ever.
_STEPS = np.float32(10.0)


class Cage(NamedTuple):
    """Arrays of a bpy mesh. positions: float32 (n, 3); corners: int32 (c,); starts: int32 (f + 1,)

    flat: bool (f,); slots: int32 (f,)
    creases: (int32 (k, 2), float32 (k,)), as of make_control; sharp_points: float32 (n,) or None
    """

    positions: np.ndarray
    corners: np.ndarray
    starts: np.ndarray
    flat: np.ndarray
    slots: np.ndarray
    creases: tuple[np.ndarray, np.ndarray] | None
    sharp_points: np.ndarray | None


def read_cage(mesh, fineness: Fineness) -> Cage:
    """Of an evaluated bpy mesh that has a face."""
    starts = read_values(mesh.polygons, "loop_start", 1, np.int32)[:, 0]
    creases, points = None, None
    if fineness.creases and not fineness.linear:
        weights = _values(mesh, "crease_edge", "EDGE", "FLOAT", np.float32)
        if weights is not None and weights.any():
            ends = read_values(mesh.edges, "vertices", 2, np.int32)
            creases = ends[weights > 0.0], _sharpness(weights[weights > 0.0])
        points = _values(mesh, "crease_vert", "POINT", "FLOAT", np.float32)
        points = None if points is None or not points.any() else _sharpness(points)
    faces = len(starts)
    flat = _values(mesh, "sharp_face", "FACE", "BOOLEAN", np.bool_)
    slots = _values(mesh, "material_index", "FACE", "INT", np.int32)
    return Cage(
        read_values(mesh.vertices, "co", 3, np.float32),
        _values(mesh, ".corner_vert", "CORNER", "INT", np.int32),
        np.append(starts, np.int32(len(mesh.loops))),
        np.zeros(faces, np.bool_) if flat is None else flat,
        np.zeros(faces, np.int32) if slots is None else np.maximum(slots, 0),
        creases,
        points,
    )


def _values(mesh, name, domain, kind, dtype) -> np.ndarray | None:
    attribute = mesh.attributes.get(name)
    if attribute is None or (attribute.domain, attribute.data_type) != (domain, kind):
        return None
    return read_values(attribute.data, "value", 1, dtype)[:, 0]


def _sharpness(weights) -> np.ndarray:
    steps = weights * _STEPS
    return np.where(steps >= _STEPS, FOR_EVER, steps).astype(np.float32)


def control_of(cage: Cage, fineness: Fineness, positions: np.ndarray) -> Control:
    """Before any step. positions: those of the cage, or at another time"""
    control = make_control(positions, cage.corners, cage.starts, cage.creases, cage.sharp_points)
    keeps = fineness.keeps_corners and not fineness.linear
    return with_sharp_corners(control) if keeps else control


def after_steps(control: Control, linear: bool, steps: int) -> Control:
    """After a number of steps."""
    for _ in range(steps):
        control = refined(control, linear)
    return control


def face_of_patches(cage: Cage) -> np.ndarray:
    """int32 (f,): the cage's face of each patch: after one step there is one for each corner."""
    faces = np.arange(len(cage.starts) - 1, dtype=np.int32)
    return np.repeat(faces, np.diff(cage.starts))


def on_patches(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """(f, 4, d), at the corners of patches: linear between values of the cage's corners, (c, d)."""
    after, before = around(starts)
    centers = np.repeat(mean_of_faces(values, starts), np.diff(starts), axis=0)
    halves = [(values + values[other]) * np.float32(0.5) for other in (after, before)]
    return np.stack([values, halves[0], centers, halves[1]], 1)

"""One constant for a value that varies over a surface: its mean over points of a square."""

from __future__ import annotations

import numpy as np

from ..data.program import Program, SurfaceData, Value
from ..scene import PERSPECTIVE, Camera, TriangleMesh
from .context import ShadeContext
from .evaluate import Evaluation

_SIDE = 12  # points along each side


class _Square(ShadeContext):
    """Points of a square whose every UV map is the square itself."""

    def attribute(self, name):
        if name.startswith("uv:"):
            return self.barycentric
        if name == "generated":
            return np.pad(self.barycentric, ((0, 0), (0, 1)), constant_values=0.5)
        if name in ("element:Pointiness", "element:Random Per Island"):
            return np.full((len(self), 1), 0.5, np.float32)
        return None


def _square() -> _Square:
    n = _SIDE * _SIDE
    axis = (np.arange(_SIDE, dtype=np.float32) + 0.5) / _SIDE
    uv = np.stack(np.meshgrid(axis, axis), -1).reshape(n, 2)
    up = np.tile(np.float32([0.0, 0.0, 1.0]), (n, 1))
    mesh = TriangleMesh(
        vertices=np.eye(3, dtype=np.float32)[[2, 0, 1]] * np.float32([1, 1, 0]),
        triangles=np.array([[0, 1, 2]], np.int32),
        corner_normals=np.tile(np.float32([0.0, 0.0, 1.0]), (1, 3, 1)),
        material_index=np.zeros(1, np.int32),
        object_index=np.zeros(1, np.int32),
    )
    surface = SurfaceData(
        row=np.zeros(1, np.int32),
        object_to_world=np.eye(4)[None],
        mirrored=np.zeros(1, bool),
        color=np.ones((1, 4), np.float32),
        random=np.full(1, 0.5, np.float32),
        pass_index=np.zeros(1, np.float32),
    )
    camera = Camera(
        kind=PERSPECTIVE,
        camera_to_world=np.array([[1, 0, 0, 0.5], [0, 1, 0, 0.5], [0, 0, 1, 1], [0, 0, 0, 1.0]]),
        window=(-0.5, 0.5, -0.5, 0.5),
        width=_SIDE,
        height=_SIDE,
        region=(0, 0, _SIDE, _SIDE),
        clip_start=0.0,
        clip_end=1e3,
    )
    position = np.pad(uv, ((0, 0), (0, 1)))
    rows = np.zeros(n, np.int32)
    return _Square(mesh, surface, camera, np.zeros(1, np.float32), rows, uv, position, up, up, up)


def mean_value(program: Program, value: Value) -> np.ndarray:
    """float32 () or (3,)"""
    evaluation = Evaluation(program, _square())
    found = evaluation.value(value)
    if np.ndim(found) == 2:
        return evaluation.vector(value).mean(0, dtype=np.float32)
    wide = np.shape(found) == (3,)
    return np.float32(found) if wide else np.float32(evaluation.number(value).mean())

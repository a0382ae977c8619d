"""A place in the picture -> ray."""

import numpy as np

from ._jit import kernel
from .scene import ORTHOGRAPHIC, Camera


@kernel
def _fill_rays(matrix, window, size, orthographic, x, y, origins, directions, near):
    left, right, bottom, top = window
    for k in range(len(x)):
        px = left + (right - left) * (x[k] / size[0])
        py = bottom + (top - bottom) * (y[k] / size[1])
        length = 1.0 if orthographic else np.sqrt(px * px + py * py + 1.0)
        for a in range(3):
            plane = matrix[a, 0] * px + matrix[a, 1] * py
            if orthographic:
                directions[k, a] = -matrix[a, 2]
                origins[k, a] = matrix[a, 3] + plane - near * matrix[a, 2]
            else:
                direction = (plane - matrix[a, 2]) / length
                directions[k, a] = direction
                origins[k, a] = matrix[a, 3] + near * length * direction


def rays_through(camera: Camera, x: np.ndarray, y: np.ndarray):
    """The rays through points of the frame: x, y float64 (n,), pixels, y up; centres are at .5.

    Returns origins on the near clipping plane and unit directions, float32 (n, 3), world space; the
    far plane is the caller's (``planar_depth``).
    """
    origins = np.empty((len(x), 3), np.float32)
    directions = np.empty((len(x), 3), np.float32)
    _fill_rays(
        np.ascontiguousarray(camera.camera_to_world, np.float64),
        tuple(float(edge) for edge in camera.window),
        (camera.width, camera.height),
        camera.kind == ORTHOGRAPHIC,
        x,
        y,
        origins,
        directions,
        float(camera.clip_start),
    )
    return origins, directions


def camera_rays(camera: Camera, x0: int, y0: int, nx: int, ny: int):
    """``rays_through`` the centres of nx x ny pixels from (x0, y0) up, row by row."""
    columns, rows = pixel_grid(x0, y0, nx, ny)
    return rays_through(camera, columns + 0.5, rows + 0.5)


def pixel_grid(x0: int, y0: int, nx: int, ny: int) -> tuple[np.ndarray, np.ndarray]:
    """Column and row in the frame of nx x ny pixels from (x0, y0) up, row by row: int64 (n,)."""
    rows, columns = np.divmod(np.arange(nx * ny), nx)
    return columns + x0, rows + y0


def planar_depth(camera: Camera, positions: np.ndarray) -> np.ndarray:
    """Metres along the camera's axis, float32 (n,), of world positions (n, 3): the Depth pass."""
    to_world = np.asarray(camera.camera_to_world, np.float64)
    return ((to_world[:3, 3] - positions) @ to_world[:3, 2]).astype(np.float32)

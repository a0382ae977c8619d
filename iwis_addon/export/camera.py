"""The camera object and the render's format to core.scene.Camera.

The window is Blender's view plane: the sensor's fitted side spans ``sensor / lens`` at distance 1
(an orthographic camera's ``ortho_scale``), the other side follows from pixels and pixel aspect, and
the lens shift is counted in units of the fitted side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.scene import ORTHOGRAPHIC, PERSPECTIVE, Camera
from .errors import ExportError


class _Lens(NamedTuple):
    """The fields of a camera; by default what Cycles takes for an object that is no camera."""

    type: str = "PERSP"
    lens: float = 50.0
    ortho_scale: float = 1.0
    sensor_fit: str = "AUTO"
    sensor_width: float = 36.0
    sensor_height: float = 24.0
    shift_x: float = 0.0
    shift_y: float = 0.0
    clip_start: float = 1e-5
    clip_end: float = 1e5


def frame_size(render) -> tuple[int, int]:
    """Pixels of the whole frame: Blender truncates the percentage."""
    percentage = render.resolution_percentage
    return (
        max(render.resolution_x * percentage // 100, 1),
        max(render.resolution_y * percentage // 100, 1),
    )


def border_region(render) -> tuple[int, int, int, int]:
    """The pixels to render, (x0, y0, x1, y1), y up: the border if it is used, else the frame.

    Blender multiplies in float32 and truncates; cropping moves no pixel.
    """
    width, height = frame_size(render)
    if not render.use_border:
        return 0, 0, width, height

    def span(low, high, size):
        first = min(int(np.float32(low) * np.float32(size)), size - 1)
        last = min(int(np.float32(high) * np.float32(size)), size)
        return first, max(last, first + 1)

    x0, x1 = span(render.border_min_x, render.border_max_x, width)
    y0, y1 = span(render.border_min_y, render.border_max_y, height)
    return x0, y0, x1, y1


def _lens_of(camera, warnings) -> _Lens:
    if camera.type != "CAMERA":
        warnings.append(f"Object {camera.name} is no camera: seen as through a 50 mm lens")
        return _Lens()
    data = camera.data
    if data.type not in ("PERSP", "ORTHO"):
        warnings.append(
            f"Camera {camera.name}: type {data.type} is not supported, rendered as perspective"
        )
    if data.dof.use_dof:
        warnings.append(f"Camera {camera.name}: depth of field is ignored, all is sharp")
    return _Lens(*(getattr(data, name) for name in _Lens._fields))


def _window(lens: _Lens, width, height, aspect) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) on the plane z = -1, or in metres for an orthographic camera.

    aspect: height of a pixel over its width
    """
    tall = height * aspect
    horizontal = lens.sensor_fit == "HORIZONTAL" or (lens.sensor_fit == "AUTO" and width >= tall)
    sensor = lens.sensor_height if lens.sensor_fit == "VERTICAL" else lens.sensor_width
    extent = lens.ortho_scale if lens.type == "ORTHO" else sensor / lens.lens
    pixel = extent / (width if horizontal else tall)
    half_x, half_y = 0.5 * width * pixel, 0.5 * tall * pixel
    x, y = lens.shift_x * extent, lens.shift_y * extent
    return x - half_x, x + half_x, y - half_y, y + half_y


def _without_scale(matrix, name):
    """float64 (4, 4), axes of length 1: Blender ignores a camera's scale, not its mirroring."""
    matrix = np.array(matrix, np.float64)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or not lengths.min() > 0.0:
        raise ExportError(
            f"Camera {name} has a scale of 0 or a transform that is not finite: set its scale to 1"
        )
    matrix[:3, :3] /= lengths
    matrix[3] = 0.0, 0.0, 0.0, 1.0
    return matrix


def export_camera(depsgraph, warnings: list[str], *, region=None) -> Camera:
    """The camera of the evaluated scene and its frame.

    region: (x0, y0, x1, y1) to render instead of the border
    Raises ExportError without a camera, or with one that has no size.
    """
    scene = depsgraph.scene_eval
    camera = scene.camera
    if camera is None:
        raise ExportError(
            f"Scene {scene.name} has no camera: add one, or choose one in the scene's properties"
        )
    render = scene.render
    lens = _lens_of(camera, warnings)
    if render.use_motion_blur:
        warnings.append(f"Scene {scene.name}: motion blur is ignored, the frame stands still")
    width, height = frame_size(render)
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    return Camera(
        kind=ORTHOGRAPHIC if lens.type == "ORTHO" else PERSPECTIVE,
        camera_to_world=_without_scale(camera.matrix_world, camera.name),
        window=_window(lens, width, height, aspect),
        width=width,
        height=height,
        region=border_region(render) if region is None else tuple(region),
        clip_start=lens.clip_start,
        clip_end=lens.clip_end,
    )

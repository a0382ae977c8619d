"""The camera object and the render's format to core.scene.Camera.

The window is Blender's view plane: the sensor's fitted side spans ``sensor / lens`` at distance 1
(an orthographic camera's ``ortho_scale``), the other side follows from pixels and pixel aspect, and
the lens shift is counted in units of the fitted side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.scene import ORTHOGRAPHIC, PANORAMIC, PERSPECTIVE, Camera, Lens
from ..errors import ExportError
from .panorama import panorama_of

# Cycles' limits of what it divides by.
_LEAST_FSTOP, _LEAST_FOCUS = 1e-5, 1e-5


class _Optics(NamedTuple):
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


def _is_horizontal(optics, width, tall) -> bool:
    """Whether the sensor is fitted to the frame's width. tall: height in pixels' widths"""
    return optics.sensor_fit == "HORIZONTAL" or (optics.sensor_fit == "AUTO" and width >= tall)


def _window(optics: _Optics, width, tall) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) on the plane z = -1, or in metres for an orthographic camera."""
    vertical = optics.sensor_fit == "VERTICAL"
    sensor = optics.sensor_height if vertical else optics.sensor_width
    extent = optics.ortho_scale if optics.type == "ORTHO" else sensor / optics.lens
    pixel = extent / (width if _is_horizontal(optics, width, tall) else tall)
    half_x, half_y = 0.5 * width * pixel, 0.5 * tall * pixel
    x, y = optics.shift_x * extent, optics.shift_y * extent
    return x - half_x, x + half_x, y - half_y, y + half_y


def camera_lens(camera) -> Lens | None:
    """The aperture of a camera object, or None where all is sharp."""
    if camera.type != "CAMERA" or not camera.data.dof.use_dof:
        return None
    data, dof = camera.data, camera.data.dof
    # Blender's lens is in millimetres; an orthographic camera has none, Cycles takes a metre.
    length = 1.0 if data.type == "ORTHO" else data.lens * 1e-3
    return Lens(
        radius=length / (2.0 * max(dof.aperture_fstop, _LEAST_FSTOP)),
        focus=max(_focus_distance(camera, dof), _LEAST_FOCUS),
        blades=dof.aperture_blades,
        rotation=dof.aperture_rotation,
        ratio=dof.aperture_ratio,
    )


def _focus_distance(camera, dof) -> float:
    """Metres along the camera's axis."""
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    place = target.matrix_world
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose else None
    if bone is not None:
        place = place @ bone.matrix
    eye = camera.matrix_world
    return abs((eye.translation - place.translation).dot(eye.col[2].to_3d().normalized()))


def camera_optics(camera, render, warnings: list[str]) -> dict:
    """Fields of core.scene.Camera that follow from a camera object and the frame: kind, window,
    clipping, panorama and lens."""
    width, height = frame_size(render)
    tall = height * render.pixel_aspect_y / render.pixel_aspect_x
    if camera.type == "CAMERA":
        optics = _Optics(*(getattr(camera.data, name) for name in _Optics._fields))
    else:
        optics = _Optics()
        warnings.append(f"Object {camera.name} is no camera: seen as through a 50 mm lens")
    panorama, kind = None, ORTHOGRAPHIC if optics.type == "ORTHO" else PERSPECTIVE
    if optics.type == "PANO":
        horizontal = _is_horizontal(optics, width, tall)
        panorama = panorama_of(
            camera.data, horizontal, tall / width if horizontal else width / tall
        )
    if panorama is not None:
        kind, (x, y) = PANORAMIC, (optics.shift_x, optics.shift_y)
        window = x, 1.0 + x, y, 1.0 + y
    else:
        window = _window(optics, width, tall)
        if optics.type not in ("PERSP", "ORTHO"):
            kind_of = f"Camera {camera.name}: type {optics.type}"
            warnings.append(f"{kind_of} is not supported, rendered as perspective")
    return {
        "kind": kind,
        "window": window,
        "clip_start": optics.clip_start,
        "clip_end": optics.clip_end,
        "panorama": panorama,
        "lens": camera_lens(camera),
    }


def camera_matrix(camera):
    """float64 (4, 4), axes of length 1: Blender ignores a camera's scale, not its mirroring."""
    matrix, name = np.array(camera.matrix_world, np.float64), camera.name
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or not lengths.min() > 0.0:
        raise ExportError(
            f"Camera {name} has a scale of 0 or a transform that is not finite: set its scale to 1"
        )
    matrix[:3, :3] /= lengths
    matrix[3] = 0.0, 0.0, 0.0, 1.0
    return matrix


def export_camera(depsgraph, warnings: list[str], *, region=None, own=None) -> Camera:
    """The camera of the evaluated scene and its frame.

    region: (x0, y0, x1, y1) to render instead of the border; own: the camera's object, where it is
        not to be the one that the scene has now
    Raises ExportError without a camera, or with one that has no size.
    """
    scene = depsgraph.scene_eval
    camera = scene.camera if own is None else own.evaluated_get(depsgraph)
    if camera is None:
        raise ExportError(
            f"Scene {scene.name} has no camera: add one, or choose one in the scene's properties"
        )
    render = scene.render
    optics = camera_optics(camera, render, warnings)
    width, height = frame_size(render)
    return Camera(
        camera_to_world=camera_matrix(camera),
        width=width,
        height=height,
        region=border_region(render) if region is None else tuple(region),
        **optics,
    )

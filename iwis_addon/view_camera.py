"""What a 3D view sees, as core.scene.Camera, and which of its pixels are to be rendered.

Lens, sensor, shift, zoom, offset and the camera's frame are all in the view's own projection
matrix: so the picture lies under Blender's overlays to the pixel. A panorama, which Blender shows
as a perspective camera's frame, fills that frame.
"""

from __future__ import annotations

import numpy as np

from ..core.scene import ORTHOGRAPHIC, PANORAMIC, PERSPECTIVE, Camera
from .export.cameras.camera import camera_lens, camera_optics


def view_camera(region, region_3d, space, scene, pixel_size: int) -> Camera | None:
    """The camera of a view; None where its border leaves nothing to render.

    region: of bpy; region_3d, space: its RegionView3D and SpaceView3D; scene: evaluated
    pixel_size: pixels of the screen to a pixel of the picture, in either direction
    """
    width, height = max(region.width, 1), max(region.height, 1)
    matrix = np.array(region_3d.window_matrix, np.float64)
    columns, rows = -(-width // pixel_size), -(-height // pixel_size)
    seen = _optics(matrix, width, height, region_3d, space, scene)
    left, right, bottom, top = seen["window"]
    covered = _border(matrix, width, height, region_3d, space, scene)
    x0, y0, x1, y1 = (edge / pixel_size for edge in covered)
    x0, y0 = max(int(x0), 0), max(int(y0), 0)
    x1, y1 = min(int(np.ceil(x1)), columns), min(int(np.ceil(y1)), rows)
    if x0 >= x1 or y0 >= y1:
        return None
    seen["window"] = (
        left,
        left + (right - left) * (columns * pixel_size / width),
        bottom,
        bottom + (top - bottom) * (rows * pixel_size / height),
    )
    return Camera(
        camera_to_world=_rigid_inverse(np.array(region_3d.view_matrix, np.float64)),
        width=columns,
        height=rows,
        region=(x0, y0, x1, y1),
        **seen,
    )


def _optics(matrix, width, height, region_3d, space, scene) -> dict:
    """Fields of Camera: kind, window, clipping, panorama, lens."""
    near, far = _clip(matrix)
    seen = {
        "kind": PERSPECTIVE if matrix[3, 3] == 0.0 else ORTHOGRAPHIC,
        "window": _window(matrix),
        "clip_start": near,
        "clip_end": far,
    }
    camera = space.camera
    if region_3d.view_perspective != "CAMERA" or camera is None or camera.type != "CAMERA":
        return seen
    seen["lens"] = camera_lens(camera)
    if camera.data.type == "PANO":
        own = camera_optics(camera, scene.render, [])
        if own["kind"] == PANORAMIC:
            frame = _camera_frame(matrix, width, height, camera, scene)
            seen = own | {"window": _around_frame(own["window"], frame, width, height)}
    return seen


def _around_frame(window, frame, width, height):
    """What of a panorama's square a region shows whose camera frame shows ``window``."""
    left, right, bottom, top = window
    x0, y0, x1, y1 = frame
    across, up = (right - left) / (x1 - x0), (top - bottom) / (y1 - y0)
    x, y = left - x0 * across, bottom - y0 * up
    return x, x + width * across, y, y + height * up


def _window(p) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) on the plane z = -1, or in metres. p: projection (4, 4)"""
    shift = p[:2, 3] if p[3, 3] else -p[:2, 2]
    edges = [((side - shift[a]) / p[a, a]) for a in (0, 1) for side in (-1.0, 1.0)]
    return tuple(float(edge) for edge in edges)


def _clip(p) -> tuple[float, float]:
    """Distances of the near and far plane along -z; the near one of an ortho view is behind."""
    if p[3, 3]:
        return float((p[2, 3] + 1.0) / p[2, 2]), float((p[2, 3] - 1.0) / p[2, 2])
    return float(p[2, 3] / (p[2, 2] - 1.0)), float(p[2, 3] / (p[2, 2] + 1.0))


def _rigid_inverse(view):
    matrix = np.linalg.inv(view)
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
    matrix[3] = 0.0, 0.0, 0.0, 1.0
    return matrix


def _border(matrix, width, height, region_3d, space, scene):
    """(x0, y0, x1, y1) in pixels of the screen: what is to be rendered."""
    whole = 0.0, 0.0, float(width), float(height)
    if region_3d.view_perspective != "CAMERA" or space.camera is None:
        if not space.use_render_border:
            return whole
        return _part(whole, space, "render_border")
    frame = _camera_frame(matrix, width, height, space.camera, scene)
    if scene.render.use_border:
        return _part(frame, scene.render, "border")
    return frame if _hides_surroundings(space) else whole


def _part(rectangle, owner, prefix):
    x0, y0, x1, y1 = rectangle

    def edge(name):
        return getattr(owner, f"{prefix}_{name}")

    return (
        x0 + edge("min_x") * (x1 - x0),
        y0 + edge("min_y") * (y1 - y0),
        x0 + edge("max_x") * (x1 - x0),
        y0 + edge("max_y") * (y1 - y0),
    )


def _hides_surroundings(space) -> bool:
    """Whether an opaque passepartout covers all beside the camera's frame."""
    data = space.camera.data
    if space.camera.type != "CAMERA" or not space.overlay.show_overlays:
        return False
    return data.show_passepartout and data.passepartout_alpha >= 1.0


def _camera_frame(matrix, width, height, camera, scene):
    """The camera's frame in pixels of the screen."""
    if camera.type != "CAMERA":
        return 0.0, 0.0, float(width), float(height)
    corners = np.array(camera.data.view_frame(scene=scene), np.float64)
    points = np.c_[corners, np.ones(len(corners))] @ matrix.T
    screen = (points[:, :2] / points[:, 3:] + 1.0) * 0.5 * (width, height)
    (x0, y0), (x1, y1) = screen.min(axis=0), screen.max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)

"""Where the rays of a pass go: each pixel's next place in the filter, on the lens and in time.

All three are quasi-random points of their own (pixel_filter.unit_points), so the passes of a pixel
cover the filter, the lens and the shutter's time evenly, and neighbours differ.
"""

from __future__ import annotations

import numpy as np

from .camera import CameraRays, rays_through, shutter_times, view_depth
from .lens import blur_widths
from .pixel_filter import LENS, TIME, filter_offsets, unit_points
from .scene import Camera
from .settings import RenderSettings

# What the lens spreads over fewer pixels needs no more rays than a sharp picture.
_SHARP_PX = 1.0


def pass_rays(
    camera: Camera, settings: RenderSettings, columns: np.ndarray, rows: np.ndarray, number: int
) -> CameraRays:
    """Ray ``number`` of pixels of the frame. columns, rows: int64 (n,)"""
    own = 0 if settings.decorrelation == "NONE" else 1
    place = own * columns, own * rows, number, settings.seed
    offsets = filter_offsets(settings.pixel_filter, settings.filter_width, unit_points(*place))
    x, y = columns + 0.5 + offsets[:, 0], rows + 0.5 + offsets[:, 1]
    lens_uv = None if camera.lens is None else unit_points(*place, LENS)
    times = None
    if camera.motion is not None:
        times = shutter_times(camera.motion, unit_points(*place, TIME)[:, 0])
    return rays_through(camera, x, y, lens_uv, times)


def blurred(camera: Camera, positions: np.ndarray) -> np.ndarray:
    """bool (n,): whether lens or motion spread what is at a place, (n, 3), over several pixels."""
    if camera.motion is not None:
        return np.ones(len(positions), np.bool_)
    if camera.lens is None:
        return np.zeros(len(positions), np.bool_)
    return blur_widths(camera, view_depth(camera, positions)) > _SHARP_PX


def world_blurred(camera: Camera) -> bool:
    """The same of the world."""
    if camera.motion is not None:
        return True
    return camera.lens is not None and bool(blur_widths(camera, np.array([np.inf]))[0] > _SHARP_PX)

"""The rays of a pass: each pixel's next place in the filter, on the lens and in time.

All three are quasi-random points of their own (pixel_filter.unit_points), so the passes of a pixel
cover the filter, the lens and the shutter's time evenly, and neighbours differ.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from ..scene import Camera
from ..settings import RenderSettings
from .camera import CameraRays, rays_through, shutter_times, view_depth
from .lens import blur_widths
from .pixel_filter import LAYERS, LENS, TIME, filter_offsets, unit_points

# What the lens spreads over fewer pixels needs no more rays than a sharp picture.
_SHARP_PX = 1.0
# Shadow rays of a point where lens or motion blur: 8 reach the same mean error in a fifth less time
# than 4, but bright spots out of focus want many points (docs/decisions/0020-cameras.md).
_BLURRED_SAMPLES = 4
PILOT = 4  # passes of every pixel, after which its neighbourhood is known


class PassRays(NamedTuple):
    """Rays to look through: rows of pixels, int32 (n,), and the pass of each, int64 (n,)."""

    pixel: np.ndarray
    number: np.ndarray

    def at(self, which: np.ndarray) -> PassRays:
        """Some of them."""
        return PassRays(self.pixel[which], self.number[which])


def rays_by_pass(pixels: np.ndarray, first: np.ndarray, counts: np.ndarray) -> PassRays:
    """Passes first ... first + counts - 1 of each pixel, one pixel after another; int32 (n,)."""
    begin = np.cumsum(counts) - counts
    number = np.arange(counts.sum()) - np.repeat(begin - first, counts)
    return PassRays(np.repeat(pixels, counts), number)


def samples_of_a_pass(settings: RenderSettings, camera: Camera) -> int:
    """Shadow rays of one shading point: n, or less where MAX would leave no PILOT passes.

    Less, too, where lens or motion blur. A budget with a target takes half of it for the pilot at
    the most.
    """
    most = settings.max_samples
    if settings.stop_rule == "BUDGET" and settings.target_samples:
        most = min(most, settings.target_samples // 2)
    sharp = camera.lens is None and camera.motion is None
    n = settings.batch_size if sharp else min(settings.batch_size, _BLURRED_SAMPLES)
    return max(1, min(n, most // PILOT))


def pass_rays(
    camera: Camera,
    settings: RenderSettings,
    columns: np.ndarray,
    rows: np.ndarray,
    number: np.ndarray,
    time: float | None = None,
) -> CameraRays:
    """Rays of pixels of the frame. columns, rows, number: int64 (n,), of each its number ``number``

    time: 0 to 1 of the shutter's time, the same for all; None: each pixel's own
    """
    own = 0 if settings.decorrelation == "NONE" else 1
    place = own * columns, own * rows, number, settings.seed
    offsets = filter_offsets(settings.pixel_filter, settings.filter_width, unit_points(*place))
    x, y = columns + 0.5 + offsets[:, 0], rows + 0.5 + offsets[:, 1]
    lens_uv = None if camera.lens is None else unit_points(*place, LENS)
    times = None
    if camera.motion is not None and time is not None:
        times = np.full(len(columns), time)
    elif camera.motion is not None:
        times = shutter_times(camera.motion, unit_points(*place, TIME)[:, 0])
    return rays_through(camera, x, y, lens_uv, times)


def pass_slices(settings: RenderSettings, columns, rows, number, slices: int) -> np.ndarray:
    """int64 (n,): the slice of the shutter's time that ray ``number``, int64 (n,), of pixels sees.

    slices: a power of two, 8 or more. In four passes a pixel goes through the quarters of the time
    in an order of its own, at one place in all; so in as many passes as there are slices it sees
    each once. Those four passes are taken together, and have points of few slices: half of the
    pixels, so that few passes look less like a row of pictures, are at the mirrored place in each
    quarter. So all together see the middle of the time on average, however few passes they have.
    """
    own = 0 if settings.decorrelation == "NONE" else 1
    place = own * columns, own * rows
    u = unit_points(*place, number, settings.seed, TIME)[:, 0]
    inside = slices // 4
    order = np.array([_spread(k, inside) for k in range(inside)]) ^ (inside // 2 - 1)
    mirrored = unit_points(*place, 0, settings.seed, TIME)[:, 1] < 0.5
    where = order[number // 4 % inside] ^ (mirrored * (inside - 1))
    return np.minimum((u * 4.0).astype(np.int64), 3) * inside + where


@functools.cache
def _spread(k: int, n: int) -> int:
    """Number k of 0 ... n - 1 in an order whose beginnings are spread evenly [Corput35]."""
    order = sorted(range(n), key=lambda i: int(f"{i:016b}"[::-1], 2))
    return order[k]


def pass_numbers(settings: RenderSettings, columns, rows, number) -> np.ndarray:
    """float64 (n,) in [0, 1): what cut-outs draw for the same rays (cutouts.points_through)."""
    own = 0 if settings.decorrelation == "NONE" else 1
    return unit_points(own * columns, own * rows, number, settings.seed, LAYERS)[:, 0]


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

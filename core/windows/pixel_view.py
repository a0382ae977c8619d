"""What the sampler sees at one pixel: light, BSDF, their product, and where its samples went.

The paper's figure 3, for any scene. Maps are equirectangular pictures of the directions around the
shading point, in world space, as Blender's: u = .5 - atan2(y, x) / 2 pi, row 0 looks down.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import eval_at
from ..bsdf.lobes_at import lobes_at
from ..camera.camera import camera_rays
from ..light.environment import eval_environment_many
from ..machine.watch import StopFlag
from ..render import worker_count
from ..render_cache import RenderCache, with_rows
from ..sampling.incremental import new_rays, sample_points
from ..scene import Scene
from ..settings import RenderSettings
from ..surfaces.near_rays import with_near_rays
from ..surfaces.seen_points import with_lobes
from ..tiles.tile_job import Job, Rect, make_sampler, trace_points
from ..unit_square.sequence import common_points, pixel_sequence

_VISIBLE, _OCCLUDED = np.float32([1.0, 0.1, 0.05]), np.float32([0.1, 0.35, 1.0])
_GAP = 8  # pixels between two maps


class PixelView(NamedTuple):
    """light, bsdf, product: float32 (h, 2 h, 3), radiance, BSDF x cosine, and one times the other;
    directions: float32 (n, 3), of the samples that can carry light; occluded: bool (n,)
    count: samples that the pixel took; position: float32 (3,), the point in world space
    """

    light: np.ndarray
    bsdf: np.ndarray
    product: np.ndarray
    directions: np.ndarray
    occluded: np.ndarray
    count: int
    position: np.ndarray


def look_at_pixel(
    scene: Scene,
    settings: RenderSettings,
    x: int,
    y: int,
    height: int = 256,
    cache: RenderCache | None = None,
) -> PixelView:
    """The view of the point at the centre of pixel (x, y) of the frame, y up.

    The pixel is alone: stop rule PERCEPTUAL asks no neighbours here, and nothing is learnt of what
    they see (guide.py). Raises ValueError where the pixel is outside the frame, or shows no object.
    """
    camera = scene.camera
    if not (0 <= x < camera.width and 0 <= y < camera.height):
        raise ValueError(f"pixel ({x}, {y}) is outside the frame, {camera.width}x{camera.height}")
    if settings.stop_rule == "BUDGET":  # of a whole frame
        settings = dataclasses.replace(settings, stop_rule="PERCEPTUAL")
    job = _make_job(scene, settings, cache or RenderCache())
    rect = Rect(x, y, 1, 1)
    points = trace_points(job, camera_rays(camera, *rect))
    if not len(points.pixel):
        raise ValueError(f"pixel ({x}, {y}) shows no object")
    seen = with_lobes(job.scene, points)
    sequence = pixel_sequence(
        job.sequence, points.pixel, rect[:3], settings.seed, settings.point_set
    )
    sampler = make_sampler(job, seen, sequence)
    count, taken, occluded = _samples_of(sampler, job)
    directions = map_directions(height)
    light, bsdf = (np.empty((len(directions), 3), np.float32) for _ in range(2))
    eval_environment_many(job.light.lookup, directions, light)
    _fill_bsdf(seen.lobes, directions, bsdf)
    shape = height, 2 * height, 3
    return PixelView(
        light.reshape(shape),
        bsdf.reshape(shape),
        (light * bsdf).reshape(shape),
        taken,
        occluded,
        count,
        points.position[0],
    )


def _samples_of(sampler, job: Job) -> tuple[int, np.ndarray, np.ndarray]:
    """What its rule has the one point take: count, and PixelView's directions and occluded."""
    sums, _ = sample_points(sampler, 1, job.accel, job.settings)
    count = int(sums.count[0])
    rays = new_rays(max(count, 1))
    n = sampler.sample(np.zeros(1, np.int32), 0, np.array([count], np.int32), rays) if count else 0
    directions = rays.directions[:n].copy()
    return count, directions, job.accel.occluded(rays.origins[:n], directions).copy()


def _make_job(scene, settings, cache) -> Job:
    light, tables = cache.light(scene.environment, settings.cache_dir), None
    if settings.estimator == "PAPER":
        threads = worker_count(settings)
        tables, _, _ = cache.tables(scene, light, settings, threads, lambda *_: None)
    points = common_points(settings.max_samples, settings.point_set)
    accel = cache.rays(scene)
    scene, accel = with_rows(scene, accel, settings, worker_count(settings))
    scene = with_near_rays(scene, settings, accel)
    return Job(scene, settings, accel, light, tables, points, StopFlag())


@kernel
def _fill_bsdf(lobes, directions, out):
    """Write BSDF x cosine of row 0 for each direction, float32 (n, 3); 0 below the surface."""
    at = lobes_at(lobes, 0)
    for k in range(len(directions)):
        wx, wy, wz = directions[k, 0], directions[k, 1], directions[k, 2]
        dr, dg, db, gr, gg, gb = eval_at(at, wx, wy, wz)
        out[k, 0], out[k, 1], out[k, 2] = dr + gr, dg + gg, db + gb


def map_directions(height: int) -> np.ndarray:
    """float32 (2 height^2, 3): the direction of each texel of a map, row by row from below."""
    azimuth = np.pi * (1.0 - (np.arange(2 * height) + 0.5) / height)
    altitude = np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    azimuth, altitude = np.meshgrid(azimuth, altitude)
    flat = np.cos(altitude)
    parts = flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(altitude)
    return np.stack(parts, -1).reshape(-1, 3).astype(np.float32)


def map_texels(directions: np.ndarray, height: int) -> tuple[np.ndarray, np.ndarray]:
    """(row, column) of the texel that each direction, float32 (n, 3), falls into."""
    x, y, z = directions.astype(np.float64).T
    u, v = 0.5 - np.arctan2(y, x) / (2.0 * np.pi), 0.5 + np.arcsin(np.clip(z, -1.0, 1.0)) / np.pi
    columns = np.minimum((u * 2 * height).astype(int), 2 * height - 1)
    return np.minimum((v * height).astype(int), height - 1), columns


def draw_pixel_view(view: PixelView) -> np.ndarray:
    """A picture to look at, float32 (h, w, 4), display values 0 ... 1, row 0 at the bottom.

    Above: light, BSDF x cosine; below: their product, and the samples on it, red those that saw the
    light, blue those that are occluded.
    """
    light, bsdf, product = (_displayed(layer) for layer in (view.light, view.bsdf, view.product))
    dots = _with_dots(0.5 * product, view)
    height, width = light.shape[:2]
    picture = np.full((2 * height + _GAP, 2 * width + _GAP, 4), 0.15, np.float32)
    picture[..., 3] = 1.0
    places = ((1, 0, light), (1, 1, bsdf), (0, 0, product), (0, 1, dots))
    for row, column, layer in places:
        y, x = row * (height + _GAP), column * (width + _GAP)
        picture[y : y + height, x : x + width, :3] = layer
    return picture


def _displayed(layer: np.ndarray) -> np.ndarray:
    """Scaled so that 99.5 % of the texels that are not black are in range, with a gamma of 2.2."""
    bright = layer.max(axis=2)
    top = np.quantile(bright[bright > 0.0], 0.995) if (bright > 0.0).any() else 1.0
    return np.clip(layer / np.float32(top), 0.0, 1.0) ** np.float32(1.0 / 2.2)


def _with_dots(layer: np.ndarray, view: PixelView) -> np.ndarray:
    height, width = layer.shape[:2]
    rows, columns = map_texels(view.directions, height)
    reach = max(height // 128, 1)
    steps = range(-reach, reach + 1)
    for dy, dx in ((dy, dx) for dy in steps for dx in steps):
        at = np.clip(rows + dy, 0, height - 1), (columns + dx) % width
        layer[at] = np.where(view.occluded[:, None], _OCCLUDED, _VISIBLE)
    return layer

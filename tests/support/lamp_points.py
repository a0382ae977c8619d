"""Points on a floor that lamps light, sampled pixel by pixel."""

import numpy as np

from iwis.core.camera.camera import CameraRays
from iwis.core.data.lamps import make_lamps
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.lamplight.lamp_light import COLUMNS, LampSamples, add_lamp_light
from iwis.core.surfaces.seen_points import with_lobes
from iwis.core.tiles.tile_job import trace_points

from .scenes import camera_above, constant_world, floor, make_job, make_scene

DARK = constant_world((0.0, 0.0, 0.0))
WO = np.array([-0.6, 0.0, 0.8])  # its mirrored direction meets the middle of most lamps


def seen_point(material, copies=1, blocker=None):
    """(points, lobes, accel): copies of the origin, on a floor seen along -WO."""
    parts, materials = [floor(1.0)], [material]
    if blocker is not None:
        parts, materials = [*parts, blocker], [*materials, material]
    job = make_job(make_scene(parts, materials, DARK, camera_above()))
    start, along = (10.0 * WO).astype(np.float32)[None], (-WO).astype(np.float32)[None]
    points = trace_points(job, CameraRays(start, along, np.full(1, 1e3, np.float32)))
    points = ShadingPoints(*(np.repeat(column, copies, axis=0) for column in points))
    return points, with_lobes(job.scene, points).lobes, job.accel


def sampled(rows, material, pixels=4000, numbers=4, blocker=None, lamps=None):
    """float64 (pixels, 6): means over a few numbers, by lobe; pixels are independent.

    rows: of make_lamps; lamps: in their place
    """
    points, lobes, accel = seen_point(material, pixels, blocker)
    lamps, sums = make_lamps(rows) if lamps is None else lamps, np.zeros((pixels, COLUMNS))
    columns, row = np.arange(pixels), np.zeros(pixels, np.int64)
    for number in range(numbers):
        samples = LampSamples(columns, row, np.full(pixels, number), 7)
        add_lamp_light(points, lobes, lamps, accel, samples, sums)
    return sums[:, :6] / numbers

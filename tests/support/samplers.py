"""Samplers of a scene's pixels outside of render(): for tests of estimators and densities."""

from typing import NamedTuple

import numpy as np

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.bsdf.lobes import Lobes
from iwis.core.camera.camera import camera_rays
from iwis.core.embree.accel import Accel
from iwis.core.geometry.shading import ShadingPoints, params_at, shading_points
from iwis.core.sampling.incremental import RayBatch, new_rays
from iwis.core.unit_square.sequence import PixelSequence, common_points


class PixelPoints(NamedTuple):
    """The shading points of a scene's region, as render() would make them for one tile."""

    points: ShadingPoints
    lobes: Lobes
    rows: np.ndarray
    accel: Accel


def pixel_points(scene) -> PixelPoints:
    """Camera rays, first hits, lobes."""
    x0, y0, x1, y1 = scene.camera.region
    origins, directions, _ = camera_rays(scene.camera, x0, y0, x1 - x0, y1 - y0)
    accel = Accel(scene.mesh)
    hit, u, v = accel.intersect(origins, directions)
    points = shading_points(scene.mesh, hit, u, v, directions)
    rows = scene.mesh.material_index[points.triangle]
    params = params_at(scene.materials, rows)
    vectors = points.normal, points.geometric_normal, points.wo
    lobes = setup_lobes(params, *vectors, scene.measured)
    return PixelPoints(points, lobes, rows, accel)


def random_sequence(rng, n, count, decorrelation="PIXEL") -> PixelSequence:
    """Independent shifts or scrambles of ``count`` points: one replicate a shading point."""
    x, y = (rng.integers(0, 1 << 32, n, dtype=np.uint32) for _ in range(2))
    return PixelSequence(common_points(count, decorrelation), x, y, decorrelation == "OWEN")


def plain_sequence(n, count) -> PixelSequence:
    """Halton's points as they are."""
    zeros = np.zeros(n, np.uint32)
    return PixelSequence(common_points(count, "NONE"), zeros, zeros, False)


def all_rays(sampler, active: np.ndarray, count: int) -> RayBatch:
    """The rays of the first ``count`` samples of the points ``active``, those that carry light."""
    rays = new_rays(len(active) * count)
    counts = np.full(len(active), count, np.int32)
    n = sampler.sample(active.astype(np.int32), 0, counts, rays)
    return RayBatch(*(array[:n] for array in rays))

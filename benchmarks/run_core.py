"""The estimators of reference.py on an exported scene: WIS, light sampling, BSDF, MIS.

The picture is made as render.py makes it, with core.incremental's loop at a fixed count: tiles,
threads, camera rays, shading. Only where the samples go is another.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.camera.camera import camera_rays
from iwis.core.comparisons import reference
from iwis.core.geometry.shading import ShadingPoints, params_at, shading_points
from iwis.core.render_cache import RenderCache
from iwis.core.sampling.incremental import sample_points
from iwis.core.scene import Scene
from iwis.core.settings import RenderSettings
from iwis.core.tiles.tiles import tile_rects
from iwis.core.unit_square.sequence import common_points, pixel_sequence

SHARES = {
    "light": reference.LIGHT_SAMPLING,
    "bsdf": reference.BSDF_SAMPLING,
    "mis": reference.MIS_SAMPLING,
}
METHODS = ("wis", *SHARES)
_TILE_PX, _BLOCK_POINTS = 32, 256


class CorePicture(NamedTuple):
    """rgb: float64 (h, w, 3), 0 where nothing is hit; cpu, wall: seconds."""

    rgb: np.ndarray
    cpu: float
    wall: float


class CoreRun:
    """Renders of one scene that share the BVH, the light and the paper's tables of a cache."""

    def __init__(self, scene: Scene, cache: RenderCache, threads: int):
        self._scene, self._threads, self._cache = scene, threads, cache
        self._accel = cache.accel(scene.mesh)
        self._light = cache.light(scene.environment)
        self._tables = None

    def render(self, method: str, count: int, seed: int = 0) -> CorePicture:
        """The picture with ``count`` samples a pixel by one of METHODS, and what it cost."""
        if method == "wis" and self._tables is None:
            settings = RenderSettings(estimator="PAPER", threads=self._threads)
            self._tables, _, _ = self._cache.tables(
                self._scene, self._light, settings, self._threads, lambda *_: None
            )
        camera = self._scene.camera
        rgb = np.zeros((camera.height, camera.width, 3))
        points = common_points(count, "PIXEL")

        def work(rect):
            x, y, width, height = rect
            rgb[y : y + height, x : x + width] = self._tile(rect, method, points, seed)

        wall, cpu = time.perf_counter(), time.process_time()
        with ThreadPoolExecutor(self._threads) as pool:
            list(pool.map(work, tile_rects(camera.region, _TILE_PX)))
        return CorePicture(rgb, time.process_time() - cpu, time.perf_counter() - wall)

    def _tile(self, rect, method, sequence, seed):
        scene, (x, y, width, height) = self._scene, rect
        origins, directions, _ = camera_rays(scene.camera, x, y, width, height)
        hit, u, v = self._accel.intersect(origins, directions)
        points = shading_points(scene.mesh, hit, u, v, directions, scene.terminator_offset)
        rgb = np.zeros((width * height, 3))
        if len(points.pixel):
            rows = scene.mesh.material_index[points.triangle]
            params = params_at(scene.materials, rows)
            lobes = setup_lobes(params, points.normal, points.geometric_normal, points.wo)
            for first in range(0, len(rows), _BLOCK_POINTS):
                block = slice(first, first + _BLOCK_POINTS)
                some = ShadingPoints(*(column[block] for column in points))
                rgb[some.pixel] = self._block(
                    some,
                    lobes.at(block),
                    rows[block],
                    rect,
                    method,
                    sequence,
                    seed,
                )
        return rgb.reshape(height, width, 3)

    def _block(self, points, lobes, rows, rect, method, sequence, seed):
        count, offset = len(sequence), self._accel.offset
        own = pixel_sequence(sequence, points.pixel, rect[:3], seed, "PIXEL")
        if method == "wis":
            sampler = reference.make_wis(points, lobes, rows, self._tables, own, count, offset)
        else:
            share = SHARES[method]
            sampler = reference.MixtureSampler(points, lobes, self._light, share, own, offset)
        settings = RenderSettings(stop_rule="FIXED", max_samples=count, threads=1)
        sums, _ = sample_points(sampler, len(points.pixel), self._accel, settings)
        return (sums.diffuse + sums.glossy) / count

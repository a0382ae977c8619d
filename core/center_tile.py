"""The work at a tile whose pixels have one shading point each, at their centre."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from .camera import pixel_grid, rays_through
from .develop import MissedRays, PlacedPoints, develop_points
from .film import Tile
from .guide import Guides, new_guides
from .incremental import PixelSums, new_sums
from .neighbours import CELL_PX, cell_order
from .sample_plan import WHOLE_SHARE, Demand, dither_of, powers
from .stop_rule import Rule, perceptual_rule, spread_of, stop_rule
from .tile_job import (
    Job,
    Rect,
    SeenPoints,
    TileCounts,
    add_samples,
    cell_bounds,
    frame_places,
    trace_points,
    whole_cells,
    with_lobes,
)


class CenterTile:
    """One shading point a pixel (tile_job.TileWork); 236 bytes a pixel between calls.

    Where pixels tell of each other (PERCEPTUAL, guides), the work is at whole cells, of which
    ``develop`` cuts the tile: a picture does not depend on its border.
    """

    def __init__(self, job: Job, rect: Rect):
        self._job, self.rect = job, rect
        settings = job.settings
        self._learns = settings.estimator == "UNBIASED"
        alone = settings.stop_rule not in ("PERCEPTUAL", "BUDGET") and not self._learns
        self._whole = rect if alone else whole_cells(rect, job.scene.camera)
        self._sums: PixelSums | None = None
        self._seen: SeenPoints | None = None
        self._missed: MissedRays | None = None
        self._places = np.zeros(0, np.int32)
        self._bounds = np.zeros(1, np.int32)
        self._guides: Guides | None = None
        self._traced = self._primary = 0

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        settings = self._job.settings
        most = min(samples, settings.max_samples)
        self._add(stop_rule(dataclasses.replace(settings, max_samples=most)))
        return samples >= settings.max_samples or self._sums.count.max(initial=0) < samples

    def look(self, typical: float, most: int) -> None:
        """See TileWork."""
        self._add(perceptual_rule(typical, most))

    def demand(self, typical: float) -> Demand:
        """See TileWork: of the points, in the order of their cells."""
        self._look()
        counted = (self._places >= 0) & (self._sums.count > 0)
        columns, rows = frame_places(self._whole, self._seen.points.pixel)
        return Demand(
            power=powers(spread_of(self._sums)),
            least=np.zeros(len(counted), np.float32),
            taken=self._sums.count.copy(),
            share=np.where(counted, WHOLE_SHARE, 0).astype(np.int32),
            dither=dither_of(columns, rows),
            grain=0,
            shaded=int((self._places >= 0).sum()),
        )

    def go_to(self, counts: np.ndarray, typical: float) -> None:
        """See TileWork."""
        self._add(perceptual_rule(typical, self._job.settings.max_samples, counts))

    def develop(self) -> Tile:
        """See TileWork."""
        self._look()
        points, lobes, _ = self._seen
        layers = develop_points(
            self._job.scene,
            self._job.seen_world,
            PlacedPoints(points, lobes, self._places),
            self._missed,
            self._sums,
            self.rect[2:],
            self._job.settings.max_samples,
        )
        return Tile(*self.rect, layers)

    def rest(self) -> None:
        """See TileWork."""
        self._seen = self._missed = None

    def counts(self) -> TileCounts:
        """See TileWork."""
        self._look()
        count = self._sums.count[self._places >= 0]
        return TileCounts(
            len(count), int(count.sum()), int(count.max(initial=0)), self._traced, self._primary
        )

    def _add(self, rule: Rule) -> None:
        self._look()
        own = self._seen, self._whole, self._sums, self._bounds
        self._traced += add_samples(self._job, *own, rule, self._guides)

    def _look(self) -> None:
        """Have the points that the pixels' centres see, in the order of their cells."""
        if self._seen is not None:
            return
        scene, whole = self._job.scene, self._whole
        pixel, ends = _cell_pixels(whole.x % CELL_PX, whole.y % CELL_PX, *whole[2:])
        columns, rows = frame_places(whole, pixel)
        origins, directions = rays_through(scene.camera, columns + 0.5, rows + 0.5)
        self._primary += len(origins)
        points = trace_points(self._job, origins, directions)
        self._bounds = cell_bounds(points, ends)
        missed = np.ones(len(pixel), np.bool_)
        missed[points.pixel] = False
        places = places_in(self.rect, columns, rows)
        self._places = places[points.pixel]
        self._missed = MissedRays(places[missed], directions[missed])
        self._seen = with_lobes(scene, points._replace(pixel=pixel[points.pixel]))
        if self._sums is None:
            self._sums = new_sums(len(points.pixel))
            self._guides = new_guides(len(self._bounds) - 1 if self._learns else 0)


def places_in(rect: Rect, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """int32: rows of a tile's pixels, of columns and rows in the frame; -1 = outside."""
    x, y = columns - np.int32(rect.x), rows - np.int32(rect.y)
    inside = (x >= 0) & (x < rect.width) & (y >= 0) & (y < rect.height)
    return np.where(inside, y * np.int32(rect.width) + x, np.int32(-1))


@functools.lru_cache(maxsize=64)
def _cell_pixels(x: int, y: int, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of a tile in the order of their cells, int32, and where each cell begins.

    x, y: of the tile's corner in its cell
    """
    columns, rows = pixel_grid(x, y, width, height)
    order, ends = cell_order(columns, rows)
    return order.astype(np.int32), ends

"""The work at a tile whose pixels have one shading point each, at their centre."""

from __future__ import annotations

import dataclasses

import numpy as np

from .camera import camera_rays, pixel_grid
from .develop import add_points, background_layers
from .film import Tile
from .incremental import PixelSums, new_sums
from .neighbours import CELL_PX, Neighbours, cell_order, find_neighbours
from .scene import Camera
from .stop_rule import StopRule, stop_rule
from .tile_job import (
    BLOCK_POINTS,
    Job,
    Rect,
    SeenPoints,
    TileCounts,
    add_samples,
    trace_points,
    with_lobes,
)


def whole_cells(rect: Rect, camera: Camera) -> Rect:
    """The cells of neighbours.py that a tile has a part in, as far as they are in the frame."""
    x0, y0 = rect.x // CELL_PX * CELL_PX, rect.y // CELL_PX * CELL_PX
    x1, y1 = (-(-end // CELL_PX) * CELL_PX for end in (rect.x + rect.width, rect.y + rect.height))
    return Rect(x0, y0, min(x1, camera.width) - x0, min(y1, camera.height) - y0)


class CenterTile:
    """One shading point a pixel (tile_job.TileWork); 108 bytes a pixel between calls.

    Where the stop rule asks for neighbours, the work is at whole cells, of which ``develop`` cuts
    the tile: a picture does not depend on its border.
    """

    def __init__(self, job: Job, rect: Rect):
        self._job, self.rect = job, rect
        alone = job.settings.stop_rule != "PERCEPTUAL"
        self._whole = rect if alone else whole_cells(rect, job.scene.camera)
        self._sums: PixelSums | None = None
        self._seen: SeenPoints | None = None
        self._directions: np.ndarray | None = None
        self._blocks: list[slice] = []
        self._traced = self._primary = 0

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        self._look()
        settings = self._job.settings
        upto = dataclasses.replace(settings, max_samples=min(samples, settings.max_samples))

        def rule_of(block) -> StopRule:
            return stop_rule(upto, self._neighbours(block))

        self._traced += add_samples(
            self._job, self._seen, self._whole, self._sums, self._blocks, rule_of
        )
        return samples >= settings.max_samples or self._sums.count.max(initial=0) < samples

    def develop(self) -> Tile:
        """See TileWork."""
        self._look()
        scene, points = self._job.scene, self._seen.points
        width, height = self._whole.width, self._whole.height
        missed = np.ones(width * height, np.bool_)
        missed[points.pixel] = False
        layers = background_layers(
            scene, self._job.light.lookup, self._directions, missed, (width, height)
        )
        if len(points.pixel):
            lobes, settings = self._seen.lobes, self._job.settings
            add_points(layers, scene, points, lobes, self._sums, settings.max_samples)
        x, y, width, height = self.rect
        rows = slice(y - self._whole.y, y - self._whole.y + height)
        columns = slice(x - self._whole.x, x - self._whole.x + width)
        layers = {name: np.ascontiguousarray(a[rows, columns]) for name, a in layers.items()}
        return Tile(x, y, width, height, layers)

    def rest(self) -> None:
        """See TileWork."""
        self._seen = self._directions = None

    def counts(self) -> TileCounts:
        """See TileWork."""
        self._look()
        columns, rows = self._places()
        x, y, width, height = self.rect
        inside = (columns >= x) & (columns < x + width) & (rows >= y) & (rows < y + height)
        count = self._sums.count[inside]
        return TileCounts(
            len(count), int(count.sum()), int(count.max(initial=0)), self._traced, self._primary
        )

    def _look(self) -> None:
        """Have the points that the pixels' centres see, in the order of their cells."""
        if self._seen is not None:
            return
        scene = self._job.scene
        origins, self._directions = camera_rays(scene.camera, *self._whole)
        self._primary += len(origins)
        points = trace_points(self._job, origins, self._directions)
        columns, rows = (places[points.pixel] for places in pixel_grid(*self._whole))
        order, ends = cell_order(columns, rows)
        self._blocks = _runs_of_cells(ends)
        self._seen = with_lobes(scene, points).at(order)
        if self._sums is None:
            self._sums = new_sums(len(order))

    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """Column and row in the frame of every point."""
        columns, rows = pixel_grid(*self._whole)
        return columns[self._seen.points.pixel], rows[self._seen.points.pixel]

    def _neighbours(self, block: slice) -> Neighbours:
        columns, rows = self._places()
        materials, normal = self._seen.rows[block], self._seen.points.normal[block]
        return find_neighbours(columns[block], rows[block], materials, normal)


def _runs_of_cells(ends: np.ndarray) -> list[slice]:
    """Slices of whole cells with about BLOCK_POINTS points. ends: of neighbours.cell_order"""
    runs, first = [], 0
    for k in range(1, len(ends)):
        if k + 1 == len(ends) or ends[k + 1] - first > BLOCK_POINTS:
            runs.append(slice(first, int(ends[k])))
            first = int(ends[k])
    return runs

"""The work at a tile whose pixels average several shading points, a pass after another.

A pass gives each pixel one point (pixel_filter.py) with a few samples. A pixel whose neighbourhood
shows one object, or nothing but the world, may end after _PILOT passes; one near a silhouette takes
at least _SILHOUETTE / E. Else a leaf that the pilot missed would be lost, and one that it hit would
not be: thin leaves before the sky came out half as dark. Whether it is near is asked of the rays of
the first passes, of the pixel and its eight neighbours; so those around the tile are looked through
too, and no picture depends on its tiles.
"""

from __future__ import annotations

import numpy as np

from .camera import camera_rays, pixel_grid, rays_through
from .develop import filtered_layers
from .film import Tile
from .guide import new_guides
from .incremental import PixelSums, new_sums
from .neighbours import cell_order
from .pass_sums import PassSums, add_background, add_seen, close_pass, fill_spreads, new_pass_sums
from .pixel_filter import filter_offsets, unit_points
from .sample_plan import WHOLE_SHARE, Demand, dither_of, powers
from .shading import ShadingPoints
from .stop_rule import FLOOR, paper_rule, plan_counts, threshold_of, typical_count
from .tile_job import (
    Job,
    Rect,
    SeenPoints,
    TileCounts,
    add_samples,
    trace_points,
    whole_cells,
    with_lobes,
)

_PILOT, _SILHOUETTE = 4, 1.2
_WORLD, _NO_OBJECT = np.int32(-1), np.int32(0x7FFFFFFF)


def samples_of_a_pass(settings) -> int:
    """Shadow rays of one shading point: n, or less where MAX would leave no _PILOT passes.

    A budget with a target takes half of it for the pilot at the most.
    """
    most = settings.max_samples
    if settings.stop_rule == "BUDGET" and settings.target_samples:
        most = min(most, settings.target_samples // 2)
    return max(1, min(settings.batch_size, most // _PILOT))


class FilteredTile:
    """Several shading points a pixel (tile_job.TileWork); 280 bytes a pixel between calls.

    The work is at whole cells of the frame (neighbours.py), of which ``develop`` cuts the tile:
    their guides learn from all passes. Arrays are over these cells and one pixel around them, row
    by row.
    """

    def __init__(self, job: Job, rect: Rect):
        self._job, self.rect = job, rect
        whole = whole_cells(rect, job.scene.camera)
        self._around = Rect(whole.x - 1, whole.y - 1, whole.width + 2, whole.height + 2)
        self._n = n = self._around.width * self._around.height
        self._sums = new_pass_sums(n)
        self._pixels, self._cell = self._cells(whole)
        self._active = self._pixels
        learns = job.settings.estimator == "UNBIASED"
        self._n_cells = int(self._cell.max()) + 1
        self._guides = new_guides(self._n_cells if learns else 0)
        # The least and the greatest object that a pixel's first passes saw.
        self._least, self._greatest = np.full(n, _NO_OBJECT), np.full(n, _WORLD)
        self._passes = self._traced = self._primary = 0

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        settings = self._job.settings
        n = samples_of_a_pass(settings)
        last = -(-min(samples, settings.max_samples) // n)
        while len(self._active) and self._passes < last and not self._job.stop.is_set():
            self._take_pass(min(n, settings.max_samples - self._passes * n))
            self._active = self._active[self._goes_on()]
        return not len(self._active) or self._passes * n >= settings.max_samples

    def look(self, typical: float, most: int) -> None:
        """See TileWork: _PILOT passes at the most, the same for all; ``typical`` is not asked."""
        passes = max(1, min(_PILOT, most // samples_of_a_pass(self._job.settings)))
        self._take_passes(np.full(self._n, passes, np.int32))

    def demand(self, typical: float) -> Demand:
        """See TileWork: of all pixels of the tile's cells, cell by cell."""
        n, pixels, sums = samples_of_a_pass(self._job.settings), self._pixels, self._sums
        spread, passes = np.empty(len(pixels), np.float32), np.maximum(sums.passes[pixels], 1)
        transparent = self._job.scene.transparent_film
        fill_spreads(pixels, n, FLOOR / typical, transparent, sums, spread)
        near = self._near_silhouette()[pixels]
        edge = np.float32(n * _SILHOUETTE / threshold_of(1.0))
        rows, columns = np.divmod(pixels, self._around.width)
        counted = np.zeros(self._n, np.bool_)
        counted[self._inside(self.rect)] = True
        counted = counted[pixels]
        share = sums.count[pixels].astype(np.int64) * WHOLE_SHARE // (passes * n)
        return Demand(
            power=powers(spread),
            least=np.where(near, edge, np.float32(0.0)),
            taken=sums.passes[pixels] * np.int32(n),
            share=np.where(counted, share, 0).astype(np.int32),
            dither=dither_of(columns + self._around.x, rows + self._around.y),
            grain=n,
            shaded=int((counted & (sums.hits[pixels] > 0)).sum()),
        )

    def go_to(self, counts: np.ndarray, typical: float) -> None:
        """See TileWork."""
        passes = np.zeros(self._n, np.int32)
        passes[self._pixels] = -(-counts // samples_of_a_pass(self._job.settings))
        self._take_passes(passes)

    def develop(self) -> Tile:
        """See TileWork."""
        x, y, width, height = self.rect
        scene = self._job.scene
        points = trace_points(self._job, *camera_rays(scene.camera, *self.rect))
        self._primary += width * height
        inside = self._inside(self.rect)
        sums = PassSums(*(column[inside] for column in self._sums))
        layers = filtered_layers(
            scene, points, sums, (width, height), self._job.settings.max_samples
        )
        return Tile(x, y, width, height, layers)

    def rest(self) -> None:
        """See TileWork: nothing else is kept."""

    def counts(self) -> TileCounts:
        """See TileWork."""
        inside = self._inside(self.rect)
        count, hits = self._sums.count[inside], self._sums.hits[inside]
        return TileCounts(
            int((hits > 0).sum()), int(count.sum()), int(count.max()), self._traced, self._primary
        )

    def _take_passes(self, wanted: np.ndarray) -> None:
        """Take the pixels on to as many passes as ``wanted``, int32 (n,), says of each."""
        settings, pixels = self._job.settings, self._pixels
        n = samples_of_a_pass(settings)
        while not self._job.stop.is_set():
            behind = pixels[self._sums.passes[pixels] < wanted[pixels]]
            if not len(behind):
                break
            passes = self._sums.passes[behind]
            self._passes = int(passes.min())
            self._active = behind[passes == self._passes]
            self._take_pass(min(n, settings.max_samples - self._passes * n))

    def _take_pass(self, count: int) -> None:
        """One more shading point with ``count`` samples for each active pixel."""
        points, missed, directions = self._look()
        seen = with_lobes(self._job.scene, points)
        sums = self._sample(seen, count) if len(points.pixel) else None
        if self._passes and self._job.stop.is_set():
            return  # a pass that was cut short would darken those before it
        self._add_world(missed, directions)
        if sums is not None:
            add_seen(points.pixel, points.normal, seen.lobes, sums, self._sums)
        close_pass(self._active, self._job.scene.transparent_film, self._sums)
        self._passes += 1

    def _look(self):
        """The active pixels' next points: (points, pixels that see the world, their directions).

        The first passes look through the pixels around the tile as well.
        """
        pilot, looked = self._passes < _PILOT, self._active
        if pilot:
            looked = np.append(looked, np.flatnonzero(self._cell < 0).astype(np.int32))
        origins, directions = self._rays(looked)
        points = trace_points(self._job, origins, directions)
        self._primary += len(looked)
        missed = np.ones(len(looked), np.bool_)
        missed[points.pixel] = False
        points = points._replace(pixel=looked[points.pixel])
        if pilot:
            self._note_objects(looked[missed], points)
            inside = self._cell >= 0
            missed &= inside[looked]
            points = ShadingPoints(*(column[inside[points.pixel]] for column in points))
        return points, looked[missed], directions[missed]

    def _rays(self, pixels):
        settings = self._job.settings
        rows, columns = np.divmod(pixels.astype(np.int64), self._around.width)
        columns, rows = columns + self._around.x, rows + self._around.y
        own = 0 if settings.decorrelation == "NONE" else 1
        points = unit_points(own * columns, own * rows, self._passes, settings.seed)
        offsets = filter_offsets(settings.pixel_filter, settings.filter_width, points)
        return rays_through(
            self._job.scene.camera, columns + 0.5 + offsets[:, 0], rows + 0.5 + offsets[:, 1]
        )

    def _add_world(self, pixels, directions) -> None:
        scene = self._job.scene
        if not len(pixels) or not scene.environment.visible_to_camera:
            return
        radiance = self._job.seen_world.radiance(directions)
        add_background(pixels, radiance, not scene.transparent_film, self._sums)

    def _sample(self, seen: SeenPoints, count: int) -> PixelSums:
        first = self._passes * samples_of_a_pass(self._job.settings)
        sums, rule = new_sums(len(seen.rows)), paper_rule(-1.0, count, first + count)
        cells = np.arange(self._n_cells + 1)
        bounds = np.searchsorted(self._cell[seen.points.pixel], cells).astype(np.int32)
        self._traced += add_samples(
            self._job, seen, self._around, sums, bounds, rule, self._guides, first
        )
        return sums

    def _note_objects(self, missed, points: ShadingPoints) -> None:
        objects = self._job.scene.mesh.object_index[points.triangle]
        for pixels, seen in ((missed, _WORLD), (points.pixel, objects)):
            self._least[pixels] = np.minimum(self._least[pixels], seen)
            self._greatest[pixels] = np.maximum(self._greatest[pixels], seen)

    def _goes_on(self) -> np.ndarray:
        """bool, one for each active pixel: whether it takes another pass."""
        settings, active = self._job.settings, self._active
        endless = settings.stop_rule == "FIXED" or settings.error_threshold == 0.0
        if endless or self._passes < _PILOT:
            return np.ones(len(active), np.bool_)
        if settings.stop_rule == "PAPER":
            going = self._sums.error[active] > settings.error_threshold
        else:
            going = self._wants_more(typical_count(settings.error_threshold))
        if self._passes < _SILHOUETTE / settings.error_threshold:
            going |= self._near_silhouette()[active]
        return going

    def _wants_more(self, typical: float) -> np.ndarray:
        """PERCEPTUAL: whether N = T r^.75 is more than there are. typical: T"""
        n = samples_of_a_pass(self._job.settings)
        spread = np.empty(len(self._active), np.float32)
        transparent = self._job.scene.transparent_film
        fill_spreads(self._active, n, FLOOR / typical, transparent, self._sums, spread)
        taken = np.full(len(spread), self._passes * n, np.int32)
        return plan_counts(spread, taken, typical, self._job.settings.max_samples) > taken

    def _near_silhouette(self) -> np.ndarray:
        """bool: pixels that see, themselves or by a neighbour, more than one object."""
        least, greatest = self._shaped(self._least), self._shaped(self._greatest)
        near = np.zeros(least.shape, np.bool_)
        near[1:-1, 1:-1] = _of_nine(least, np.minimum) != _of_nine(greatest, np.maximum)
        return near.ravel()

    def _cells(self, whole: Rect) -> tuple[np.ndarray, np.ndarray]:
        """Pixels to sample, int32, by cells; the cell of each looked through, -1 around them."""
        columns, rows = pixel_grid(*whole)
        order, ends = cell_order(columns, rows)
        inside = self._inside(whole)[order]
        cell = np.full(self._n, -1, np.int32)
        cell[inside] = np.repeat(np.arange(len(ends) - 1, dtype=np.int32), np.diff(ends))
        return inside, cell

    def _inside(self, rect: Rect) -> np.ndarray:
        """int32: the pixels of a rectangle, row by row, of those looked through."""
        x, y = rect.x - self._around.x, rect.y - self._around.y
        pixels = self._shaped(np.arange(self._n, dtype=np.int32))
        return pixels[y : y + rect.height, x : x + rect.width].ravel()

    def _shaped(self, values) -> np.ndarray:
        return values.reshape(self._around.height, self._around.width)


def _of_nine(values, reduce) -> np.ndarray:
    """``reduce`` over the 3 x 3 values about each but those at the border."""
    rows = reduce(reduce(values[:-2], values[1:-1]), values[2:])
    return reduce(reduce(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])

"""The work at a tile whose pixels average several shading points, a pass after another.

A pass gives each pixel one point (pixel_filter.py) with a few samples. A pixel whose neighbourhood
shows one object, or nothing but the world, may end after PILOT passes; one near a silhouette takes
at least _SILHOUETTE / E. Else a leaf that the pilot missed would be lost, and one that it hit would
not be: thin leaves before the sky came out half as dark. Whether it is near is asked of the rays of
the first passes, of the pixel and its eight neighbours; so those around the tile are looked through
too, and no picture depends on its tiles.
"""

from __future__ import annotations

import numpy as np

from .camera import camera_rays, pixel_grid
from .cutouts import opacity_of
from .develop import filtered_layers
from .film import Tile
from .neighbours import cell_order
from .pass_rays import (
    PILOT,
    pass_numbers,
    pass_rays,
    pass_slices,
    samples_of_a_pass,
)
from .pass_samples import PassSampler
from .pass_sums import (
    PassSums,
    add_background,
    cell_spreads,
    close_pass,
    fill_spreads,
    new_pass_sums,
)
from .sample_plan import WHOLE_SHARE, Demand, dither_of, powers
from .silhouettes import Silhouettes
from .stop_rule import FLOOR, plan_counts, threshold_of, typical_count
from .tile_job import (
    Job,
    Rect,
    TileCounts,
    trace_points,
    whole_cells,
)

_SILHOUETTE = 1.2


class FilteredTile:
    """Several shading points a pixel (tile_job.TileWork); 284 bytes a pixel between calls.

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
        self._batch = samples_of_a_pass(job.settings, job.scene.camera)
        self._n_cells = int(self._cell.max()) + 1
        self._sampler = PassSampler(job, self._around, self._cell, self._sums)
        self._silhouettes = Silhouettes(job.scene, self._around.width, self._around.height)
        self._passes = self._primary = 0

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        settings = self._job.settings
        n = self._batch
        last = -(-min(samples, settings.max_samples) // n)
        while len(self._active) and self._passes < last and not self._job.stop.is_set():
            self._take_pass(min(n, settings.max_samples - self._passes * n))
            self._active = self._active[self._goes_on()]
        return not len(self._active) or self._passes * n >= settings.max_samples

    def look(self, typical: float, most: int) -> None:
        """See TileWork: PILOT passes at the most, the same for all; ``typical`` is not asked."""
        passes = max(1, min(PILOT, most // self._batch))
        self._take_passes(np.full(self._n, passes, np.int32))

    def demand(self, typical: float) -> Demand:
        """See TileWork: of all pixels of the tile's cells, cell by cell."""
        n, pixels, sums = self._batch, self._pixels, self._sums
        passes = np.maximum(sums.passes[pixels], 1)
        near = self._silhouettes.near()[pixels]
        edge = np.float32(n * _SILHOUETTE / threshold_of(1.0))
        rows, columns = np.divmod(pixels, self._around.width)
        counted = np.zeros(self._n, np.bool_)
        counted[self._inside(self.rect)] = True
        counted = counted[pixels]
        share = sums.count[pixels].astype(np.int64) * WHOLE_SHARE // (passes * n)
        return Demand(
            power=powers(self._spreads(pixels, typical)),
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
        passes[self._pixels] = -(-counts // self._batch)
        self._take_passes(passes)

    def develop(self) -> Tile:
        """See TileWork."""
        x, y, width, height = self.rect
        scene = self._job.scene
        points = trace_points(self._job, camera_rays(scene.camera, *self.rect))
        self._primary += width * height
        inside = self._inside(self.rect)
        sums = PassSums(*(column[inside] for column in self._sums))
        layers = filtered_layers(
            scene, points, sums, (width, height), self._job.settings.max_samples
        )
        weight = float(scene.exposure) / np.maximum(sums.passes, 1)
        self._sampler.show_caught(inside, layers)
        place = np.arange(len(inside))
        self._sampler.lamps.add_to_layers(layers, inside, place, weight)
        self._sampler.occlusion.add_to_layers(
            layers, inside, place, 1.0 / np.maximum(sums.passes, 1)
        )
        return Tile(x, y, width, height, layers)

    def rest(self) -> None:
        """See TileWork: nothing else is kept."""

    def counts(self) -> TileCounts:
        """See TileWork."""
        inside = self._inside(self.rect)
        count, hits = self._sums.count[inside], self._sums.hits[inside]
        return TileCounts(
            int((hits > 0).sum()),
            int(count.sum()),
            int(count.max()),
            self._sampler.all_traced,
            self._primary,
        )

    def _take_passes(self, wanted: np.ndarray) -> None:
        """Take the pixels on to as many passes as ``wanted``, int32 (n,), says of each."""
        settings, pixels = self._job.settings, self._pixels
        n = self._batch
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
        parts = []
        for job, looked, time in self._in_time(self._looked()):
            points, missed = self._look(job, looked, time)
            self._sampler.look_at(job)
            found = self._sampler.gather(points, count, self._passes)
            parts.append((job, found, missed))
        if self._passes and self._job.stop.is_set():
            return  # a pass that was cut short would darken those before it
        for job, found, missed in parts:
            self._sampler.look_at(job)
            self._add_world(*missed)
            for add, *own in found:
                add(*own)
        known = self._sampler.lamps.known(self._sums)
        close_pass(self._active, self._job.scene.transparent_film, known)
        self._passes += 1

    def _looked(self) -> np.ndarray:
        """int32: active pixels; the first passes look through those around the tile as well."""
        if self._passes >= PILOT:
            return self._active
        return np.append(self._active, np.flatnonzero(self._cell < 0).astype(np.int32))

    def _in_time(self, looked):
        """(job, pixels, time) of each slice of the shutter's time that a pass sees pixels in."""
        if not self._job.slices:
            yield self._job, looked, None
            return
        times = self._job.scene.motion.times
        own = self._job.settings, *self._places(looked), self._passes
        slices = pass_slices(*own, len(times))
        for number in np.unique(slices):
            yield self._job.slices[number], looked[slices == number], float(times[number])

    def _look(self, job: Job, looked, time):
        """The pixels' next points: (points, (pixels that see the world, their directions and
        ShadingPoints.through))."""
        pilot = self._passes < PILOT
        rays = self._rays(looked, time)
        tints = np.ones((len(looked), 3), np.float32)
        points = trace_points(job, rays, self._dither(looked), tints)
        self._primary += len(looked)
        missed = np.ones(len(looked), np.bool_)
        missed[points.pixel] = False
        points = points._replace(pixel=looked[points.pixel])
        if pilot:
            self._silhouettes.note(looked[missed], rays.directions[missed].any(axis=1), points)
            inside = self._cell >= 0
            missed &= inside[looked]
            points = points.at(inside[points.pixel])
        return points, (looked[missed], rays.directions[missed], tints[missed])

    def _dither(self, pixels) -> np.ndarray | None:
        """What cut-outs draw in this pass (cutouts.points_through), if there may be any."""
        if self._job.scene.shaders is None:
            return None
        return pass_numbers(self._job.settings, *self._places(pixels), self._passes)

    def _places(self, pixels) -> tuple[np.ndarray, np.ndarray]:
        """Column and row in the frame, int64."""
        rows, columns = np.divmod(pixels.astype(np.int64), self._around.width)
        return columns + self._around.x, rows + self._around.y

    def _rays(self, pixels, time):
        columns, rows = self._places(pixels)
        scene, settings = self._job.scene, self._job.settings
        return pass_rays(scene.camera, settings, columns, rows, self._passes, time)

    def _add_world(self, pixels, directions, tints) -> None:
        scene, looks = self._job.scene, directions.any(axis=1)
        if not looks.all():
            self._sums.opaque[pixels[~looks]] += 1
            pixels, directions, tints = pixels[looks], directions[looks], tints[looks]
        self._sums.opaque[pixels] += opacity_of(tints)
        if not len(pixels) or not scene.environment.visible_to_camera:
            return
        radiance = self._job.seen_world.radiance(directions) * tints
        add_background(pixels, radiance, not scene.transparent_film, self._sums)

    def _goes_on(self) -> np.ndarray:
        """bool, one for each active pixel: whether it takes another pass."""
        settings, active = self._job.settings, self._active
        endless = settings.stop_rule == "FIXED" or settings.error_threshold == 0.0
        if endless or self._passes < PILOT:
            return np.ones(len(active), np.bool_)
        if settings.stop_rule == "PAPER":
            going = self._sums.error[active] > settings.error_threshold
        else:
            going = self._wants_more(typical_count(settings.error_threshold))
        if self._passes < _SILHOUETTE / settings.error_threshold:
            going |= self._silhouettes.near()[active]
        return going

    def _wants_more(self, typical: float) -> np.ndarray:
        """PERCEPTUAL: whether N = T r^.75 is more than there are. typical: T"""
        n, spread = self._batch, self._spreads(self._active, typical)
        taken = np.full(len(spread), self._passes * n, np.int32)
        return plan_counts(spread, taken, typical, self._job.settings.max_samples) > taken

    def _spreads(self, pixels, typical: float) -> np.ndarray:
        """float32, r of pixels; of blurred ones that of their cell. typical: T"""
        known = self._sampler.lamps.known(self._sums)
        sums, blurred_ones = self._sums, self._pixels[self._silhouettes.blurred[self._pixels]]
        n, transparent = self._batch, self._job.scene.transparent_film

        def own(some):
            spread = np.empty(len(some), np.float32)
            fill_spreads(some, n, FLOOR / typical, transparent, known, spread)
            return spread

        spread = own(pixels)
        if len(blurred_ones):
            passes, light = sums.passes[blurred_ones], sums.light[blurred_ones]
            cell = self._cell[blurred_ones]
            shared = cell_spreads(cell, self._n_cells, passes, light, own(blurred_ones))
            which = self._silhouettes.blurred[pixels]
            spread[which] = shared[self._cell[pixels[which]]]
        return spread

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

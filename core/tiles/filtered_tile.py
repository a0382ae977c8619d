"""The work at a tile whose pixels average several shading points, a pass after another.

A pass gives each pixel one point (pixel_filter.py) with a few samples; pass_plan.py says how many
passes it wants, and how many are taken at once. Whether a pixel is near a silhouette is asked of
the rays of the first passes, of the pixel and its eight neighbours; so those around the tile are
looked through too, and no picture depends on its tiles.
"""

from __future__ import annotations

import numpy as np

from ..camera.camera import camera_rays, pixel_grid
from ..camera.pass_rays import (
    PILOT,
    PassRays,
    pass_numbers,
    pass_rays,
    pass_slices,
    rays_by_pass,
    samples_of_a_pass,
)
from ..camera.silhouettes import Silhouettes
from ..data.rows import any_in_row, row_and_column, rows_of
from ..film import Tile
from ..lamplight.lamp_glow import lamp_glow, shown_lamps
from ..passes.develop import filtered_layers
from ..passes.pass_sums import PassSums, add_background, add_glow, close_passes, new_pass_sums
from ..sampling.neighbours import cell_order
from ..see_through.clear_materials import cut_materials
from ..see_through.cutouts import opacity_of
from .pass_plan import PassPlan, end_of_batch
from .pass_samples import PassSampler
from .sample_plan import WHOLE_SHARE, Demand, dither_of, powers
from .tile_job import (
    Job,
    Rect,
    TileCounts,
    asked_crossed,
    trace_points,
    trace_whole,
    whole_cells,
)


class FilteredTile:
    """Several shading points a pixel (tile_job.TileWork); 292 bytes a pixel between calls.

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
        self._batch = samples_of_a_pass(job.settings, job.scene.camera)
        self._sampler = PassSampler(job, self._around, self._cell, self._sums)
        self._silhouettes = Silhouettes(job.scene, self._around.width, self._around.height)
        known = self._silhouettes, self._pixels, self._cell
        film = job.scene.transparent_film
        self._plan = PassPlan(job.settings, self._batch, film, *known, job.takes_away)
        self._shown = shown_lamps(job.scene.lamps)
        self._passes = self._primary = 0
        self._active, self._wants = self._pixels, self._plan.wanted(self._pixels, 0, self._sums)

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        settings = self._job.settings
        most = -(-settings.max_samples // self._batch)
        last = min(-(-samples // self._batch), most)
        while len(self._active) and self._passes < most and not self._job.stop.is_set():
            end = min(self._end_of_batch(self._passes), most)
            if end > last:
                break
            taken = self._sums.passes[self._active]
            if not self._take(self._active, np.minimum(self._wants - taken, end - self._passes)):
                break
            self._passes = end
            wants = self._plan.wanted(self._active, end, self._known())
            going = wants > self._sums.passes[self._active]
            self._active, self._wants = self._active[going], wants[going]
        return not len(self._active) or self._passes >= most

    def look(self, typical: float, most: int) -> None:
        """See TileWork: PILOT passes at the most, the same for all; ``typical`` is not asked."""
        passes = max(1, min(PILOT, most // self._batch))
        self._take_passes(np.full(self._n, passes, np.int32))

    def demand(self, typical: float) -> Demand:
        """See TileWork: of all pixels of the tile's cells, cell by cell."""
        n, pixels, sums = self._batch, self._pixels, self._sums
        passes = np.maximum(sums.passes[pixels], 1)
        near = self._silhouettes.near()[pixels]
        rows, columns = row_and_column(pixels, self._around.width)
        counted = np.zeros(self._n, np.bool_)
        counted[self._inside(self.rect)] = True
        counted = counted[pixels]
        share = sums.count[pixels].astype(np.int64) * WHOLE_SHARE // (passes * n)
        return Demand(
            power=powers(self._plan.spreads(pixels, typical, self._known())),
            least=np.where(near, self._plan.least_of_edges(), np.float32(0.0)),
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
        rays = camera_rays(scene.camera, *self.rect)
        points = trace_points(self._job, rays, solid=scene.asked.solid)
        self._primary += width * height
        inside = self._inside(self.rect)
        sums = PassSums(*(column[inside] for column in self._sums))
        layers = filtered_layers(
            scene, points, sums, (width, height), self._job.settings.max_samples
        )
        weight = float(scene.exposure) / np.maximum(sums.passes, 1)
        self._sampler.groups.write(layers, inside, weight[:, None])
        self._sampler.show_caught(inside, layers)
        place = np.arange(len(inside))
        self._sampler.lamps.add_to_layers(layers, inside, place, weight)
        self._sampler.occlusion.add_to_layers(
            layers, inside, place, 1.0 / np.maximum(sums.passes, 1)
        )
        self._sampler.surface.write(layers, inside, sums.passes)
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
        pixels = self._pixels
        while not self._job.stop.is_set():
            behind = pixels[self._sums.passes[pixels] < wanted[pixels]]
            if not len(behind):
                break
            passes = self._sums.passes[behind]
            self._passes = least = int(passes.min())
            first = behind[passes == least]
            size = self._end_of_batch(least) - least
            self._take(first, np.minimum(wanted[first] - least, size))

    def _end_of_batch(self, passes: int) -> int:
        return end_of_batch(passes, self._sampler.together, self._job.first_passes)

    def _take(self, pixels: np.ndarray, counts: np.ndarray) -> bool:
        """The next ``counts`` shading points, int32, of each of the pixels, int32 by cells.

        Returns whether they count: passes that were cut short would darken those before them.
        """
        rays, parts = self._next_rays(pixels, counts), []
        for job, looked, time in self._in_time(rays):
            seen, missed, glow = self._look(job, looked, time)
            self._sampler.look_at(job)
            found = self._sampler.gather(*seen)
            parts.append((job, found, missed, glow))
        if self._passes and self._job.stop.is_set():
            return False
        for job, found, missed, glow in parts:
            self._sampler.look_at(job)
            self._add_world(*missed)
            if glow is not None:
                add_glow(*glow, self._sums)
                self._sampler.groups.add_glow(*glow)
            for add, *own in found:
                add(*own)
        film = self._job.scene.transparent_film
        close_passes(pixels, counts, film, self._known())
        return True

    def _known(self) -> PassSums:
        """The sums as the stop rule is to see them."""
        return self._sampler.lamps.known(self._sums)

    def _next_rays(self, pixels, counts) -> PassRays:
        """The pixels' next rays; the first passes look through the pixels around the tile too."""
        if self._passes < PILOT:
            around = np.flatnonzero(self._cell < 0).astype(np.int32)
            size = self._end_of_batch(self._passes) - self._passes
            pixels = np.append(pixels, around)
            counts = np.append(counts, np.full(len(around), size, np.int32))
        first = self._sums.passes[pixels]
        first[self._cell[pixels] < 0] = self._passes
        return rays_by_pass(pixels, first, counts)

    def _in_time(self, rays: PassRays):
        """(job, rays, time) of each slice of the shutter's time that passes see pixels in."""
        if not self._job.slices:
            yield self._job, rays, None
            return
        times = self._job.scene.motion.times
        own = self._job.settings, *self._places(rays.pixel), rays.number
        slices = pass_slices(*own, len(times))
        for k in np.unique(slices):
            yield self._job.slices[k], rays.at(slices == k), float(times[k])

    def _look(self, job: Job, own: PassRays, time):
        """What rays see: (for PassSampler.gather, (pixels that see the world, their directions and
        ShadingPoints.through), (pixels, what lamp_glow says of them) or None)."""
        pilot, looked = self._passes < PILOT, own.pixel
        rays = self._rays(own, time)
        tints = np.ones((len(looked), 3), np.float32)
        passed, crossed = None if self._shown is None else [], asked_crossed(job.scene)
        points = trace_points(job, rays, self._dither(own), tints, passed, crossed)
        whole = trace_whole(job, rays, points, crossed)
        glow, groups = None, len(self._job.scene.asked.groups.layers)
        if self._shown is not None:
            glow = looked, lamp_glow(self._shown, rays, points, groups, passed)
        self._primary += len(looked)
        missed = np.ones(len(looked), np.bool_)
        missed[points.pixel] = False
        numbers, points = own.number[points.pixel], points._replace(pixel=looked[points.pixel])
        missed = np.flatnonzero(missed)
        if pilot:
            looks = any_in_row(rays.directions.take(missed, axis=0))
            self._silhouettes.note(looked[missed], looks, points)
            inside = self._cell >= 0
            missed = missed[inside[looked[missed]]]
            kept = inside[points.pixel]
            numbers, points = numbers[kept], points.at(kept)
            whole = None if whole is None else whole.at(kept)
        if whole is not None:
            whole = whole.of_pixels(looked, self._cell >= 0)
        seen = points, numbers, whole, own.number
        return seen, rows_of((looked, rays.directions, tints), missed), glow

    def _dither(self, rays: PassRays) -> np.ndarray | None:
        """What cut-outs draw for them (cutouts.points_through), if there may be any."""
        if cut_materials(self._job.scene) is None:
            return None
        return pass_numbers(self._job.settings, *self._places(rays.pixel), rays.number)

    def _places(self, pixels) -> tuple[np.ndarray, np.ndarray]:
        """Column and row in the frame, int64."""
        rows, columns = row_and_column(pixels.astype(np.int64), self._around.width)
        return columns + self._around.x, rows + self._around.y

    def _rays(self, rays: PassRays, time):
        columns, rows = self._places(rays.pixel)
        scene, settings = self._job.scene, self._job.settings
        return pass_rays(scene.camera, settings, columns, rows, rays.number, time)

    def _add_world(self, pixels, directions, tints) -> None:
        scene, looks = self._job.scene, any_in_row(directions)
        if not looks.all():
            np.add.at(self._sums.opaque, pixels[~looks], np.float32(1.0))
            pixels, directions, tints = rows_of((pixels, directions, tints), looks)
        self._sampler.surface.add_missed(scene, pixels, directions)
        film = opacity_of(tints) if self._job.scene.transparent_film else np.float32(1.0)
        np.add.at(self._sums.opaque, pixels, film)
        if not len(pixels) or not scene.environment.visible_to_camera:
            return
        radiance = self._job.seen_world.radiance(directions) * tints
        add_background(pixels, radiance, not scene.transparent_film, self._sums)

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

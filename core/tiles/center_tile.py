"""The work at a tile whose pixels have one shading point each, at their centre."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from ..camera.camera import pixel_grid, rays_through
from ..data.rows import any_in_row
from ..film import Tile
from ..lamplight.lamp_glow import lamp_glow, shown_lamps
from ..passes.ambient_occlusion import TileOcclusion
from ..passes.catchers import Roles, are_whole_holes, hide_roles, plays, show_caught
from ..passes.develop import MissedRays, PlacedPoints, develop_points, write_geometry
from ..passes.light_groups import TileGroups
from ..passes.surface_passes import SurfacePasses
from ..passes.whole_surfaces import WholeSurfaces
from ..products.guide import Guides, new_guides
from ..sampling.incremental import PixelSums, new_sums
from ..sampling.neighbours import CELL_PX, cell_order
from ..sampling.stop_rule import Rule, perceptual_rule, spread_of, stop_rule
from ..scene import HOLDOUT, SHADOW_CATCHER
from ..surfaces.merged_layers import merge_layers, shown_normals, turns_normals
from ..surfaces.seen_points import ClosureLayer, with_all_lobes
from .sample_plan import WHOLE_SHARE, Demand, dither_of, powers
from .tile_job import (
    Job,
    Rect,
    TileCounts,
    add_samples,
    asked_crossed,
    frame_places,
    trace_points,
    trace_whole,
    whole_cells,
)
from .tile_lamps import TileLamps


class CenterTile:
    """One shading point a pixel (tile_job.TileWork); 244 bytes a pixel between calls.

    Where pixels tell of each other (PERCEPTUAL, guides), the work is at whole cells, of which
    ``develop`` cuts the tile: a picture does not depend on its border.
    """

    def __init__(self, job: Job, rect: Rect):
        self._job, self.rect = job, rect
        settings = job.settings
        self._learns = settings.estimator == "UNBIASED"
        alone = settings.stop_rule not in ("PERCEPTUAL", "BUDGET") and not self._learns
        self._whole = rect if alone else whole_cells(rect, job.scene.camera)
        # One each for every closure that points mix (tile_job.ClosureLayer).
        self._sums: list[PixelSums] | None = None
        self._layers: list[ClosureLayer] | None = None
        self._bounds: list[np.ndarray] = []
        self._guides: list[Guides] = []
        self._missed: MissedRays | None = None
        self._glow: tuple[np.ndarray, np.ndarray] | None = None
        self._places = np.zeros(0, np.int32)
        self._own: np.ndarray | None = None  # of WholeSurfaces, a row each of the points
        self._whole_surfaces: WholeSurfaces | None = None  # with pixels of the tile, none outside
        self._lamps: TileLamps | None = None
        self._occlusion: TileOcclusion | None = None
        self._traced = self._primary = 0

    def advance(self, samples: int) -> bool:
        """See TileWork."""
        settings = self._job.settings
        most = min(samples, settings.max_samples)
        self._add(stop_rule(dataclasses.replace(settings, max_samples=most)))
        taken = max(sums.count.max(initial=0) for sums in self._sums)
        return samples >= settings.max_samples or taken < samples

    def look(self, typical: float, most: int) -> None:
        """See TileWork."""
        self._add(perceptual_rule(typical, most))

    def demand(self, typical: float) -> Demand:
        """See TileWork: of the points, in the order of their cells."""
        self._look()
        parts = [
            self._demand(layer, sums) for layer, sums in zip(self._layers, self._sums, strict=True)
        ]
        arrays = map(np.concatenate, zip(*parts, strict=True))
        return Demand(*arrays, grain=0, shaded=int((self._places >= 0).sum()))

    def _demand(self, layer: ClosureLayer, sums: PixelSums) -> tuple[np.ndarray, ...]:
        """The arrays of a Demand."""
        counted = (self._places[layer.of] >= 0) & (sums.count > 0)
        columns, rows = frame_places(self._whole, layer.seen.points.pixel)
        return (
            powers(spread_of(sums)),
            np.zeros(len(counted), np.float32),
            sums.count.copy(),
            np.where(counted, WHOLE_SHARE, 0).astype(np.int32),
            dither_of(columns, rows),
        )

    def go_to(self, counts: np.ndarray, typical: float) -> None:
        """See TileWork."""
        self._look()
        ends = np.cumsum([len(layer.of) for layer in self._layers])
        most = self._job.settings.max_samples
        plans = np.split(counts, ends[:-1])
        self._add(*(perceptual_rule(typical, most, plan) for plan in plans))

    def develop(self) -> Tile:
        """See TileWork."""
        self._look()
        seen, sums = merge_layers(self._layers, self._sums)
        scene, points = self._job.scene, seen.points
        normal = shown_normals(self._layers) if turns_normals(scene) else points.normal
        layers = develop_points(
            scene,
            self._job.seen_world,
            PlacedPoints(
                points,
                seen.lobes,
                self._places,
                normal * self._own[:, None],
                np.where(self._own > 0.0, self._places, -1),
            ),
            self._missed,
            sums,
            self.rect[2:],
            self._job.settings.max_samples,
        )
        caught, hidden = (plays(scene, points, role) for role in (SHADOW_CATCHER, HOLDOUT))
        shown, inside = ~(caught | hidden), self._places >= 0
        roles = Roles(*(np.flatnonzero(own & inside) for own in (caught, hidden)))
        hide_roles(roles, points, self._places, layers)
        self._write_groups(points, np.where(shown, self._places, -1), seen.lobes.emission, layers)
        sums = self._with_lamps(np.flatnonzero(caught), points, sums)
        show_caught(scene, self._job.seen_world, roles, points, self._places, sums, layers)
        exposure = np.where(shown, float(scene.exposure), 0.0)
        self._lamps.add_to_layers(layers, slice(None), self._places, exposure)
        whole = (shown | caught).astype(float)
        self._occlusion.add_to_layers(layers, slice(None), self._places, whole)
        if self._glow is not None:
            _add_glow(*self._glow, float(scene.exposure), layers)
        self._write_surfaces(points, layers)
        return Tile(*self.rect, layers)

    def _write_surfaces(self, points, layers) -> None:
        """Write what needs no light."""
        scene, missed = self._job.scene, self._missed
        surface = SurfacePasses(scene, self.rect.width * self.rect.height)
        surface.add(scene, points, self._places, self._own)
        if self._whole_surfaces is not None:
            self._write_whole(surface, layers)
        looks = any_in_row(missed.directions)
        surface.add_missed(scene, missed.place[looks], missed.directions[looks])
        surface.write(layers, slice(None), np.ones(1, np.int32))

    def _write_whole(self, surface, layers) -> None:
        """Write what data passes have in place of the points."""
        scene, whole = self._job.scene, self._whole_surfaces
        surface.add_panes(scene, whole.panes, whole.panes.pixel, whole.taken)
        self._add_panes_occlusion(whole, layers)
        shown = ~are_whole_holes(scene, whole.points)
        points, weight = whole.points.at(shown), whole.weight[shown]
        if not len(weight):
            return
        surface.add_whole(scene, points, points.pixel, weight)
        write_geometry(layers, scene, points, points.pixel)
        normal = points.facing_viewer().normal
        if turns_normals(scene):
            normal = shown_normals(with_all_lobes(scene, points))
        layers["normal"].reshape(-1, 3)[points.pixel] += normal * weight[:, None]

    def _add_panes_occlusion(self, whole, layers) -> None:
        if self._occlusion.wanted and len(whole.taken):
            places = frame_places(self.rect, whole.panes.pixel)
            own = self._occlusion.panes_at_once(whole.panes, whole.taken, places)
            np.add.at(layers["ambient_occlusion"].reshape(-1, 3), whole.panes.pixel, own)

    def _write_groups(self, points, place, emission, layers) -> None:
        """Write the layers of light groups; place: of what is seen itself, -1 = none."""
        groups = TileGroups(self._job.scene, self.rect.width * self.rect.height)
        if groups.wanted:
            groups.add_emission(points, place, emission)
            if self._glow is not None:
                groups.add_glow(*self._glow)
            groups.write(layers, slice(None), float(self._job.scene.exposure))

    def _with_lamps(self, caught, points, sums):
        """The sums, those of points on catchers with the lamps' light in them."""
        if not len(caught):
            return sums
        where = frame_places(self._whole, points.pixel[caught])
        own = type(sums)(*(column[caught] for column in sums))
        own = self._lamps.caught_at_once([layer.at(caught) for layer in self._layers], where, own)
        whole = type(sums)(*(column.copy() for column in sums))
        for column, part in zip(whole, own, strict=True):
            column[caught] = part
        return whole

    def rest(self) -> None:
        """See TileWork."""
        self._layers = self._missed = self._glow = self._whole_surfaces = None

    def counts(self) -> TileCounts:
        """See TileWork."""
        self._look()
        whole = np.zeros(len(self._places), np.int64)
        for layer, sums in zip(self._layers, self._sums, strict=True):
            whole[layer.of] += sums.count
        count = whole[self._places >= 0]
        return TileCounts(
            len(count),
            int(count.sum()),
            int(count.max(initial=0)),
            self._traced + self._lamps.traced + self._occlusion.traced,
            self._primary,
        )

    def _add(self, *rules: Rule) -> None:
        """rules: one for each layer, or one for all."""
        self._look()
        rules = rules * len(self._layers) if len(rules) == 1 else rules
        own = self._layers, self._sums, self._bounds, rules, self._guides
        for layer, sums, bounds, rule, guides in zip(*own, strict=True):
            self._traced += add_samples(
                self._job, layer.seen, self._whole, sums, bounds, rule, guides
            )

    def _look(self) -> None:
        """Have the points that the pixels' centres see, in the order of their cells."""
        if self._layers is not None:
            return
        scene, whole = self._job.scene, self._whole
        pixel, ends = _cell_pixels(whole.x % CELL_PX, whole.y % CELL_PX, *whole[2:])
        columns, rows = frame_places(whole, pixel)
        rays = rays_through(scene.camera, columns + 0.5, rows + 0.5)
        self._primary += len(rays.origins)
        tints = np.ones((len(pixel), 3), np.float32)
        shown = shown_lamps(scene.lamps)
        passed, crossed = None if shown is None else [], asked_crossed(scene)
        points = trace_points(self._job, rays, dither_of(columns, rows), tints, passed, crossed)
        whole = trace_whole(self._job, rays, points, crossed)
        self._own = np.ones(len(points.pixel), np.float32) if whole is None else whole.own
        missed = np.ones(len(pixel), np.bool_)
        missed[points.pixel] = False
        places = places_in(self.rect, columns, rows)
        self._missed = MissedRays(places[missed], rays.directions[missed], tints[missed])
        if shown is not None:
            groups = len(scene.asked.groups.layers)
            self._glow = places, lamp_glow(shown, rays, points, groups, passed)
        self._places = places[points.pixel]
        if whole is not None:
            inside = np.ones(self.rect.width * self.rect.height + 1, np.bool_)
            inside[-1] = False  # that of the place -1
            whole = whole.of_pixels(places, inside)
        self._whole_surfaces = whole
        bounds = np.searchsorted(points.pixel, ends)  # points.pixel: rows of the rays, ascending
        layers = with_all_lobes(scene, points._replace(pixel=pixel[points.pixel]))
        self._bounds = [np.searchsorted(layer.of, bounds).astype(np.int32) for layer in layers]
        self._layers = layers
        if self._sums is None:
            self._sums = [new_sums(len(layer.of)) for layer in layers]
            n = len(bounds) - 1 if self._learns else 0
            self._guides = [new_guides(n) for _ in layers]
            self._settle(layers, (columns[points.pixel], rows[points.pixel]))

    def _settle(self, layers: list[ClosureLayer], where) -> None:
        """Have what is sampled once and for all. where: column and row in the frame"""
        own = self._job.scene, self._job.settings, self._job.accel, len(where[0])
        self._lamps, self._occlusion = TileLamps(*own), TileOcclusion(*own)
        self._lamps.settle(layers, where)
        first = layers[0].seen
        self._occlusion.settle(first.points, first.lobes, where)


def _add_glow(places, radiance, exposure, layers) -> None:
    """Add what the camera sees of lamps; places: of all rays, -1 = outside."""
    inside = places >= 0
    for name in ("combined", "emission"):
        flat = layers[name].reshape(-1, layers[name].shape[2])
        flat[places[inside], :3] += radiance[inside, :3] * np.float32(exposure)


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

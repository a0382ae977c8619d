"""The samples of a pass: what a tile's shading points bring, and where it is kept."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..bsdf.hair_setup import has_world
from ..bsdf.sheen import diffuse_colors
from ..camera.pass_rays import PILOT, samples_of_a_pass
from ..data.channels import LUMINANCE
from ..geometry.shading import ShadingPoints
from ..passes.ambient_occlusion import TileOcclusion
from ..passes.catchers import CaughtPasses, are_whole_holes, has_role, plays
from ..passes.light_groups import TileGroups
from ..passes.pass_sums import PassSums, add_seen
from ..passes.surface_passes import SurfacePasses
from ..passes.whole_surfaces import WholeSurfaces
from ..products.guide import new_guides
from ..sampling.block_loop import PASSES_AT_ONCE
from ..sampling.incremental import PixelSums, new_sums
from ..sampling.stop_rule import pass_rule
from ..scene import HOLDOUT, SHADOW_CATCHER
from ..see_through.cutouts import opacity_of
from ..surfaces.merged_layers import merge_layers, shown_normals, turns_normals
from ..surfaces.seen_points import ClosureLayer, SeenPoints, with_all_lobes
from .tile_job import Job, Rect, add_samples, frame_places
from .tile_lamps import TileLamps
from .walked_layers import walked_layers

_DARK = 1e-3  # albedo, of closures that reflect nothing


class PassSampler:
    """Samples the points of a tile's passes.

    together: how many passes may be taken at once; one where each is decided upon (rule PAPER)
    lamps: what they bring to the pixels; groups: what else light groups do; occlusion: the pass of
        that name; surface: those of the surfaces alone
    traced: shadow rays so far, without theirs
    """

    def __init__(self, job: Job, around: Rect, cell: np.ndarray, state: PassSums):
        """around: the pixels, row by row; cell: int32, of each, -1 = none; state: is added to"""
        self._job, self._around, self._cell, self._state = job, around, cell, state
        self._n_cells, n = int(cell.max()) + 1, len(cell)
        self._guides = new_guides(self._n_cells if job.settings.estimator == "UNBIASED" else 0)
        self._caught = CaughtPasses(n) if has_role(job.scene, SHADOW_CATCHER) else None
        self.lamps = TileLamps(job.scene, job.settings, job.accel, n)
        self.occlusion = TileOcclusion(job.scene, job.settings, job.accel, n)
        self.groups, self.surface = TileGroups(job.scene, n), SurfacePasses(job.scene, n)
        self._turned = turns_normals(job.scene)
        self._batch = samples_of_a_pass(job.settings, job.scene.camera)
        alone = job.settings.stop_rule == "PAPER"
        # Four passes are one in each quarter of the shutter's time (pass_rays.pass_slices).
        most = PILOT if job.slices else PASSES_AT_ONCE
        self.together = 1 if alone else most
        self.traced = 0

    def look_at(self, job: Job) -> None:
        """Work at another slice of the shutter's time from now on: one of job.slices."""
        self._job = job
        self.lamps.look_at(job.accel, job.scene.lamps)
        self.occlusion.look_at(job.accel)

    @property
    def all_traced(self) -> int:
        """All shadow rays so far."""
        return self.traced + self.lamps.traced + self.occlusion.traced

    def gather(
        self,
        points: ShadingPoints,
        number: np.ndarray,
        whole: WholeSurfaces | None,
        numbers: np.ndarray,
    ) -> list[tuple]:
        """Sample points of passes, int64, one for each point, by the samples that these have.

        whole: what data passes have in their place, None = the points; numbers: of all rays
        Returns (function, arguments) for each kind of surface: to be called, adds it to the sums.
        """
        caught = plays(self._job.scene, points, SHADOW_CATCHER)
        hidden = plays(self._job.scene, points, HOLDOUT)
        plain, found = ~(caught | hidden), []
        own = np.ones(len(number), np.float32) if whole is None else whole.own
        np.add.at(self._state.opaque, points.pixel[hidden], opacity_of(points.through[hidden]))
        if plain.any():
            layers, passes = self._layers_of(points, plain), number[plain]
            places = frame_places(self._around, layers[0].seen.points.pixel)
            layers = walked_layers(self._job, layers, places, passes)
            sums = self._sample(self._job, layers, passes)
            found.append((self._add_seen, layers, sums, passes, own[plain]))
        if caught.any():
            layers = self._layers_of(points, caught)
            job = dataclasses.replace(self._job, accel=self._job.accel.without_catchers)
            sums = self._sample(job, layers, number[caught])
            found.append((self._add_caught, layers, sums, number[caught], own[caught], job.accel))
        if self.surface.wanted:
            found.append((self.surface.add, self._job.scene, points, points.pixel, own))
        if whole is not None:
            found.append((self._add_whole, whole, numbers))
        if hidden.any() and self._job.scene.asked.solid is not None:
            partly = hidden & ~are_whole_holes(self._job.scene, points)
            found.append((self._add_partly, points.at(partly), number[partly], own[partly]))
        return found

    def show_caught(self, rows: np.ndarray, layers: dict[str, np.ndarray]) -> None:
        """Add catchers to developed layers, which show the pixels ``rows``."""
        if self._caught is not None:
            self._caught.show(self._job.scene, rows, self._state.passes[rows], layers)

    def _layers_of(self, points, which) -> list[ClosureLayer]:
        return with_all_lobes(self._job.scene, points if which.all() else points.at(which))

    def _add_whole(self, whole: WholeSurfaces, numbers) -> None:
        """Add what data passes have in place of points where rays have ended."""
        scene, panes = self._job.scene, whole.panes
        self.surface.add_panes(scene, panes, panes.pixel, whole.taken)
        places = frame_places(self._around, panes.pixel)
        self.occlusion.add_panes(panes, whole.taken, places, numbers[whole.ray])
        shown = ~are_whole_holes(scene, whole.points)
        points, weight = whole.points.at(shown), whole.weight[shown]
        if not len(weight):
            return
        self.surface.add_whole(scene, points, points.pixel, weight)
        self._add_normals(self._layers_of(points, shown[shown]), weight)

    def _add_partly(self, points, number, own) -> None:
        """Add what passes have of points that holdouts hide from the picture, by their share."""
        if not len(number):
            return
        layers = self._layers_of(points, np.ones(len(number), np.bool_))
        self._add_normals(layers, own)
        first = layers[0].seen
        facing, places = first.points.facing_viewer(), frame_places(self._around, points.pixel)
        self.occlusion.add_pass(facing, first.lobes, places, number)

    def _add_normals(self, layers, weight) -> None:
        seen = layers[0].seen
        seen = seen._replace(points=seen.points.facing_viewer())
        normal = self._shown_normals(layers, seen) * weight[:, None]
        np.add.at(self._state.normal, seen.points.pixel, normal)

    def _add_seen(self, layers, sums, number, own) -> None:
        seen, sums = merge_layers(layers, sums)
        points = seen.points
        places = frame_places(self._around, points.pixel)
        self.lamps.add_pass(layers, places, number, sums)
        self.groups.add_emission(points, points.pixel, seen.lobes.emission)
        self.occlusion.add_pass(points, seen.lobes, places, number)
        normal = self._shown_normals(layers, seen) * own[:, None]
        add_seen(points.pixel, normal, seen.lobes, sums, self._state)

    def _add_caught(self, layers, sums, number, weight, accel) -> None:
        seen, sums = merge_layers(layers, sums)
        places = frame_places(self._around, seen.points.pixel)
        sums = self.lamps.caught(layers, places, number, accel, sums)
        self.occlusion.add_pass(seen.points, seen.lobes, places, number)
        normal = self._shown_normals(layers, seen) * weight[:, None]
        own = seen, normal, sums, self._state
        self._caught.add(self._job.scene, self._job.seen_world, *own)

    def _shown_normals(self, layers, seen) -> np.ndarray:
        return shown_normals(layers) if self._turned else seen.points.normal

    def _sample(self, job: Job, layers, number) -> list[PixelSums]:
        """The samples of each point, shared among its closures."""
        counts = shared_counts(layers, self._batch)
        return [
            self._sample_rows(job, layer.seen, number[layer.of], count)
            for layer, count in zip(layers, counts, strict=True)
        ]

    def _sample_rows(self, job: Job, seen: SeenPoints, number, count) -> PixelSums:
        """count: int64, samples of each point; those of a pixel's passes follow each other."""
        first = (number * count).astype(np.int32)
        left = np.maximum(job.settings.max_samples - number * self._batch, 1)
        count = np.where(left < self._batch, np.maximum(count * left // self._batch, 1), count)
        sums, rule = new_sums(len(seen.rows)), pass_rule(self._batch, first + np.int32(count))
        cells = np.arange(self._n_cells + 1)
        bounds = np.searchsorted(self._cell[seen.points.pixel], cells).astype(np.int32)
        self.traced += add_samples(job, seen, self._around, sums, bounds, rule, self._guides, first)
        return sums


def shared_counts(layers: list[ClosureLayer], most: int) -> list[np.ndarray]:
    """How many of a point's ``most`` samples each of its closures takes: int64, a layer each.

    As they reflect: a coat brings a twentieth of what is under it. One at the least, and where a
    closure's count is the same in all passes, its samples are the first ones of one sequence. Of
    colors that are no numbers, or below 0, nothing is expected. None where there are lamps alone.
    """
    if len(layers) == 1:
        return [np.full(len(layers[0].of), most)]
    albedo = np.zeros((len(layers), len(layers[0].of)))
    for own, layer in zip(albedo, layers, strict=True):
        lobes = layer.seen.lobes
        color = diffuse_colors(lobes) if layer.color is None else layer.color
        color = np.nan_to_num(color + lobes.glossy_color, nan=0.0, posinf=1.0)
        own[layer.of] = np.maximum(color @ LUMINANCE, 0.0) + _DARK * has_world(lobes)
    share = albedo / albedo.sum(axis=0)
    counts = np.maximum(np.rint(share * most), albedo > 0.0).astype(np.int64)
    over, largest = counts.sum(axis=0) - most, counts.argmax(axis=0)
    rows = np.arange(len(largest))
    counts[largest, rows] = np.maximum(counts[largest, rows] - over, 1)
    return [own[layer.of] for own, layer in zip(counts, layers, strict=True)]

"""What the work at a tile is made of: the points that rays see, and their samples.

A tile's work is an object that can stop and go on (center_tile.py, filtered_tile.py). Between calls
it keeps sums; rays, points and products are made anew.
"""

from __future__ import annotations

import dataclasses
import threading
from typing import NamedTuple, Protocol

import numpy as np

from .accel import Accel
from .camera import planar_depth
from .film import Tile
from .incremental import PixelSums, Sampler, continue_points
from .light_rays import Light
from .lobes import Lobes, setup_lobes
from .paper import PaperSampler
from .paper_tables import PaperTables
from .scene import Scene
from .sequence import pixel_sequence
from .settings import RenderSettings
from .shading import ShadingPoints, params_at, shading_points
from .unbiased import UnbiasedSampler

# Points that are sampled together: their products (13 kB each where a lobe is glossy) stay in a
# core's cache from round to round, and a batch is still long enough for Embree.
BLOCK_POINTS = 256


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Job:
    """All that the workers share. sequence: uint32 (max_samples, 2), of sequence.common_points"""

    scene: Scene
    settings: RenderSettings
    accel: Accel
    light: Light
    tables: PaperTables | None
    sequence: np.ndarray
    stop: threading.Event


class Rect(NamedTuple):
    """Pixels of the frame, y up."""

    x: int
    y: int
    width: int
    height: int


class TileCounts(NamedTuple):
    """shaded: pixels that show an object; samples: theirs in all; samples_max: of one pixel."""

    shaded: int
    samples: int
    samples_max: int
    shadow_rays: int
    primary_rays: int


class TileWork(Protocol):
    """The work at one tile, with all that is known of it so far."""

    rect: Rect

    def advance(self, samples: int) -> bool:
        """Take every pixel on until it is done or has ``samples``: whether all are done."""

    def develop(self) -> Tile:
        """The layers as they are now."""

    def rest(self) -> None:
        """Let go of all that the next ``advance`` or ``develop`` can make anew."""

    def counts(self) -> TileCounts:
        """What it has cost."""


class SeenPoints(NamedTuple):
    """Shading points of a set of rays and what they are made of; rows: int32 (n,), materials."""

    points: ShadingPoints
    lobes: Lobes
    rows: np.ndarray

    def at(self, which) -> SeenPoints:
        """Those of a slice or of indices."""
        return SeenPoints(
            ShadingPoints(*(column[which] for column in self.points)),
            Lobes(*(column[which] for column in self.lobes)),
            self.rows[which],
        )


def trace_points(job: Job, origins, directions) -> ShadingPoints:
    """The points that camera rays see, float32 (n, 3); ``pixel`` is the row of the ray."""
    scene = job.scene
    hit, u, v = job.accel.intersect(origins, directions)
    points = shading_points(scene.mesh, hit, u, v, directions, scene.terminator_offset)
    near_enough = planar_depth(scene.camera, points.position) <= scene.camera.clip_end
    if not near_enough.all():
        points = ShadingPoints(*(np.ascontiguousarray(column[near_enough]) for column in points))
    return points


def with_lobes(scene: Scene, points: ShadingPoints) -> SeenPoints:
    """Set up the materials of points."""
    rows = scene.mesh.material_index[points.triangle]
    lobes = setup_lobes(
        params_at(scene.materials, rows), points.normal, points.geometric_normal, points.wo
    )
    return SeenPoints(points, lobes, rows)


def plain_blocks(n: int) -> list[slice]:
    """Points that are sampled together, where no stop rule asks for neighbours."""
    return [slice(start, start + BLOCK_POINTS) for start in range(0, n, BLOCK_POINTS)]


def add_samples(
    job: Job, seen: SeenPoints, rect: Rect, sums: PixelSums, blocks, rule_of, first: int = 0
) -> int:
    """Take the points on, a block after another, as their stop rules say: shadow rays traced.

    rect: the tile whose pixels ``points.pixel`` counts; sums: of the points, added to; blocks:
    slices of them; rule_of: StopRule of a block; first: samples before those that sums count
    """
    traced = 0
    for block in blocks:
        own, part = seen.at(block), PixelSums(*(column[block] for column in sums))
        sampler = _make_sampler(job, own, rect)
        part.count[:] += first
        traced += continue_points(sampler, part, job.accel, rule_of(block), job.stop.is_set)
        part.count[:] -= first
        known = sampler.unoccluded()
        if known is not None:
            part.unoccluded[:] = known * np.maximum(part.count, 1)[:, None]
    return traced


def _make_sampler(job: Job, seen: SeenPoints, rect: Rect) -> Sampler:
    points, lobes, rows = seen
    settings, offset = job.settings, job.accel.offset
    kind = settings.point_set
    sequence = pixel_sequence(job.sequence, points.pixel, rect[:3], settings.seed, kind)
    if settings.estimator == "PAPER":
        return PaperSampler(points, lobes, rows, job.tables, sequence, offset)
    return UnbiasedSampler(points, lobes, job.light, sequence, offset)

"""What the work at a tile is made of: the points that rays see, and their samples.

A tile's work is an object that can stop and go on (center_tile.py, filtered_tile.py). Between calls
it keeps sums; rays, points and products are made anew.
"""

from __future__ import annotations

import dataclasses
import threading
from typing import NamedTuple, Protocol

import numpy as np

from ..bsdf.lobes import DIFFUSE_LOBE
from ..camera.camera import CameraRays, SurfaceRays
from ..camera.pass_rays import PILOT
from ..data.rows import any_in_row, row_and_column
from ..embree.accel import Accel
from ..film import Tile
from ..geometry.shading import ShadingPoints
from ..machine import compile_apart
from ..machine.turns import aside
from ..machine.watch import StopFlag
from ..paper_mode.paper import PaperSampler
from ..paper_mode.paper_tables import PaperTables
from ..passes.whole_surfaces import WholeSurfaces, whole_surfaces
from ..products.guide import Guides
from ..products.like_products import apart_of
from ..sampling.block_loop import BLOCK_POINTS, CELL_POINTS, Places, Room, continue_blocks, new_room
from ..sampling.incremental import PixelSums, Sampler, continue_points
from ..sampling.light_rays import Light
from ..sampling.neighbours import CELL_PX, find_neighbours, long_blocks
from ..sampling.stop_rule import Rule, asks_neighbours
from ..sampling.unbiased_rays import UnbiasedSampler
from ..scene import Camera, Scene
from ..see_through.clear_materials import cut_materials
from ..see_through.cutouts import points_through
from ..settings import RenderSettings
from ..surfaces.backdrop import Backdrop
from ..surfaces.seen_points import SeenPoints
from ..unit_square.sequence import PixelSequence, pixel_sequence
from .sample_plan import Demand

_kept = threading.local()


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Job:
    """All that the workers share.

    sequence: uint32 (max_samples, 2), of sequence.common_points
    backdrop: of Scene.backdrop; None where there is none
    slices: the same at each slice of the shutter's time, where objects move
    first_passes: of a pixel filter, taken at once before there is a picture (pass_plan.py)
    takes_away: environment.takes_away of the light
    """

    scene: Scene
    settings: RenderSettings
    accel: Accel
    light: Light
    tables: PaperTables | None
    sequence: np.ndarray
    stop: StopFlag
    backdrop: Backdrop | None = None
    slices: tuple[Job, ...] = ()
    first_passes: int = PILOT
    takes_away: bool = False

    @property
    def seen_world(self) -> Backdrop:
        """What camera rays see that hit nothing."""
        return Backdrop(self.light.lookup) if self.backdrop is None else self.backdrop


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
    """The work at one tile, with all that is known of it so far.

    A tile is taken on by ``advance``, or, where there is a budget, by ``look`` and ``go_to``.
    """

    rect: Rect

    def advance(self, samples: int) -> bool:
        """Take every pixel on until it is done or has ``samples``: whether all are done."""

    def look(self, typical: float, most: int) -> None:
        """Take each pixel's first samples for a budget: at most ``most``, T = ``typical``."""

    def demand(self, typical: float) -> Demand:
        """What the pixels ask of a budget, of which they would get T = ``typical``."""

    def go_to(self, counts: np.ndarray, typical: float) -> None:
        """Take every pixel of the demand on to its count, int32: of planned_counts for T."""

    def develop(self) -> Tile:
        """The layers as they are now."""

    def rest(self) -> None:
        """Let go of all that the next ``advance`` or ``develop`` can make anew."""

    def counts(self) -> TileCounts:
        """What it has cost."""


def whole_cells(rect: Rect, camera: Camera) -> Rect:
    """The cells of neighbours.py that a tile has a part in, as far as they are in the frame."""
    x0, y0 = rect.x // CELL_PX * CELL_PX, rect.y // CELL_PX * CELL_PX
    x1, y1 = (-(-end // CELL_PX) * CELL_PX for end in (rect.x + rect.width, rect.y + rect.height))
    return Rect(x0, y0, min(x1, camera.width) - x0, min(y1, camera.height) - y0)


def trace_points(
    job: Job,
    rays: CameraRays | SurfaceRays,
    dither=None,
    tints=None,
    passed=None,
    crossed=None,
    solid=None,
) -> ShadingPoints:
    """The points that camera rays see; ``pixel`` is the row of the ray.

    dither, tints, passed, crossed, solid: of cutouts.points_through
    """
    origins, directions, reach = rays[:3]
    looks = _that_look(origins, directions)
    hits = rays.hits if isinstance(rays, SurfaceRays) else None
    most = job.settings.transparent_max_bounces
    own = looks[0], looks[1], reach, dither, most, tints, hits, passed, crossed, solid
    return points_through(job.scene, job.accel, *own)


def trace_whole(
    job: Job, rays: CameraRays | SurfaceRays, points: ShadingPoints, crossed: list | None
) -> WholeSurfaces | None:
    """What data passes have in place of points, where rays have ended. crossed: None = nothing"""
    if not crossed:
        return None

    def look(which, crossed):
        some = CameraRays(*(column[which] for column in rays[:3]))
        return trace_points(job, some, crossed=crossed, solid=job.scene.asked.solid)

    return whole_surfaces(job.scene, points, crossed, len(rays.origins), look)


def asked_crossed(scene: Scene) -> list | None:
    """Room for what rays cross, of a scene whose passes ask for it."""
    asked = scene.asked
    asks = asked.solid is not None or asked.mist is not None or asked.occlusion_distance > 0.0
    return [] if asks and cut_materials(scene) is not None else None


def _that_look(origins, directions):
    """Rays with a direction for each: Embree is not to be asked for one of length 0."""
    blind = ~any_in_row(directions)
    if not blind.any():
        return origins, directions
    return origins, np.where(blind[:, None], np.float32([0.0, 0.0, 1.0]), directions)


def add_samples(
    job: Job,
    seen: SeenPoints,
    rect: Rect,
    sums: PixelSums,
    bounds: np.ndarray,
    rule: Rule,
    guides: Guides,
    first: int | np.ndarray = 0,
) -> int:
    """Take the points on, a block after another, as the stop rule says: shadow rays traced.

    rect: the tile whose pixels ``points.pixel`` counts; sums: of the points, added to; bounds:
    int32, where blocks begin, whole cells for rule PERCEPTUAL; guides: of the blocks, added to, or
    of none; first: samples before those of sums, of each point or of all
    """
    if not len(seen.rows):
        return 0
    places = Places(*frame_places(rect, seen.points.pixel), seen.rows)
    sequence = pixel_sequence(
        job.sequence, seen.points.pixel, rect[:3], job.settings.seed, job.settings.point_set
    )
    sums.count[:] += first
    by_rays = job.settings.estimator == "PAPER" or job.accel.by_rays
    work = _add_by_rays if by_rays else _add_by_products
    traced = work(job, seen, places, sequence, sums, bounds, rule, guides)
    sums.count[:] -= first
    return traced


def frame_places(rect: Rect, pixel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Column and row in the frame, int32, of pixels of a tile."""
    rows, columns = row_and_column(pixel, np.int32(rect.width))
    return columns + np.int32(rect.x), rows + np.int32(rect.y)


@aside()
def _add_by_products(job, seen, places, sequence, sums, bounds, rule, guides) -> int:
    points, lobes, _ = seen
    small = int(np.diff(bounds).max(initial=0)) <= CELL_POINTS
    room = _room(bool((lobes.kind > DIFFUSE_LOBE).any()), CELL_POINTS if small else BLOCK_POINTS)
    if not compile_apart.wait(job.stop.is_set):
        return 0
    offset, traversal = np.float32(job.accel.offset), job.accel.traversal
    stop = job.stop.memory
    apart = apart_of(job.settings)
    own = points, lobes, apart, job.light, sequence, offset, traversal, rule, sums, room, stop
    return continue_blocks(bounds, guides, places, *own)


def _room(glossy: bool, n: int) -> Room:
    """This thread's scratch: fresh memory for every tile costs as much as a sample a pixel, and of
    a small picture as much as the tiles."""
    rooms = vars(_kept)
    name = f"{'glossy' if glossy else 'matte'} {n}"
    if name not in rooms:
        rooms[name] = new_room(glossy, n)
    return rooms[name]


@aside()
def _add_by_rays(job, seen, places, sequence, sums, bounds, rule, _) -> int:
    """By a sampler that writes its rays: mode PAPER's, or where the Accel wants to see them."""
    traced = 0
    for cells in long_blocks(bounds):
        block = slice(int(bounds[cells.start]), int(bounds[cells.stop]))
        own, part = seen.at(block), PixelSums(*(column[block] for column in sums))
        sampler = make_sampler(
            job,
            own,
            sequence._replace(x=sequence.x[block], y=sequence.y[block]),
            bounds[cells.start : cells.stop + 1] - block.start,
        )
        near = None
        if asks_neighbours(rule):
            where = places.column[block], places.row[block]
            near = find_neighbours(*where, own.rows, own.points.normal)
        rounds = rule._replace(plan=rule.plan[block])
        traced += continue_points(sampler, part, job.accel, rounds, job.stop.is_set, near)
        known = sampler.unoccluded()
        if known is not None:
            part.unoccluded[:] = known * np.maximum(part.count, 1)[:, None]
    return traced


def make_sampler(
    job: Job, seen: SeenPoints, sequence: PixelSequence, bounds: np.ndarray | None = None
) -> Sampler:
    """The sampler of the settings' estimator that writes its rays.

    sequence: of the points; bounds: int32, where their blocks begin; None: they are one
    """
    points, lobes, rows = seen
    if job.settings.estimator == "PAPER":
        return PaperSampler(points, lobes, rows, job.tables, sequence, job.accel.offset)
    own = points, lobes, job.light, sequence, job.accel.offset
    return UnbiasedSampler(*own, apart_of(job.settings), bounds)

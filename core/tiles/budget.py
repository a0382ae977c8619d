"""BUDGET: a render that uses up a mean count of samples, or a time, shared out over the pixels.

Every tile takes a first look; then the samples that are left are planned for all pixels at once
(sample_plan.py), and every tile goes on to its plan. All tiles' sums stay in memory between
(tile_job.TileWork). Tiles are delivered after each of these stages: the picture is there early, and
a cancel loses nothing that was there.

target_samples: the look takes half of the target at the most, and the plan meets the target
whatever the look took. A picture is a function of scene and settings, as with the other rules.

time_limit: the look takes few samples and tells what a sample costs here and now (pace.py). A stage
half-way makes r certain; the last one watches the clock, and gives the tiles that wait more or less
than planned as the machine is free or busy. When the time is up, what is in work ends with what it
has. docs/decisions/0014-budget.md has the figures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..film import Progress, Tile, TileSink
from ..machine.pace import SETUP, Cost, Pace, StageWatch
from ..machine.tile_pool import run_pool
from ..sampling.stop_rule import FIRST_COUNT
from ..stats import RenderStats
from .sample_plan import WHOLE_SHARE, Demand, planned_counts, typical_for_rays
from .tile_job import Job, TileCounts, TileWork

_ENOUGH = 0.03  # of time_limit: what is left then is not worth another stage
_NEAR = 0.01  # the target is met where no more is missing
_MOST_PART = 4.0  # of a tile's plan that it may get where there turns out to be more time
_KEPT_PIXELS = 1 << 19  # up to so many, what rays see is kept from stage to stage
_LOOK_PART, _HALF_PART = 0.35, 0.65  # how far a render with a target is after these stages


class _Result(NamedTuple):
    """What a worker hands over: its tile's number, layers, what it asks now and has cost."""

    index: int
    tile: Tile
    demand: Demand
    counts: TileCounts


class BudgetRender:
    """One render. tiles: all of its work, none of it begun; stats: what it costs, written."""

    def __init__(
        self, job: Job, tiles: list[TileWork], threads: int, sink: TileSink, stats: RenderStats
    ):
        self._settings, self._stop, self._sink = job.settings, job.stop, sink
        self._stats = stats
        self._tiles, self._threads = tiles, threads
        self._demands: list[Demand | None] = [None] * len(tiles)
        self._counts: list[TileCounts | None] = [None] * len(tiles)
        x0, y0, x1, y1 = job.scene.camera.region
        # Where there are copies, what a tile has seen of them is gone when its thread goes on.
        few = (x1 - x0) * (y1 - y0) <= _KEPT_PIXELS
        self._keeps = few and job.scene.copies is None
        self._centered = job.settings.pixel_filter == "CENTER"
        self._timed = job.settings.time_limit > 0.0
        self._pace, self._cancelled = Pace(job.settings.time_limit), False

    def run(self) -> None:
        """Render, deliver the tiles, write what it cost. Raises what a worker raises."""
        self._pace.begin()
        self._look()
        looked = self._pace.elapsed()
        with self._pace.alarm(self._stop):
            if (self._timed or not self._centered) and not self._cancelled:
                self._half_way()
            # Again where time is left, or a filter has found more objects than the plan knew of.
            while not self._is_spent() and self._go(self._goal(), 1.0):
                pass
        self._tell(1.0)
        self._write(looked)

    def _look(self) -> None:
        """The first samples of every tile."""
        target, most = self._settings.target_samples, self._settings.max_samples
        if target:
            most = min(most, max(target // 2, 1))
        if self._timed and self._centered:
            most = min(most, FIRST_COUNT)

        def work(index):
            late = self._timed and self._pace.elapsed() > 0.5 * self._pace.limit
            self._tiles[index].look(float(most), 1 if late else most)
            return self._finish(index, float(most))

        self._stage(work, range(len(self._tiles)), lambda done: _LOOK_PART * done)
        self._pace.add(sum(_cost(d, d.taken, 0).total for d in self._demands if d is not None))

    def _half_way(self) -> None:
        """On to half of the goal, where that is far: what it shows makes the plan more certain."""
        goal, before = self._goal(), list(self._demands)
        if goal < 4.0 * self._rays():
            return
        if not self._centered:
            self._go(0.5 * goal, _HALF_PART)
            return
        typical = 0.5 * goal / max(self._shaded(), 1)
        most = min(int(typical), self._settings.max_samples)

        def work(index):
            self._tiles[index].look(typical, most)
            return self._finish(index, typical)

        self._stage(work, range(len(self._tiles)), lambda done: _HALF_PART * done)
        pairs = zip(self._demands, before, strict=True)
        self._pace.add(sum(_cost(now, now.taken, old.taken).total for now, old in pairs))

    def _go(self, rays: float, part: float) -> bool:
        """Plan for ``rays`` shadow rays in all and take every tile there: whether any had to go.

        part: how far the render is then
        """
        typical, plans = self._plan(rays)
        if self._cancelled or not plans:
            return False
        demands = list(self._demands)
        costs = {k: _cost(demands[k], plan, demands[k].taken) for k, plan in plans.items()}
        most = 1.0 if rays >= self._target_rays() else _MOST_PART
        watch = StageWatch(self._pace, costs, most, watches=self._timed and part == 1.0)

        def work(index):
            plan = _part_of(plans[index], demands[index], watch.begin(index), self._settings)
            self._tiles[index].go_to(plan, typical)
            result = self._finish(index, typical)
            watch.end(index)
            return result

        self._stage(work, list(plans), lambda _: self._share_done(watch, part))
        now = self._demands
        self._pace.add(sum(_cost(now[k], now[k].taken, demands[k].taken).total for k in plans))
        return True

    def _plan(self, rays: float) -> tuple[float, dict[int, np.ndarray]]:
        """(T, counts of the tiles that have to go on for it, by their number)."""
        typical, plans, most = [1.0], {}, self._settings.max_samples

        def think(_):
            typical[0] = typical_for_rays(self._demands, rays, most)
            for k, demand in enumerate(self._demands):
                counts = planned_counts(demand, typical[0], most)
                if (counts > demand.taken).any():
                    plans[k] = counts

        self._run([None], think, lambda _: None)
        return typical[0], plans

    def _stage(self, work, indices, fraction) -> None:
        """work(index) -> _Result for tiles, in the workers; their tiles to the sink."""
        done = 0

        def take(result):
            nonlocal done
            done += 1
            self._demands[result.index], self._counts[result.index] = result.demand, result.counts
            with self._stats.phase("output"):
                self._sink.write_tile(result.tile)
            self._tell(fraction(done / len(indices)))

        self._run(indices, work, take)

    def _run(self, items, work, take) -> None:
        cancelled = self._sink.cancelled
        if run_pool(items, self._threads, work, take, cancelled, self._stop):
            self._cancelled = True

    def _finish(self, index: int, typical: float) -> _Result:
        tile = self._tiles[index]
        result = _Result(index, tile.develop(), tile.demand(typical), tile.counts())
        if not self._keeps:
            tile.rest()
        return result

    def _goal(self) -> float:
        """Shadow rays in all that the target and the time allow."""
        if not self._timed:
            return self._target_rays()
        fixed = sum(_cost(d, d.taken, d.taken).fixed for d in self._demands)
        room = max(self._pace.affordable() - fixed, 0.0)
        if not self._centered:
            room /= 1.0 + SETUP / self._demands[0].grain
        return min(self._target_rays(), self._rays() + room)

    def _target_rays(self) -> float:
        target = self._settings.target_samples
        return float(target * self._shaded()) if target else np.inf

    def _shaded(self) -> int:
        return sum(demand.shaded for demand in self._demands)

    def _rays(self) -> float:
        return sum(counts.samples for counts in self._counts if counts is not None)

    def _is_spent(self) -> bool:
        """Whether nothing, or hardly anything, is left of the budget; or a cancel."""
        met = self._rays() >= (1.0 - _NEAR) * self._target_rays()
        late = self._timed and self._pace.left() < _ENOUGH * self._pace.limit
        return self._cancelled or met or late

    def _share_done(self, watch: StageWatch, part: float) -> float:
        begun = _HALF_PART if part == 1.0 and not self._centered else _LOOK_PART
        return begun + (part - begun) * watch.fraction()

    def _tell(self, fraction: float) -> None:
        if self._timed and fraction < 1.0:
            fraction = max(1.0 - self._pace.left() / self._pace.limit, 0.001)
        n, rays = len(self._tiles), int(self._rays())
        done = n if fraction == 1.0 else min(int(fraction * n), n - 1)
        self._sink.progress(Progress("sampling", fraction, done, n, rays))

    def _write(self, looked: float) -> None:
        stats = self._stats
        stats.cancelled = self._cancelled
        for counts in self._counts:
            if counts is not None:
                stats.add_tile(counts)
        if self._cancelled or not stats.shaded_pixels:
            return
        limit, target = self._settings.time_limit, self._settings.target_samples
        if self._timed and self._pace.left() < 2.0 * _ENOUGH * limit:
            stats.ended_by = "time_limit"
        elif target and stats.samples_mean > (1.0 - _ENOUGH) * target:
            stats.ended_by = "target_samples"
        else:
            stats.ended_by = "max_samples"
            stats.warnings.append(self._cut_short(stats.samples_mean))
        if self._timed and looked > limit:
            text = f"time_limit: {limit:g} s is too short; a first look took {looked:.2f} s"
            stats.warnings.append(text)

    def _cut_short(self, mean: float) -> str:
        most, target, limit = (
            getattr(self._settings, name)
            for name in ("max_samples", "target_samples", "time_limit")
        )
        budget = f"target_samples {target}" if target else f"time_limit {limit:g} s"
        return (
            f"max_samples: no pixel may take more than {most}, so that {budget} was not used up "
            f"(mean count {mean:.1f})"
        )


def _cost(demand: Demand, counts: np.ndarray, taken) -> Cost:
    """Of taking a tile from ``taken`` samples to ``counts``; both int32 (n,)."""
    more = counts - taken
    rays = float((more * demand.share.astype(np.int64)).sum()) / WHOLE_SHARE
    if demand.grain == 0:  # one shading point for all of a pixel's samples
        return Cost(SETUP * len(counts), rays)
    passes = float(more.sum()) / demand.grain
    return Cost(0.0, rays * (1.0 + SETUP / demand.grain) + passes)


def _part_of(plan, demand: Demand, part: float, settings) -> np.ndarray:
    """Counts with that part of what a plan adds."""
    if abs(part - 1.0) < 0.02:
        return plan
    grain = max(demand.grain, 1)
    steps = np.floor(part * (plan - demand.taken) / grain + demand.dither)
    counts = demand.taken + steps.astype(np.int32) * np.int32(grain)
    return np.minimum(counts, np.maximum(settings.max_samples, demand.taken))

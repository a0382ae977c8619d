"""Part "rays": CPU of a whole render over that of its shadow rays alone.

The rays are recorded in one render and replayed in the same order and the same batches: through
embreex as it is (EmbreeScene.run), and through Accel.occluded(), the product's own way to Embree.
One thread; render and replays by turns, so that all see the same machine.
"""

from __future__ import annotations

import contextlib
import copy
import time
from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh as EmbreeMesh
from embreex.rtcore_scene import EmbreeScene
from run_iwis import IwisRun

from iwis.core.embree.accel import Accel
from iwis.core.render_cache import RenderCache
from iwis.core.tiles import center_tile

REPEATS = 5


class Recorded(NamedTuple):
    """One batch of shadow rays, float32 (n, 3)."""

    origins: np.ndarray
    directions: np.ndarray


class RecordingAccel(Accel):
    """An Accel that keeps what it is asked."""

    by_rays = True

    def __init__(self, mesh, *more, **named):
        self.shadow: list[Recorded] = []
        self.primary: list[Recorded] = []
        super().__init__(mesh, *more, **named)

    def intersect(self, origins, directions, *more, **named):
        """See Accel."""
        self.primary.append(Recorded(origins.copy(), directions.copy()))
        return super().intersect(origins, directions, *more, **named)

    def occluded(self, origins, directions, *more, **named):
        """See Accel."""
        self.shadow.append(Recorded(origins.copy(), directions.copy()))
        return super().occluded(origins, directions, *more, **named)


class _RecordingCache(RenderCache):
    """A cache whose Accel records."""

    def __init__(self):
        super().__init__()
        self.recorder = None

    def accel(self, mesh, *more, **named):
        """The recording Accel of a mesh."""
        if self.recorder is None:
            self.recorder = RecordingAccel(mesh, *more, **named)
        return self.recorder


def record(run: IwisRun, **changes) -> RecordingAccel:
    """The rays of a render with changed settings, on one thread.

    Nothing is learnt from them (guide.py), for rays on their way to Python teach nothing.
    Raises RuntimeError if the render has traced others: then this program is out of date.
    """
    recording = IwisRun(run.scene, run.base)
    recording.cache = _RecordingCache()
    with without_guides():
        _, stats = recording.render(threads=1, **changes)
    recorder = recording.cache.recorder
    seen = sum(len(batch.origins) for batch in recorder.shadow)
    if seen != stats.shadow_rays:
        raise RuntimeError(f"{stats.shadow_rays} shadow rays, but {seen} through Accel.occluded()")
    return recorder


@contextlib.contextmanager
def without_guides():
    """Renders learn nothing, so that they trace the rays that were recorded."""
    before = center_tile.new_guides
    center_tile.new_guides = lambda n: before(0)
    try:
        yield
    finally:
        center_tile.new_guides = before


def replay(trace, batches: list[Recorded]) -> float:
    """CPU seconds of trace(origins, directions) for all batches."""
    start = time.process_time()
    for batch in batches:
        if len(batch.origins):
            trace(batch.origins, batch.directions)
    return time.process_time() - start


def measure(bench) -> dict:
    """A row of figures for each of Effort.ray_samples, for JSON."""
    return {"counts": [_of_count(bench, count) for count in bench.effort.ray_samples]}


def _of_count(bench, count: int) -> dict:
    """Seconds of render, shadow rays and camera rays at IWIS' fixed count."""
    changes = {"stop_rule": "FIXED", "max_samples": count}
    recorder = record(bench.run, **changes)
    ways = _ways(bench.run, recorder)
    for trace, batches in ways.values():  # commits the scene, loads the kernels
        replay(trace, batches[:1])
    bench.run.render(threads=1, **changes)
    rows = []
    for _ in range(REPEATS):
        with without_guides():
            _, stats = bench.run.render(threads=1, **changes)
        times = {name: replay(*way) for name, way in ways.items()}
        rows.append({"total": stats.cpu_seconds["sampling"]} | times)
    found = {name: float(np.median([row[name] for row in rows])) for name in rows[0]}
    found |= {
        name: float(np.median([row["total"] / row[shadow] for row in rows]))
        for name, shadow in (("ratio", "shadow"), ("ratio_own", "shadow_own"))
    }
    found["shadow_rays"] = sum(len(batch.origins) for batch in recorder.shadow)
    return found | {"samples": count, "rows": rows}


def _ways(run: IwisRun, recorder: RecordingAccel) -> dict:
    """Name -> what traces the rays of a batch, and the batches."""
    mesh = run.scene.mesh
    embree = EmbreeScene()
    EmbreeMesh(embree, mesh.vertices, mesh.triangles)
    accel = run.cache.accel(mesh)
    once = copy.copy(accel)  # samples are asked once, but for one in a run (trace_lanes.py)
    once.traversal = accel.traversal._replace(aside=0.0)
    return {
        "shadow": (lambda o, d: embree.run(o, d, query="OCCLUDED"), recorder.shadow),
        "shadow_own": (once.occluded, recorder.shadow),
        "primary": (accel.intersect, recorder.primary),
    }

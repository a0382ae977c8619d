"""Part "rays": CPU of a whole render over that of its shadow rays alone.

The rays are recorded in one render and replayed through embreex as it is (EmbreeScene.run), in the
same order and the same batches. One thread; render and replay by turns, so that both see the same
machine.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh as EmbreeMesh
from embreex.rtcore_scene import EmbreeScene
from run_iwis import IwisRun

from iwis.core.accel import Accel
from iwis.core.render_cache import RenderCache

REPEATS = 5


class Recorded(NamedTuple):
    """One batch of shadow rays, float32 (n, 3)."""

    origins: np.ndarray
    directions: np.ndarray


class RecordingAccel(Accel):
    """An Accel that keeps what it is asked."""

    def __init__(self, mesh):
        self.shadow: list[Recorded] = []
        self.primary: list[Recorded] = []
        super().__init__(mesh)
        self.shadow.clear()  # the ray that builds the hierarchy

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

    def accel(self, mesh):
        """The recording Accel of a mesh."""
        if self.recorder is None:
            self.recorder = RecordingAccel(mesh)
        return self.recorder


def record(run: IwisRun, **changes) -> RecordingAccel:
    """The rays of a render with changed settings, on one thread.

    Raises RuntimeError if the render has traced others: then this program is out of date.
    """
    recording = IwisRun(run.scene, run.base)
    recording.cache = _RecordingCache()
    _, stats = recording.render(threads=1, **changes)
    recorder = recording.cache.recorder
    seen = sum(len(batch.origins) for batch in recorder.shadow)
    if seen != stats.shadow_rays:
        raise RuntimeError(f"{stats.shadow_rays} shadow rays, but {seen} through Accel.occluded()")
    return recorder


def replay(scene: EmbreeScene, batches: list[Recorded], query: str) -> float:
    """CPU seconds that embreex alone takes for the rays."""
    start = time.process_time()
    for batch in batches:
        if len(batch.origins):
            scene.run(batch.origins, batch.directions, query=query, output=query == "INTERSECT")
    return time.process_time() - start


def measure(bench) -> dict:
    """Seconds of render, shadow rays and primary rays for IWIS' fixed count, for JSON."""
    changes = {"stop_rule": "FIXED", "max_samples": bench.effort.ray_samples}
    recorder = record(bench.run, **changes)
    mesh = bench.run.scene.mesh
    embree = EmbreeScene()
    EmbreeMesh(embree, mesh.vertices, mesh.triangles)
    replay(embree, recorder.shadow[:1], "OCCLUDED")
    bench.run.render(threads=1, **changes)
    rows = []
    for _ in range(REPEATS):
        _, stats = bench.run.render(threads=1, **changes)
        shadow = replay(embree, recorder.shadow, "OCCLUDED")
        primary = replay(embree, recorder.primary, "INTERSECT")
        rows.append((stats.cpu_seconds["sampling"], shadow, primary))
    total, shadow, primary = np.median(rows, axis=0)
    ratios = [row[0] / row[1] for row in rows]
    return {
        "samples": bench.effort.ray_samples,
        "shadow_rays": sum(len(batch.origins) for batch in recorder.shadow),
        "primary_rays": sum(len(batch.origins) for batch in recorder.primary),
        "total": float(total),
        "shadow": float(shadow),
        "primary": float(primary),
        "ratio": float(np.median(ratios)),
        "ratios": ratios,
    }

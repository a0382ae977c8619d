"""Part "scaling": cost against pixels, samples, triangles and the HDRI's size.

    python benchmarks/bench_scaling.py FOLDER [--quick]      all: writes FOLDER/scaling.json
    python benchmarks/bench_scaling.py --case CASE VALUE      one, as JSON: a process of its own

Each case runs in a process of its own, for its memory is measured. One thread, fixed count.
"""

from __future__ import annotations

import dataclasses
import gc
import os
import time
from pathlib import Path

import ball
import numpy as np
from apart import in_own_process, run_cases
from configurations import base_settings

from iwis.core.film import Film
from iwis.core.render import RenderCache, render

SIDE, SAMPLES, TRIANGLES, WIDTH = 256, 32, 100_000, 512
REPEATS = 3
FULL = {
    "pixels": (64, 128, 256, 512),
    "samples": (4, 16, 64, 256),
    "triangles": (10_000, 100_000, 1_000_000, 10_000_000),
    "hdri": (512, 1024, 2048, 4096, 8192),
}
QUICK = {
    "pixels": (32, 64),
    "samples": (4, 16),
    "triangles": (10_000, 100_000),
    "hdri": (512, 1024),
}


def main() -> None:
    """One case or all."""
    run_cases("Measure how the cost grows, with one thread.", CASES, "scaling", _all)


def _all(quick: bool) -> dict:
    return {
        name: [{"value": value} | in_own_process(__file__, name, value) for value in values]
        for name, values in (QUICK if quick else FULL).items()
    }


def of_pixels(side: int) -> dict:
    """Sampling of a picture of side x side."""
    scene = ball.scene(ball.ball(TRIANGLES), ball.environment(WIDTH), side)
    return _each(_sampling(scene, SAMPLES), side * side * SAMPLES)


def of_samples(count: int) -> dict:
    """Sampling at a count."""
    scene = ball.scene(ball.ball(TRIANGLES), ball.environment(WIDTH), SIDE // 2)
    return _each(_sampling(scene, count), (SIDE // 2) ** 2 * count)


def of_triangles(count: int) -> dict:
    """Memory of the table and of the BVH, seconds of the BVH, sampling."""
    _warm()
    before = resident_bytes()
    mesh = ball.ball(count)
    gc.collect()
    table = sum(getattr(mesh, name).nbytes for name in mesh.__slots__)
    with_mesh = resident_bytes()
    cache, cpu, wall = RenderCache(), time.process_time(), time.perf_counter()
    cache.accel(mesh)
    found = {
        "triangles": len(mesh.triangles),
        "table_bytes": table,
        "bvh_bytes": resident_bytes() - with_mesh,
        "resident_bytes": resident_bytes() - before,
        "bvh_cpu": time.process_time() - cpu,
        "bvh_wall": time.perf_counter() - wall,
    }
    scene = ball.scene(mesh, ball.environment(WIDTH), SIDE)
    return found | _sampling(scene, SAMPLES, cache)


def of_hdri(width: int) -> dict:
    """Preparing an HDRI that has not been seen, then again, and sampling.

    prepare: CPU and wall seconds; peak_bytes: the most memory of it, beside the image's own
    """
    _warm()
    seed = time.time_ns() % (1 << 31)  # so that nothing of it is kept from an earlier run
    light = ball.environment(width, seed)
    scene = ball.scene(ball.ball(TRIANGLES), light, SIDE)
    cache = RenderCache()
    cache.accel(scene.mesh)
    gc.collect()
    before = resident_bytes()
    Path("/proc/self/clear_refs").write_text("5")  # forget the peak so far
    stats = _render(scene, cache, 1)
    found = {
        "prepare_cpu": stats.cpu_seconds["tables"],
        "prepare_wall": stats.seconds["tables"],
        "image_bytes": light.radiance.nbytes,
        "peak_bytes": peak_bytes() - before,
    }
    again = _render(ball.scene(scene.mesh, ball.environment(width, seed), SIDE), RenderCache(), 1)
    found["again_cpu"] = again.cpu_seconds["tables"]
    return found | _sampling(scene, SAMPLES, cache)


CASES = {
    "pixels": of_pixels,
    "samples": of_samples,
    "triangles": of_triangles,
    "hdri": of_hdri,
}


def _each(found: dict, samples: int) -> dict:
    """With the seconds of one sample, the whole picture counted."""
    return found | {"each": found["cpu"] / samples}


def _sampling(scene, count: int, cache: RenderCache | None = None) -> dict:
    cache = cache or RenderCache()
    _render(scene, cache, count)
    cpu = [_render(scene, cache, count).cpu_seconds["sampling"] for _ in range(REPEATS)]
    return {"cpu": float(np.median(cpu))}


def _render(scene, cache, count):
    settings = dataclasses.replace(base_settings(1), stop_rule="FIXED", max_samples=count)
    return render(scene, settings, Film(scene.camera.region), cache)


def _warm() -> None:
    """Load all kernels and libraries, so that their memory and time are not counted."""
    scene = ball.scene(ball.ball(1000), ball.environment(WIDTH), 32)
    _render(scene, RenderCache(), 4)
    gc.collect()


def resident_bytes() -> int:
    """Of this process now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def peak_bytes() -> int:
    """The most that was resident since the peak was forgotten."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    raise OSError("/proc/self/status has no VmHWM")


if __name__ == "__main__":
    main()

"""What a render cost: counts, seconds and CPU seconds of each phase, peak memory."""

from __future__ import annotations

import contextlib
import sys
import time
from dataclasses import dataclass, field

PHASES = ("export", "tables", "bvh", "sampling", "denoising", "output")


@dataclass(slots=True)
class RenderStats:
    """Filled in by whoever does a phase; read by the command line, the panel and benchmarks.

    ended_by: what ended a BUDGET: target_samples, time_limit or max_samples; empty: another rule
    tables: what wavelet tables were built, with size and time; none where all were kept
    seconds, cpu_seconds: phase -> wall and user + system time of the process
    """

    width: int = 0
    height: int = 0
    shaded_pixels: int = 0
    samples_total: int = 0
    samples_max: int = 0
    primary_rays: int = 0
    shadow_rays: int = 0
    triangles: int = 0
    cancelled: bool = False
    ended_by: str = ""
    warnings: list[str] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PHASES, 0.0))
    cpu_seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PHASES, 0.0))

    def add_tile(self, counts) -> None:
        """Add what a tile has cost. counts: tile_job.TileCounts"""
        self.shaded_pixels += counts.shaded
        self.samples_total += counts.samples
        self.samples_max = max(self.samples_max, counts.samples_max)
        self.shadow_rays += counts.shadow_rays
        self.primary_rays += counts.primary_rays

    @property
    def samples_mean(self) -> float:
        """Shadow rays a shaded pixel."""
        return self.samples_total / self.shaded_pixels if self.shaded_pixels else 0.0

    @contextlib.contextmanager
    def phase(self, name: str):
        """Add the time spent inside the block to one of PHASES."""
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - wall
            self.cpu_seconds[name] += time.process_time() - cpu

    def to_dict(self) -> dict:
        """The documented STATS.json of the command line."""
        return {
            "width": self.width,
            "height": self.height,
            "shaded_pixels": self.shaded_pixels,
            "triangles": self.triangles,
            "samples": {
                "total": self.samples_total,
                "mean": self.samples_mean,
                "max": self.samples_max,
            },
            "shadow_rays": self.shadow_rays,
            "primary_rays": self.primary_rays,
            "seconds": dict(self.seconds),
            "cpu_seconds": dict(self.cpu_seconds),
            "peak_memory_bytes": peak_memory_bytes(),
            "cancelled": self.cancelled,
            "ended_by": self.ended_by,
            "warnings": list(self.warnings),
            "tables": list(self.tables),
        }


def peak_memory_bytes() -> int:
    """The largest resident size that this process has had; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024

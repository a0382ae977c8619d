"""Part "threads": wall-clock seconds of sampling with one thread and with more, by turns."""

from __future__ import annotations

import numpy as np
from machine import load

REPEATS = 5


def measure(bench) -> dict:
    """Seconds with 1 and with bench.threads threads, for JSON."""
    changes = {"stop_rule": "FIXED", "max_samples": bench.effort.thread_samples}
    counts, before = (1, max(2, bench.threads)), load()
    bench.run.render(**changes)
    rows = []
    for _ in range(REPEATS):
        found = [bench.run.render(threads=threads, **changes)[1] for threads in counts]
        rows.append([(s.seconds["sampling"], s.cpu_seconds["sampling"]) for s in found])
    wall, cpu = np.moveaxis(np.array(rows), -1, 0)  # (repeats, counts)
    return {
        "samples": bench.effort.thread_samples,
        "threads": list(counts),
        "wall": np.median(wall, axis=0).tolist(),
        "cpu": np.median(cpu, axis=0).tolist(),
        "speedup": float(np.median(wall[:, 0] / wall[:, 1])),
        "load": before,
    }

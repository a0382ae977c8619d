"""Part "startup": from the start of the process to export and first tile; the first compilation.

    python benchmarks/bench_startup.py FOLDER [--quick]       writes FOLDER/startup.json

Each render is a process of its own (startup_probe.py) on the diffuse statue: first with an empty
cache folder, then with what that left, then over all choices of settings.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scenes
from configurations import SCENES
from machine import load

PROBE = Path(__file__).resolve().parent / "startup_probe.py"
REPEATS = 3


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description="Measure start-up.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--pictures", type=Path, help="not used")
    options = parser.parse_args()
    start = time.perf_counter()
    given = SCENES["statue_diffuse"].quick if options.quick else SCENES["statue_diffuse"].full
    with tempfile.TemporaryDirectory(prefix="iwis-startup-") as folder:
        file = scenes.save("statue_diffuse", Path(folder), **given)
        cache = Path(folder) / "cache"
        threads = str(options.threads)
        cold = probe(file, cache, threads)
        warm = [probe(file, cache, threads) for _ in range(REPEATS)]
        before = kernels(cache)
        probe(file, cache, threads, "sweep")
        compiled = kernels(cache) - before
    found = {
        "cold": cold,
        "warm": {name: float(np.median([marks[name] for marks in warm])) for name in cold},
        "kernels": len(before),
        "compiled_by_settings": sorted({name.split("-")[0] for name in compiled}),
        "load": load(),
        "seconds": time.perf_counter() - start,
    }
    (options.folder / "startup.json").write_text(json.dumps(found, indent=1))


def probe(file: Path, cache: Path, *more: str) -> dict[str, float]:
    """What a process of its own says of itself: seconds since its start."""
    environment = os.environ | {"IWIS_CACHE_DIR": str(cache)}
    command = [sys.executable, str(PROBE), str(time.time()), str(file), *more]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


def kernels(cache: Path) -> set[str]:
    """Names of the machine code files that are kept."""
    return {path.name for path in cache.rglob("*.nbc")}


if __name__ == "__main__":
    main()

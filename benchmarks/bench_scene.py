"""Parts of the suite that need one scene, in a process of its own: suite.py runs it.

    python benchmarks/bench_scene.py SCENE PART[,PART...] FOLDER [--quick] ...

SCENE: a name of scenes.py or a .blend file. Writes FOLDER/SCENE.PART.json; pictures to --pictures.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import traceback
from pathlib import Path

import bpy
import part_error
import part_pictures
import part_rays
import part_threads
import scenes
from configurations import FULL, QUICK, SCENES, base_settings
from part_error import Bench
from run_cycles import quiet, use_cycles
from run_iwis import IwisRun, export_open_file

PARTS = {
    "error": part_error.measure,
    "rays": part_rays.measure,
    "threads": part_threads.measure,
    "pictures": part_pictures.measure,
}


def main() -> int:
    """Measure and write; how many parts failed."""
    options = parse()
    scene = open_scene(options.scene, options.quick)
    use_cycles(scene, options.threads)
    run = IwisRun(export_open_file(scene).scene, base_settings(options.threads))
    bench = Bench(
        name=Path(options.scene).stem,
        scene=scene,
        run=run,
        effort=QUICK if options.quick else FULL,
        threads=options.threads,
        folder=options.folder,
        pictures=options.pictures,
        mitsuba=options.mitsuba,
        renew=options.renew,
    )
    options.folder.mkdir(parents=True, exist_ok=True)
    return sum(not measure(bench, part) for part in options.parts)


def measure(bench: Bench, part: str) -> bool:
    """Write what a part finds; whether it went well. One that fails does not end the others."""
    start = time.perf_counter()
    try:
        found = PARTS[part](bench)
    except Exception:
        traceback.print_exc()
        return False
    found["seconds"] = time.perf_counter() - start
    (bench.folder / f"{bench.name}.{part}.json").write_text(json.dumps(found, indent=1))
    print(f"{bench.name} {part}: {found['seconds']:.0f} s", flush=True)
    return True


def parse():
    parser = argparse.ArgumentParser(description="Measure on one scene.")
    parser.add_argument("scene")
    parser.add_argument("parts", type=lambda text: text.split(","))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--renew", action="store_true")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--mitsuba", type=Path)
    parser.add_argument("--pictures", type=Path, required=True)
    return parser.parse_args()


def open_scene(name: str, quick: bool):
    """Build a scene of scenes.py, or open a file."""
    if name in scenes.SCENES:
        return scenes.SCENES[name](**(SCENES[name].quick if quick else SCENES[name].full))
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(Path(name).resolve()), load_ui=False)
    bpy.context.scene.render.use_border = False
    return bpy.context.scene


if __name__ == "__main__":
    sys.exit(main())

"""A render by the real engine in a process of its own; says when what happened, as JSON.

    python benchmarks/startup_probe.py STARTED FILE.blend THREADS [sweep]

STARTED: time.time() when the process was started. With "sweep" all choices of settings are rendered
after one another, to see whether one of them compiles anything.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path


def main() -> None:
    """Render once for each set of settings, print when it came to what."""
    started, file, threads = float(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    import bpy
    from run_cycles import quiet

    import iwis
    from iwis.core.settings import LIMITS, PIXEL_FILTERS, STOP_RULES
    from iwis.iwis_addon import session

    marks = {"imports": time.time() - started}

    def mark(owner, name, before=None, after=None):
        """Have owner.name tell the first times that it starts and ends."""
        original = getattr(owner, name)

        def wrapped(*arguments, **named):
            if before:
                marks.setdefault(before, time.time() - started)
            result = original(*arguments, **named)
            if after:
                marks.setdefault(after, time.time() - started)
            return result

        setattr(owner, name, wrapped)

    mark(session, "export_scene", before="export_starts", after="export_ends")
    mark(session.BlenderSink, "write_tile", after="first_tile")
    iwis.register()
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(Path(file).resolve()), load_ui=False)
    scene = bpy.context.scene
    scene.render.engine = "IWIS"
    marks["file_open"] = time.time() - started
    scene.iwis.threads = threads
    choices = [{}]
    if "sweep" in sys.argv[4:]:
        choices = [{"stop_rule": rule} for rule in STOP_RULES]
        choices += [{"pixel_filter": kind} for kind in PIXEL_FILTERS]
        choices += [{"batch_size": LIMITS["batch_size"][0]}, {"max_samples": 7}, {"seed": 3}]
        choices += [{"tile_px": LIMITS["tile_px"][0]}, {"decorrelation": "NONE"}]
    with tempfile.TemporaryDirectory() as folder, quiet():
        for k, choice in enumerate(choices):
            for name, value in choice.items():
                setattr(scene.iwis, name, value)
            scene.render.filepath = str(Path(folder) / f"{k}.png")
            bpy.ops.render.render(write_still=True)
            marks.setdefault("rendered", time.time() - started)
    marks["cpu"] = time.process_time()
    scene.render.engine = "CYCLES"
    iwis.unregister()
    print(json.dumps(marks))


if __name__ == "__main__":
    main()

"""Random scenes of some seeds: make random-scenes, or with ARGS="FIRST COUNT" others.

With --glow before them: of scenes without noise, some ten a second, that show values of nodes.
Seeds are rendered in a process of their own, some at a time: one that ends it is told as a crash.
Pictures of seeds that differ are written into a folder, if one is given as third argument.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

import numpy as np

COUNT = 100
_DONE, GLOW = "seed ", "--glow"


def main(words) -> int:
    """Run seeds in processes; returns 0 if none is told of."""
    kind, words = words[:1] if GLOW in words[:1] else [], [w for w in words if w != GLOW]
    first = int(words[0]) if words else 0
    last = first + (int(words[1]) if len(words) > 1 else COUNT)
    bad, seed = 0, first
    while seed < last:
        command = [sys.executable, "-m", "random_scenes.run", "--inside", str(seed), str(last)]
        command += [*words[2:3], *kind]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
            for line in child.stdout:
                if line.startswith(_DONE):
                    seed += 1
                    bad += " ok " not in line
                    sys.stdout.write(line)
                    sys.stdout.flush()
        if seed < last:
            sys.stdout.write(f"{_DONE}{seed}: CRASH, exit code {child.returncode}\n")
            bad, seed = bad + 1, seed + 1
    sys.stdout.write(f"{last - first} seeds, {bad} to look at\n")
    return int(bad > 0)


def _inside(first: int, last: int, pictures: Path | None, glows: bool) -> None:
    """Render seeds in this process, a line for each."""
    import iwis

    iwis.register()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last):
            sys.stdout.write(f"\n{_DONE}{seed}: {_line(seed, Path(folder), pictures, glows)}\n")
            sys.stdout.flush()
    os._exit(0)  # Blender 4.5 may hang as it ends


def _line(seed: int, folder: Path, pictures: Path | None, glows: bool) -> str:
    from . import beside, build, glowing

    how = (glowing.build, glowing.compare) if glows else (build.build, beside.compare)
    told = []
    try:
        scene, told = how[0](seed)
        found = how[1](scene, folder)
    except Exception:  # whatever it is, the next seed is rendered
        last = traceback.format_exc().strip().splitlines()
        return f"EXCEPTION {last[-1]} ({last[-3].strip()}) | {', '.join(told)}"
    if pictures is not None and found.differs:
        np.savez(pictures / f"{seed}.npz", ours=found.ours, cycles=found.cycles)
    verdict = "DIFFERS" if found.differs else "WARNS" if found.warnings else "ok"
    return f" {verdict} {found} | {', '.join(told)} {' '.join(found.warnings)}"


if __name__ == "__main__":
    if sys.argv[1:2] == ["--inside"]:
        folders = [word for word in sys.argv[4:] if word != GLOW]
        where = Path(folders[0]) if folders else None
        _inside(int(sys.argv[2]), int(sys.argv[3]), where, GLOW in sys.argv)
    sys.exit(main(sys.argv[1:]))

"""Run cases and write docs/parity.md and its sheet: make parity.

With words: only the cases that have one of them in their name, and nothing is written. As many
processes as processors share the cases.
"""

from __future__ import annotations

import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import bpy

import iwis

from .all_cases import ALL_CASES
from .compare import Result, run_case
from .sheet import draw_sheet
from .why import WHY

_HEAD = """# Parity with Cycles

Made by `make parity`: one small scene for each node and setting, rendered by IWIS and by Cycles
with direct light only. A case shown as light has no noise; of lit ones the noise of both is taken
off. *Difference*: root mean square over the picture, of its mean, without the pixels (at most 1
%) that a ray a hundredth of a pixel aside sees otherwise; *bias*: of the means; *odd*: share of
pixels that differ by over a tenth. A case agrees if difference and bias are at most 1 %. Quoted
is what IWIS warns of.

![IWIS, Cycles, and four times their difference, as grey for none](pictures/parity.jpg)

| case | | difference | bias | odd | why |
|---|---|---|---|---|---|
"""


# Most cases show what they are about by a material that glows in the dark.
_OF_THE_SUITE = ("its emission depends on", "it gives no light")


def main(words) -> int:
    """Run the cases whose name has one of the words, or all. Returns 0 if all agree."""
    say = sys.stdout.write
    names = [
        case.name
        for case in ALL_CASES
        if not words or any(word.lower() in case.name.lower() for word in words)
    ]
    rows, results = [], {}
    workers = min(os.cpu_count(), max(len(names), 1))
    fresh = get_context("spawn")  # Blender cannot be forked
    own = str(Path(bpy.__file__).parents[2])  # where a worker would find a part of bpy alone
    sys.path[:] = [folder for folder in sys.path if not folder.startswith(own)]
    with ProcessPoolExecutor(workers, fresh, iwis.register) as pool:
        for name, result in zip(names, pool.map(_run, names), strict=True):
            results[name] = result
            rows.append(_row(name, result))
            say(rows[-1])
            sys.stdout.flush()
    bad = sum(not result.agrees for result in results.values())
    say(f"{len(rows)} cases, {bad} differ\n")
    if not words:
        docs = Path(iwis.__file__).parent / "docs"
        (docs / "parity.md").write_text(
            f"{_HEAD}{''.join(rows)}\n{len(rows)} cases, {bad} differ.\n"
        )
        draw_sheet(results, docs / "pictures" / "parity.jpg")
    return int(bad > 0)


def _run(name: str) -> Result:
    """A case, in a worker."""
    case = next(case for case in ALL_CASES if case.name == name)
    with tempfile.TemporaryDirectory() as folder:
        return run_case(case, Path(folder))


def _row(name: str, result: Result) -> str:
    figures = f"{result.difference:.4f} | {result.bias:+.4f} | {result.odd:.3f}"
    reasons = [] if result.agrees else [WHY.get(name, "not known")]
    told = [
        line
        for line in dict.fromkeys(result.warnings)
        if not any(words in line for words in _OF_THE_SUITE)
    ]
    reasons += [f'"{line}"' for line in told]
    why = "; ".join(reasons).replace("|", "/")
    return f"| {name} | {'agrees' if result.agrees else '**differs**'} | {figures} | {why} |\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

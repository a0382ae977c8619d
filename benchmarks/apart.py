"""Cases that run in a process of their own each, for their memory is measured."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from machine import load


def run_cases(about: str, cases: dict[str, Callable[[int], dict]], part: str, measure) -> None:
    """Of a part's command line: print one case's result as JSON, or write FOLDER/part.json.

    cases: what --case may name; measure(quick) -> dict of all results, made by in_own_process
    """
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--case", nargs=2, metavar=("CASE", "VALUE"))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--threads", type=int, help="not used")
    parser.add_argument("--pictures", type=Path, help="not used")
    options = parser.parse_args()
    if options.case:
        name, value = options.case
        print(json.dumps(cases[name](int(value))), flush=True)
        # At its end the bpy module of Blender 4.5 may wait for a thread of its own for ever.
        os._exit(0)
    start = time.perf_counter()
    found = measure(options.quick)
    found |= {"load": load(), "seconds": time.perf_counter() - start}
    (options.folder / f"{part}.json").write_text(json.dumps(found, indent=1))


def in_own_process(script: str, name: str, value: int) -> dict:
    """The result of one case of a script; Blender may print lines before it."""
    command = [sys.executable, script, "--case", name, str(value)]
    out = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
    return json.loads(out.splitlines()[-1])

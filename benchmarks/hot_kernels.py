"""Where the CPU time of a render goes, kernel by kernel, as Linux's perf sees it.

    python benchmarks/hot_kernels.py [FILE.blend ...] [--samples 64] [--center] [--width 320]

Without files: those of sample_blends/. One thread, FIXED, RENDERS renders with warm caches. perf
knows nothing of numba's code, so its map of symbols is written for it, of the machine code that the
kernels were read from; a kernel that LLVM has built into its caller counts as that. One Markdown
table is printed: a column a file, percents of the CPU time. Needs perf and nm (Debian packages
linux-perf and binutils).
"""

from __future__ import annotations

import argparse
import collections
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import filtered
from numba.core.codegen import CPUCodeLibrary
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

RENDERS, HERTZ, LEAST = 5, 2000, 0.01
_STARTUP_S = 0.5  # until perf listens
_LENGTH = re.compile(r"\d+")
NAMES = {
    "libembree": "Embree",
    "libpython": "Python",
    "_multiarray_umath": "NumPy",
    "libc.so": "C library",
    "kernel.kallsyms": "system",
}


class KeptCode:
    """The machine code that numba reads from its cache from now on: (code, code generator)."""

    def __init__(self):
        self.objects: list[tuple[bytes, object]] = []
        inner = CPUCodeLibrary._unserialize.__func__

        def read(cls, codegen, state):
            library = inner(cls, codegen, state)
            if state[1] == "object":
                self.objects.append((state[2][0], codegen))
            return library

        CPUCodeLibrary._unserialize = classmethod(read)

    def write_map(self) -> None:
        """Write /tmp/perf-PID.map, where perf looks for names."""
        with Path(f"/tmp/perf-{os.getpid()}.map").open("w", encoding="utf-8") as out:
            for code, codegen in self.objects:
                for address, size, name in _symbols(code, codegen):
                    out.write(f"{address:x} {size:x} {name}\n")


def _symbols(code: bytes, codegen):
    """(address, size, name) of the functions of an object file that has been loaded."""
    with tempfile.NamedTemporaryFile(suffix=".o") as file:
        file.write(code)
        file.flush()
        listed = subprocess.run(["nm", "-S", file.name], capture_output=True, text=True, check=True)
    rows = [row for row in map(str.split, listed.stdout.splitlines()) if len(row) == 4]
    moved = None
    for place, _, kind, name in rows:
        if kind in "TW":
            address = codegen._engine.get_function_address(name)
            moved = address - int(place, 16) if address else None
            break
    if moved is None:
        return
    for place, size, kind, name in rows:
        if kind in "TtWw":
            yield moved + int(place, 16), int(size, 16), kernel_name(name)


def kernel_name(mangled: str) -> str:
    """module.function of numba's name for a kernel; another name as it is."""
    if not mangled.startswith("_ZN"):
        return mangled
    parts, rest = [], mangled[3:]
    while found := _LENGTH.match(rest):
        begin = found.end()
        parts.append(rest[begin : begin + int(found.group())])
        rest = rest[begin + int(found.group()) :]
    return ".".join(parts[-2:])


def shares_of(report: str) -> dict[str, float]:
    """name -> part of the time, of what perf report --sort dso,symbol prints."""
    shares: dict[str, float] = collections.defaultdict(float)
    for line in report.splitlines():
        found = re.match(r"\s*([\d.]+)%\s+(.+?)\s+\[[.k]\]\s+(\S+)", line)
        if not found:
            continue
        percent, dso, symbol = float(found[1]), found[2], found[3]
        known = next((name for part, name in NAMES.items() if part in dso), "other")
        shares[symbol if dso.startswith("[JIT]") else known] += percent / 100.0
    return dict(shares)


def measure(run: IwisRun, kept: KeptCode, changes: dict) -> tuple[float, dict[str, float]]:
    """CPU seconds of a render, and its shares."""
    run.render(**changes)
    kept.write_map()
    with tempfile.TemporaryDirectory() as folder:
        data = f"{folder}/perf.data"
        watch = ["perf", "record", "-e", "cpu-clock", "-F", str(HERTZ), "-p", str(os.getpid())]
        with subprocess.Popen([*watch, "-o", data], stderr=subprocess.DEVNULL) as perf:
            time.sleep(_STARTUP_S)
            before = time.process_time()
            for _ in range(RENDERS):
                run.render(**changes)
            cpu = (time.process_time() - before) / RENDERS
            perf.send_signal(signal.SIGINT)
        show = ["perf", "report", "-i", data, "--stdio", "--sort", "dso,symbol"]
        report = subprocess.run(show, capture_output=True, text=True, check=True).stdout
    return cpu, shares_of(report)


def table(columns: dict[str, tuple[float, dict[str, float]]]) -> str:
    """Markdown: a row for each kernel that takes LEAST of some file, the dearest ones first."""
    names = {name for _, shares in columns.values() for name in shares}
    most = {name: max(shares.get(name, 0.0) for _, shares in columns.values()) for name in names}
    rows = sorted((n for n in names if most[n] >= LEAST), key=lambda name: -most[name])
    cells = [["CPU s a render", *(f"{cpu:.2f}" for cpu, _ in columns.values())]]
    cells += [
        [name, *(f"{100 * shares.get(name, 0.0):.1f}" for _, shares in columns.values())]
        for name in rows
    ]
    lines = [["", *columns], ["---"] * (len(columns) + 1), *cells]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.blend")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--center", action="store_true", help="one point a pixel")
    parser.add_argument("--width", type=int, default=320, help="of the pictures, in pixels")
    parser.add_argument("--warm-up", action="store_true", help="compile, and print nothing")
    options = parser.parse_args()
    missing = [tool for tool in ("perf", "nm") if not shutil.which(tool)]
    if missing:
        sys.stderr.write(f"{' and '.join(missing)} not found: install linux-perf and binutils\n")
        return 1
    if not options.warm_up:  # numba keeps no machine code of kernels that it has just compiled
        again = [sys.executable, *sys.argv, "--warm-up"]
        subprocess.run(again, check=True, stdout=subprocess.DEVNULL)
    kept, columns = KeptCode(), {}
    changes = {"max_samples": options.samples}
    changes |= {"pixel_filter": "CENTER"} if options.center else {}
    files = options.files or sorted((filtered.ROOT / "sample_blends").glob("*.blend"))
    for path in files:
        scene = filtered.open_file(path.resolve(), options.width, threads=1)
        base = RenderSettings(stop_rule="FIXED", threads=1, filter_width=filtered.FILTER_PX)
        run = IwisRun(export_open_file(scene).scene, base)
        if options.warm_up:
            run.render(**changes)
        else:
            columns[path.stem] = measure(run, kept, changes)
    sys.stdout.write(table(columns))
    return 0


if __name__ == "__main__":
    sys.exit(main())

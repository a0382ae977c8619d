"""The whole suite: runs the parts, each in a process of its own, and writes docs/benchmarks.md.

    python benchmarks/suite.py [--quick] [--parts PART,...] [--scenes SCENE,...] [--report]

Results are kept as JSON in out/bench (out/bench-quick): a part that is not run again keeps its old
ones, and --report only writes the page anew. SCENE may be a .blend file: it is added to the page.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import machine
import report
from configurations import SCENES
from run_mitsuba import make_environment

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
OF_A_SCENE = ("error", "rays", "threads", "pictures")
OF_ALL = ("scaling", "startup", "export")


def main() -> int:
    """Run, report; 1 if a part failed."""
    options = parse()
    name = "bench-quick" if options.quick else "bench"
    folder = options.out or ROOT / "out" / name
    pictures = folder / "pictures" if options.quick else ROOT / "docs" / "pictures"
    for needed in (folder, pictures):
        needed.mkdir(parents=True, exist_ok=True)
    failed = [] if options.report else run_parts(options, folder, pictures)
    page = folder / "benchmarks.md" if options.quick else ROOT / "docs" / "benchmarks.md"
    report.write(folder, page, pictures)
    print(page)
    for part in failed:
        print(f"failed: {part}", file=sys.stderr)
    return 1 if failed else 0


def parse():
    everything = OF_A_SCENE + OF_ALL
    parser = argparse.ArgumentParser(description="Run the benchmark suite.")
    parser.add_argument("--parts", type=_list_of(everything), default=everything, metavar="PART,..")
    parser.add_argument("--scenes", type=_split, default=tuple(SCENES), metavar="SCENE,...")
    parser.add_argument("--quick", action="store_true", help="tiny pictures, to try the programs")
    parser.add_argument(
        "--report", action="store_true", help="only write the page, of what is kept"
    )
    parser.add_argument("--renew", action="store_true", help="make kept references anew")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="of the results")
    parser.add_argument("--mitsuba", type=Path, metavar="PYTHON", help="one that has mitsuba")
    parser.add_argument("--no-mitsuba", action="store_true")
    options = parser.parse_args()
    for scene in options.scenes:
        if scene not in SCENES and not Path(scene).is_file():
            parser.error(f"{scene} is neither a file nor one of {', '.join(SCENES)}")
    return options


def _split(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))


def _list_of(known):
    def parts(text):
        unknown = set(_split(text)) - set(known)
        if unknown:
            raise argparse.ArgumentTypeError(
                f"no {', '.join(unknown)}; there are {', '.join(known)}"
            )
        return _split(text)

    return parts


def run_parts(options, folder: Path, pictures: Path) -> list[str]:
    """Run all that is wanted; returns what failed."""
    (folder / "machine.json").write_text(json.dumps(machine.describe(), indent=1))
    common = [folder, f"--threads={options.threads}", f"--pictures={pictures}"]
    if options.quick:
        common.append("--quick")
    failed = []
    of_a_scene = [part for part in OF_A_SCENE if part in options.parts]
    mitsuba = find_mitsuba(options) if "error" in of_a_scene else None
    for scene in options.scenes if of_a_scene else ():
        command = [HERE / "bench_scene.py", scene, ",".join(of_a_scene), *common]
        command += [f"--mitsuba={mitsuba}"] if mitsuba else []
        command += ["--renew"] if options.renew else []
        failed += _run(scene, command)
    for part in OF_ALL:
        if part in options.parts:
            failed += _run(part, [HERE / f"bench_{part}.py", *common])
    return failed


def _run(name: str, command) -> list[str]:
    start = time.perf_counter()
    code = subprocess.run([sys.executable, *map(str, command)], check=False).returncode
    print(f"{name}: {time.perf_counter() - start:.0f} s in all", flush=True)
    return [f"{name} (exit code {code})"] if code else []


def find_mitsuba(options) -> Path | None:
    """The Python that has Mitsuba: the one given, else that of .venv-mitsuba, made if need be."""
    if options.no_mitsuba:
        return None
    if options.mitsuba:
        return options.mitsuba
    try:
        return make_environment(ROOT / ".venv-mitsuba")
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"going on without Mitsuba, it cannot be installed: {error}", file=sys.stderr)
        return None


if __name__ == "__main__":
    sys.exit(main())

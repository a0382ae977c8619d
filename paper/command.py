"""python -m iwis paper: every figure and claim of the paper, from our code."""

from __future__ import annotations

import sys
from pathlib import Path

from .inputs import InputError, load_inputs
from .plan import FULL, SMALL
from .results import compute


def add_arguments(parser) -> None:
    """Of the subcommand, to an argparse parser."""
    parser.add_argument(
        "--data", metavar="DIR", type=Path, help="the paper's data; without: what IWIS ships"
    )
    parser.add_argument("--out", metavar="DIR", type=Path, required=True, help="where to write")
    parser.add_argument("--small", action="store_true", help="a quick run at 25 x 50 pixels")
    parser.add_argument("--threads", metavar="N", type=int, default=0, help="default: all cores")


def run(options) -> Path:
    """Write paper.html and its pictures; returns its path. Raises InputError with one line."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise InputError("needs matplotlib; install it with: pip install 'iwis[paper]'") from None
    if not 0 <= options.threads <= 1024:
        raise InputError(f"--threads {options.threads}: 0 to 1024")
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        probe = options.out / ".iwis-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"{options.out}: cannot be written: {error.strerror}") from None
    from . import plots, report

    inputs = load_inputs(options.data)
    plan = SMALL if options.small else FULL
    results = compute(inputs, plan, options.threads, tell=_teller())
    return report.write(results, plots.draw_all(results, options.out), options.out)


def _teller():
    """Prints a text unless it is the last one."""
    last = [""]

    def tell(text):
        if text != last[0]:
            last[0] = text
            print(text, file=sys.stderr, flush=True)

    return tell

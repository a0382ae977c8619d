"""Run cases and write docs/parity.md: make parity. With words: only cases that have one of them."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import iwis

from .all_cases import ALL_CASES
from .compare import run_case

_HEAD = """# Parity with Cycles

Made by `make parity`: one small scene for each node and setting, rendered by IWIS and by Cycles
with direct light only. A case shown as light has no noise; of lit ones the noise of both is taken
off. *Difference*: root mean square over the picture, of its mean, without the pixels (at most 1
%) that a ray a hundredth of a pixel aside sees otherwise; *bias*: of the means; *odd*: share of
pixels that differ by over a tenth. A case agrees if difference and bias are at most 1 %.

| case | | difference | bias | odd |
|---|---|---|---|---|
"""


def main(words) -> int:
    """Run the cases whose name has one of the words, or all. Returns 0 if all agree."""
    say = sys.stdout.write
    iwis.register()
    chosen = [c for c in ALL_CASES if not words or any(w.lower() in c.name.lower() for w in words)]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for case in chosen:
            result = run_case(case, Path(folder))
            word = "agrees" if result.agrees else "**differs**"
            figures = f"{result.difference:.4f} | {result.bias:+.4f} | {result.odd:.3f}"
            rows.append(f"| {case.name} | {word} | {figures} |\n")
            say(f"{rows[-1]}")
            sys.stdout.flush()
    iwis.unregister()
    bad = sum("differs" in row for row in rows)
    say(f"{len(rows)} cases, {bad} differ\n")
    if not words:
        path = Path(iwis.__file__).parent / "docs" / "parity.md"
        path.write_text(f"{_HEAD}{''.join(rows)}\n{len(rows)} cases, {bad} differ.\n")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Render whole scenes in a real Blender program: templates, assets, add operators beside Cycles.

    python tests/real_blender/check_whole_scenes.py [--blender PROGRAM] [--zip FILE] [WORD ...]

With words: only scenes whose name has one of them. real.py says what it needs.
"""

import collections
import json

from real import HERE, check, installed, parse

INSIDE = HERE.parent / "whole_scenes" / "in_blender.py"


def main() -> None:
    options = parse(__doc__, (["words"], {"nargs": "*"}))
    with installed(options) as (blender, folder, _):
        out = folder / "results.json"
        text = blender.run("-b", "--python", INSIDE, "--", out, *options.words)
        check(out.exists(), "the program came to its end")
        results = json.loads(out.read_text())
        print(*(line for line in text.splitlines() if line.startswith("| ")), sep="\n")
        states = collections.Counter(state for _, _, state, *_ in results)
        bad = [name for _, name, state, *_ in results if state in ("failed", "black")]
        check(results and not bad, f"{dict(states)}, failed or black: {bad or 'none'}")


if __name__ == "__main__":
    main()

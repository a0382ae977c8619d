"""Render all whole scenes in the bpy module and write docs/whole-scenes.md: make whole-scenes.

With words: only those whose name has one of them, and nothing is written.
"""

from __future__ import annotations

import collections
import sys
from pathlib import Path

import bpy

import iwis

from .listing import all_scenes, measure_all, row
from .why import WHY

_HEAD = """# Whole scenes beside Cycles

Made by `make whole-scenes`: Blender's factory scene and application templates, every node group and
HDR picture among its bundled assets (brushes apart), and every operator that adds an object, with
its own defaults, under a smooth sky. Each is rendered by IWIS and by Cycles with direct light only,
72 x 48 pixels, 256 samples. *Mean*: difference of the means; *blocks*: root mean square difference
of the means of 6 x 6 pixels, both of Cycles' mean. *same*: at most 1 % and 3 %; *black*: a block of
less than a tenth of Cycles' light. Quoted is what IWIS warns of.

"""
_TABLE = """| | scene | | mean | blocks | |
|---|---|---|---|---|---|
"""


def main(words) -> int:
    """Returns 0 if no scene failed or was black."""
    say = sys.stdout.write
    iwis.register()
    try:
        scenes, values = all_scenes()
        results = measure_all(scenes, words)
    finally:
        bpy.ops.wm.read_homefile(use_empty=True)  # fluids left open crash at the end
        iwis.unregister()
    counts = collections.Counter(result.state for result in results)
    total = ", ".join(f"{n} {state}" for state, n in sorted(counts.items()))
    say(f"{len(results)} scenes: {total}\n")
    if not words:
        text = f"Blender {bpy.app.version_string}, {len(results)} scenes: {total}.\n\n"
        text += _TABLE + "".join(row(result, WHY) for result in results)
        if values:
            names = ", ".join(sorted(set(values)))
            text += f"\n{len(values)} node groups make no geometry and shade nothing: {names}.\n"
        docs = Path(iwis.__file__).parent / "docs"
        (docs / "whole-scenes.md").write_text(_HEAD + text)
    return int(bool(counts["failed"] or counts["black"]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Inside a Blender program: blender -b --python in_blender.py -- OUT.json WORDS"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from whole_scenes.listing import all_scenes, measure_all


def main(out: str, words: list[str]) -> None:
    scenes, _ = all_scenes()
    results = measure_all(scenes, words)
    rows = [result._replace(pictures=None, lines=list(result.lines)) for result in results]
    Path(out).write_text(json.dumps(rows))


arguments = sys.argv[sys.argv.index("--") + 1 :]
main(arguments[0], arguments[1:])

"""The extension in the window of a real Blender: random edits while the rendered view renders.

    python tests/real_blender/check_window.py
        [--quick | --life | --rules | --measure | --shots FOLDER | --render FOLDER |
         --denoise FOLDER | --bake FOLDER | --shading FOLDER] [--seed N]

First the extension's life, from installing its zip to its removal (life_in_window.py; alone with
--life). Then previews, Escape in a render and the render after it (render_in_window.py; alone with
--render), the denoiser's box (denoise_in_window.py; alone with --denoise), bakes
(bake_in_window.py; alone with --bake) and the shading menu beside Cycles' (shading_in_window.py;
alone with --shading). Then rules of what begins the picture anew (restarts.py;
alone with --rules), and a hundred and more edits, undo, redo, engine switches, file loads and
window resizes, each a step of edit_in_window.py; --quick does fewer of them. --measure prints
latencies of the rendered view (measure_in_window.py), --shots takes the pictures of docs/
(shots_in_window.py) instead. real.py says what it needs; as root on Debian it is all there.
"""

import sys
from pathlib import Path

import bpy
import numpy as np
from real import HERE, ROOT, Blender, check, installed, parse
from window import Window

EDITS, QUICK_EDITS = 200, 50
# Scripts that an option of this name runs alone.
_ALONE = {
    "render": "render_in_window.py",
    "denoise": "denoise_in_window.py",
    "bake": "bake_in_window.py",
    "shading": "shading_in_window.py",
}


class Watcher:
    """Does what the script in Blender asks for, and remembers what it said."""

    def __init__(self, window: Window):
        self._window, self.said = window, []

    def __call__(self, line: str) -> None:
        words = line.split()
        if words[:1] != ["IWIS-TEST"]:
            return
        if words[1] == "SHOT":
            self._window.screenshot(Path(words[2]))
        elif words[1] == "CROP":
            crop(Path(words[2]), *map(int, words[3:]))
        elif words[1] == "RESIZE":
            names = self._window.run("xdotool", "search", "--name", "Blender").split()
            self._window.run("xdotool", "windowsize", names[0], *words[2:])
        else:
            print(" ", *words[1:], flush=True)
            self.said.append(words[1])


def crop(path: Path, x: int, y: int, width: int, height: int) -> None:
    """Cut a part out of a picture, x and y from its upper left corner."""
    image = bpy.data.images.load(str(path))
    columns, rows = image.size
    pixels = np.empty(columns * rows * 4, np.float32)
    image.pixels.foreach_get(pixels)
    low = rows - y - height
    part = pixels.reshape(rows, columns, 4)[low : low + height, x : x + width]
    image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(part).ravel())
    image.save()
    bpy.data.images.remove(image)


def run_script(blender, folder: Path, script: str, arguments: list, words: list, seconds=1200):
    """Run a script in Blender's window to its end; leave when it does not come there."""
    log = folder / f"{script}.log"
    with Window(blender.program, blender.environment, log) as window:
        watcher = Watcher(window)
        window.start(*map(str, arguments), script=HERE / script, words=list(map(str, words)))
        code = window.wait(seconds, watcher)
    text = log.read_text()
    if code or "END" not in watcher.said:
        sys.exit(f"{text[-5000:]}\n{script} ended with {code}")
    check("Traceback" not in text, "no traceback in Blender's log")


def live(blender, folder: Path, package: Path) -> None:
    """An extension's life in a Blender that has never seen it."""
    fresh = Blender(blender.program, folder / "fresh")
    fresh.environment.update(_shared_kernels(folder))
    sample = ROOT / "sample_blends" / "statue.blend"
    run_script(fresh, folder, "life_in_window.py", [sample], [folder, package.resolve()])


def with_statue(blender, folder: Path, script: str, quick: bool = False) -> None:
    """One of the scripts that take the statue, and a folder for their pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    sample = ROOT / "sample_blends" / "statue.blend"
    run_script(blender, folder, script, [sample], [folder.resolve(), *["quick"] * quick])


def _shared_kernels(folder: Path) -> dict[str, str]:
    """Compiled once for all windows of a run."""
    return {"IWIS_CACHE_DIR": str(folder / "cache")}


def main() -> None:
    options = parse(
        __doc__,
        (["--quick"], {"action": "store_true", "help": "fewer edits, nothing beside Cycles"}),
        (["--measure"], {"action": "store_true", "help": "measure latencies instead"}),
        (["--render"], {"type": Path, "help": "only previews and renders; pictures go here"}),
        (["--denoise"], {"type": Path, "help": "only the denoiser; pictures go here"}),
        (["--bake"], {"type": Path, "help": "only bakes; pictures go here"}),
        (["--shading"], {"type": Path, "help": "only the shading menu; pictures go here"}),
        (["--shots"], {"type": Path, "help": "write the screenshots of the docs here instead"}),
        (["--rules"], {"action": "store_true", "help": "no random edits, and none but restarts"}),
        (["--life"], {"action": "store_true", "help": "only installing, disabling, removing"}),
        (["--seed"], {"type": int, "default": 1, "help": "other edits"}),
    )
    samples = ROOT / "sample_blends"
    with installed(options) as (blender, folder, package):
        blender.environment.update(_shared_kernels(folder))
        if options.measure:
            run_script(blender, folder, "measure_in_window.py", [], [folder])
            return
        if options.shots:
            options.shots.mkdir(parents=True, exist_ok=True)
            words = [options.shots.resolve()]
            run_script(blender, folder, "shots_in_window.py", [samples / "statue.blend"], words)
            return
        for chosen, script in _ALONE.items():
            if getattr(options, chosen):
                with_statue(blender, getattr(options, chosen), script, options.quick)
                return
        if not options.rules:
            live(blender, folder, package)
        if options.life:
            return
        if options.rules:
            words = [options.seed, 0, folder, samples / "turntable.blend"]
            run_script(blender, folder, "edit_in_window.py", [samples / "statue.blend"], words)
            return
        for name, script in _ALONE.items():
            with_statue(blender, folder / name, script, options.quick)
        count = QUICK_EDITS if options.quick else EDITS
        words = [options.seed, count, folder, samples / "turntable.blend"]
        run_script(blender, folder, "edit_in_window.py", [samples / "statue.blend"], words)
        check(True, f"{count} random edits with seed {options.seed}")


if __name__ == "__main__":
    main()

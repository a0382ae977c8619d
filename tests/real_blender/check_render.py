"""Install the extension's zip in a real Blender program, render with it, read the layers back.

    python tests/real_blender/check_render.py [--blender PROGRAM] [--zip FILE] [FILE.blend]

The bpy module that the other tests use is not what users have. Runs in an environment with bpy and
OpenEXR, which build the zip and read the layers (make test-blender). PROGRAM is Debian's Blender,
unpacked by get_blender.sh, when none is given; the zip is the one for its Python.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from iwis.core.exr import read_exr_layers

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SMALL = "import bpy; s = bpy.context.scene; s.render.resolution_percentage = 25"
OWN_FLAGS = ("use_pass_error", "use_pass_unoccluded", "use_pass_visibility")
ALL_PASSES = "".join(f"; s.view_layers[0].iwis.{flag} = True" for flag in OWN_FLAGS)
NO_CAMERA = "import bpy; bpy.context.scene.camera = None"
OWN_PASSES = ("IWIS Samples", "IWIS Error", "IWIS Unoccluded", "IWIS Visibility")


class Blender:
    """A Blender program with a folder of its own for settings and extensions."""

    def __init__(self, program: str, resources: Path):
        self.program = program
        # Without this folder install-file complains that the repository is not loaded.
        (resources / "extensions" / "user_default").mkdir(parents=True)
        self.environment = dict(os.environ, BLENDER_USER_RESOURCES=str(resources))

    def run(self, *arguments, expected_code: int = 0) -> str:
        """What the program printed. Leaves when its exit code is another."""
        print("+ blender", *arguments, flush=True)
        done = subprocess.run(
            [self.program, *arguments],
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=900,
            check=False,
        )
        if done.returncode != expected_code:
            sys.exit(f"{done.stdout}\nexit code {done.returncode}, expected {expected_code}")
        return done.stdout

    def python_tag(self) -> str:
        code = "import sys; print('TAG', 'cp%d%d' % sys.version_info[:2])"
        words = self.run("-b", "--factory-startup", "--python-expr", code).split()
        return words[words.index("TAG") + 1]


def build_zip(python_tag: str) -> Path:
    """The zip for Linux and this Python, built by the project's own builder."""
    command = [sys.executable, ROOT / "scripts" / "build_zip.py"]
    subprocess.run([*command, "--platform", "linux-x64", "--python", python_tag], check=True)
    return sorted((ROOT / "dist").glob(f"iwis-*-linux-x64-{python_tag}.zip"))[-1]


def check(condition, what: str) -> None:
    if not condition:
        sys.exit(f"wrong: {what}")
    print(f"  ok: {what}", flush=True)


def check_layers(path: Path) -> None:
    """The picture and IWIS' own passes are there, of one size, finite and not empty."""
    layers = read_exr_layers(path)
    by_pass = {name.rpartition(".")[2]: pixels for name, pixels in layers.items()}
    check({"Combined", *OWN_PASSES} <= set(by_pass), f"layers: {', '.join(by_pass)}")
    sizes = {pixels.shape[:2] for pixels in by_pass.values()}
    check(len(sizes) == 1, f"all layers are {sizes}")
    check(all(np.isfinite(by_pass[name]).all() for name in by_pass), "all values are finite")
    samples = by_pass["IWIS Samples"]
    check(by_pass["Combined"][..., :3].max() > 0, "the picture is not black")
    check(samples.max() > samples.min(), f"samples a pixel {samples.min()} ... {samples.max()}")
    visibility = by_pass["IWIS Visibility"]
    check(visibility.min() >= 0 and visibility.max() <= 1, "visibility is within 0 ... 1")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("blend", nargs="?", type=Path, default=ROOT / "sample_blends/statue.blend")
    parser.add_argument("--blender", help="a Blender program; else Debian's is unpacked")
    parser.add_argument("--zip", type=Path, help="the extension; else it is built")
    options = parser.parse_args()
    program = (
        options.blender
        or subprocess.check_output(
            [HERE / "get_blender.sh"], text=True, stdin=subprocess.DEVNULL
        ).strip()
    )
    with tempfile.TemporaryDirectory(prefix="iwis-blender-") as name:
        folder = Path(name)
        blender = Blender(program, folder / "resources")
        print(blender.run("-b", "--version").splitlines()[0])
        package = options.zip or build_zip(blender.python_tag())
        command = ("--command", "extension")
        blender.run(*command, "install-file", "-r", "user_default", "-e", package)
        # install-file answers 0 even when it fails
        check("IWIS" in blender.run("-b", "-E", "help").split(), "Blender lists the engine IWIS")
        arguments = ["-b", options.blend.resolve(), "-E", "IWIS", "-o", folder / "out_####"]
        arguments += ["-F", "OPEN_EXR_MULTILAYER"]
        text = blender.run(*arguments, "--python-expr", SMALL + ALL_PASSES, "-f", "1")
        check(f"Saved: '{folder}/out_0001.exr'" in text, "Blender says where it saved")
        check_layers(folder / "out_0001.exr")
        blender.run(*arguments, "--python-expr", NO_CAMERA, "-f", "2", expected_code=1)
        check(not (folder / "out_0002.exr").exists(), "without a camera: exit code 1 and no file")
        blender.run(*command, "remove", "iwis")
        check("IWIS" not in blender.run("-b", "-E", "help").split(), "removed again")


if __name__ == "__main__":
    main()

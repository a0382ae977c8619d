"""Install the extension's zip in a real Blender, render with it, read layers, call operators.

    python tests/real_blender/check_render.py [--blender PROGRAM] [--zip FILE] [FILE.blend]

real.py says what it needs.
"""

from pathlib import Path

import numpy as np
from real import HERE, ROOT, check, install, installed, parse

from iwis.core.exr import read_exr_layers

SMALL = "import bpy; s = bpy.context.scene; s.render.resolution_percentage = 25"
OWN_FLAGS = ("use_pass_error", "use_pass_unoccluded", "use_pass_visibility")
ALL_PASSES = "".join(f"; s.view_layers[0].iwis.{flag} = True" for flag in OWN_FLAGS)
NO_CAMERA = "import bpy; bpy.context.scene.camera = None"
NO_PIXELS = "import bpy; r = bpy.context.scene.render; r.use_border, r.border_max_x = True, 0.0"
OWN_PASSES = ("IWIS Samples", "IWIS Error", "IWIS Unoccluded", "IWIS Visibility")


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


def check_operators(blender, folder: Path) -> None:
    """Every operator from a script in background mode, and what each says that cannot run."""
    arguments = ["-b", ROOT / "sample_blends" / "statue.blend", "--python-exit-code", "4"]
    script = HERE / "operators_in_background.py"
    text = blender.run(*arguments, "--python", script, "--", folder)
    lines = [line for line in text.splitlines() if line.startswith("IWIS-TEST")]
    print(*lines, sep="\n")
    check(lines[-1].endswith("END") and "Traceback" not in text, "all operators in background")


def main() -> None:
    sample = ROOT / "sample_blends/statue.blend"
    options = parse(__doc__, (["blend"], {"nargs": "?", "type": Path, "default": sample}))
    with installed(options) as (blender, folder, package):
        arguments = ["-b", options.blend.resolve(), "-E", "IWIS", "-o", folder / "out_####"]
        arguments += ["-F", "OPEN_EXR_MULTILAYER"]
        text = blender.run(*arguments, "--python-expr", SMALL + ALL_PASSES, "-f", "1")
        check(f"Saved: '{folder}/out_0001.exr'" in text, "Blender says where it saved")
        check_layers(folder / "out_0001.exr")
        blender.run(*arguments, "--python-expr", NO_CAMERA, "-f", "2", expected_code=1)
        check(not (folder / "out_0002.exr").exists(), "without a camera: exit code 1 and no file")
        (folder / "out_0003.exr").symlink_to("/dev/full")
        text = blender.run(*arguments, "--python-expr", SMALL, "-f", "3", expected_code=1)
        check(
            "out_0003.exr: is cut short" in text, "on a full disk: exit code 1 and the file's name"
        )
        text = blender.run(*arguments, "--python-expr", NO_PIXELS, "-f", "4", expected_code=1)
        check("the picture has no pixels" in text, "without a pixel: exit code 1 and why")
        check_operators(blender, folder)
        install(blender, package)
        check("IWIS" in blender.engines(), "installed over itself, as an upgrade is")
        blender.run("--command", "extension", "remove", "iwis")
        check("IWIS" not in blender.engines(), "removed again")
        left = [p for p in (folder / "resources" / "extensions").rglob("*") if "iwis" in p.name]
        check(not left, f"no file is left: {left}")


if __name__ == "__main__":
    main()

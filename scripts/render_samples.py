"""Render every file of sample_blends/ by the command line, and show each as PNG as well.

    python scripts/render_samples.py OUT [more arguments of python -m iwis render]

NAME.exr (all layers and passes), NAME.json (what it cost), NAME.png (through the file's own view
transform) and NAME-samples.png (samples a pixel, white = the most) appear in OUT; of a file with
an animation all frames. Prints what was rendered, a line a frame.
"""

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

import iwis
from iwis.core.exr import read_exr_layers

ROOT = Path(__file__).resolve().parent.parent


def open_blend(blend: Path) -> list[str]:
    """Open a file; the arguments that ask for all its frames, none for a still."""
    bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if not bpy.data.actions:
        return []
    return ["-s", str(scene.frame_start), "-e", str(scene.frame_end)]


def render(blend: Path, folder: Path, arguments: list[str]) -> list[Path]:
    """Run the command line on one file and print what it says; the EXR files it wrote."""
    for old in folder.glob(f"{blend.stem}[0-9]*.exr"):
        old.unlink()
    name = folder / blend.stem
    command = [sys.executable, "-m", "iwis", "render", blend, "-o", f"{name}.exr"]
    command += ["--stats", f"{name}.json", *arguments]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"{done.stdout}{done.stderr}{blend}: exit code {done.returncode}")
    lines = [line for line in done.stdout.splitlines() if line.startswith("frame ")]
    print(*(f"{blend.stem}: {line}" for line in lines), sep="\n", flush=True)
    single = name.with_suffix(".exr")
    return sorted(folder.glob(f"{blend.stem}[0-9]*.exr")) if "-s" in arguments else [single]


def save_png(pixels: np.ndarray, path: Path, as_data: bool) -> None:
    """Save (h, w, 3 or 4) pixels as PNG: data as they are, else by the file's view transform."""
    height, width, channels = pixels.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels
    image = bpy.data.images.new("iwis", width, height, alpha=True, float_buffer=True)
    image.alpha_mode = "PREMUL"
    image.pixels.foreach_set(rgba.ravel())
    scene = bpy.context.scene
    if as_data:
        scene.view_settings.view_transform = "Raw"
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "PNG"
    image.save_render(str(path), scene=scene)
    bpy.data.images.remove(image)


def show(exr: Path) -> list[Path]:
    """Save the picture and its samples as PNG beside an EXR of the file that is open."""
    layers = read_exr_layers(exr)
    combined = next(pixels for name, pixels in layers.items() if name.endswith(".Combined"))
    counts = next(pixels for name, pixels in layers.items() if name.endswith(".IWIS Samples"))
    picture, samples = exr.with_suffix(".png"), exr.with_name(f"{exr.stem}-samples.png")
    view_transform = bpy.context.scene.view_settings.view_transform
    save_png(combined, picture, as_data=False)
    save_png(np.repeat(counts / max(counts.max(), 1.0), 3, axis=2), samples, as_data=True)
    bpy.context.scene.view_settings.view_transform = view_transform
    return [picture, samples]


def main() -> None:
    folder, arguments = Path(sys.argv[1]).absolute(), sys.argv[2:]
    folder.mkdir(parents=True, exist_ok=True)
    blends = sorted((ROOT / "sample_blends").glob("*.blend"))
    if not blends:
        sys.exit("sample_blends/ holds no .blend file")
    iwis.register()  # or Blender complains that it does not know the files' engine
    try:
        for blend in blends:
            frames = open_blend(blend)
            for exr in render(blend, folder, [*frames, *arguments]):
                print(f"{blend.stem}:", *(path.name for path in [exr, *show(exr)]), flush=True)
    finally:
        # bpy 4.5 hangs at exit when a scene names a Python engine, or its class is registered.
        for scene in bpy.data.scenes:
            scene.render.engine = "CYCLES"
        iwis.unregister()
    print(f"all in {folder}")


if __name__ == "__main__":
    main()

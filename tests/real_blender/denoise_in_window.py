"""Run by Blender's window: the denoiser's box, a render and the rendered view that ask for it.

blender STATUE.blend --python denoise_in_window.py -- FOLDER

Where Blender brings no Open Image Denoise (Debian's), the box is grey, and both keep their noise
and say why; else both are denoised.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside

FOLDER = Path(inside.words()[0])


def rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


def final_render(scene, there: bool):
    """Denoised, or with its noise and a warning; the noisy picture is kept in either case."""
    scene.iwis.denoise = scene.iwis.keep_film = True
    scene.iwis.max_samples, scene.iwis.stop_rule = 8, "FIXED"
    scene.render.resolution_x, scene.render.resolution_y = 160, 240
    bpy.context.preferences.view.render_display_type = "NONE"
    started = time.perf_counter()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.render.render("INVOKE_DEFAULT", scene=scene.name)
    yield 1.0
    yield from inside.until(lambda: not rendering(), 300.0, "the render")
    inside.say(f"render: {time.perf_counter() - started:.2f} s")
    job = inside.module("job").RenderJob.current
    (film,) = job.films.values()
    changed = bool((film.layers["combined"] != film.layers["noisy"]).any())
    warned = [line for line in job.records[-1].stats.warnings if "keeps its noise" in line]
    inside.say(f"noise taken away: {changed}; warnings: {warned}")
    inside.expect(
        changed == there and bool(warned) != there, "the render is denoised, or warned about"
    )


def rendered_view(scene, there: bool):
    """Denoised and turned, or with its noise and a warning."""
    scene.iwis.viewport.denoise = True
    inside.show_rendered()
    inside.view_area().spaces.active.region_3d.view_perspective = "CAMERA"
    yield from inside.until(inside.converged, 600.0, "the rendered view")
    denoiser = inside.viewport().thread.denoiser
    inside.say(f"view: noise taken away: {denoiser.shows}; {denoiser.problem}")
    inside.expect(
        denoiser.shows == there and bool(denoiser.problem) != there, "the view is denoised"
    )
    yield from inside.screenshot(FOLDER / "view.png")
    restarts = inside.viewport().restarts
    scene.iwis.viewport.denoise = False
    yield 1.0
    yield from inside.until(inside.converged, 60.0, "the view with its noise")
    inside.expect(
        not denoiser.shows and inside.viewport().restarts == restarts, "turned off at once"
    )
    yield from inside.screenshot(FOLDER / "view-noisy.png")


def main():
    scene = inside.window_scene()
    scene.render.engine = "IWIS"
    path, problem = inside.module("denoiser").find_library()
    inside.say(f"library: {path or problem}")
    inside.areas("PROPERTIES")[0].spaces.active.context = "RENDER"
    yield 2.0
    yield from inside.screenshot(FOLDER / "box-off.png")
    yield from final_render(scene, bool(path))
    yield 1.0
    yield from inside.screenshot(FOLDER / "box.png")
    yield from rendered_view(scene, bool(path))
    inside.say("END")


inside.run(main())

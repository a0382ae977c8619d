"""What scripts that run in Blender's window share: steps that let Blender draw in between.

A script's main() is a generator: every ``yield SECONDS`` gives Blender's own loop that time, as if
a user paused. Lines that begin with ``IWIS-TEST`` are read by who started Blender.
"""

import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy


def words() -> list[str]:
    """What stands after -- on the command line."""
    return sys.argv[sys.argv.index("--") + 1 :]


def say(*parts) -> None:
    print("IWIS-TEST", *parts, flush=True)


def run(steps) -> None:
    """Let Blender's loop run the generator; leave with 0 at its end, with 3 at an error."""
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.filepaths.use_auto_save_temporary_files = False

    def step():
        try:
            return next(steps)
        except StopIteration:
            bpy.ops.wm.quit_blender()
        except BaseException:
            traceback.print_exc()
            sys.stdout.flush()
            os._exit(3)

    bpy.app.timers.register(step, first_interval=1.0, persistent=True)


def addon():
    """The add-on's viewport module, whatever Blender calls the package."""
    name = next(m for m in sys.modules if m.endswith("iwis.iwis_addon.viewport"))
    return sys.modules[name]


def window_scene():
    return bpy.context.window_manager.windows[0].scene


def areas(kind: str) -> list:
    screen = bpy.context.window_manager.windows[0].screen
    return [area for area in screen.areas if area.type == kind]


def view_area():
    return areas("VIEW_3D")[0]


def view_window_region(area=None):
    area = area or view_area()
    return next(region for region in area.regions if region.type == "WINDOW")


def show_rendered(engine: str = "IWIS") -> None:
    """The rendered view in the first 3D view, the render tab in the properties."""
    bpy.context.window_manager.windows[0].scene.render.engine = engine
    view_area().spaces.active.shading.type = "RENDERED"
    for area in areas("PROPERTIES"):
        area.spaces.active.context = "RENDER"


def viewport():
    """IWIS' own object for the rendered view; None where there is none."""
    living = addon().living()
    return living[0] if living else None


def until(condition, seconds: float, what: str):
    """Wait for something, with Blender's loop running; an error where it does not come."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            views = [(view.line(), view.restarts) for view in addon().living()]
            raise TimeoutError(f"{what} did not come within {seconds} s; views: {views}")
        yield 0.02


def converged():
    found = viewport()
    return found is not None and found.converged


def screenshot(path: Path) -> object:
    """Ask for a screenshot and wait until it is there: Blender's own is black in software."""
    say("SHOT", path)
    yield from until(Path(path).exists, 30.0, f"the screenshot {path}")
    yield 0.3


def module(name: str):
    return sys.modules[next(m for m in sys.modules if m.endswith(f"iwis.iwis_addon.{name}"))]


def expect(condition, what: str) -> None:
    if not condition:
        raise AssertionError(what)


def material(name: str, **inputs):
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    made.use_fake_user = True
    return made


def save(pixels, path: Path) -> None:
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("Preview", width, height, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def xdotool(*words) -> str:
    return subprocess.check_output(["xdotool", *words], text=True, timeout=20)


def press(key: str):
    """A real key on the window, with the mouse in it; when it was pressed."""
    window = xdotool("search", "--name", "Blender [0-9]").split()[0]
    xdotool("windowfocus", window, "mousemove", "400", "400")
    yield 0.5
    xdotool("mousemove", "410", "410")
    yield 0.5
    at = time.perf_counter()
    xdotool("key", key)
    return at

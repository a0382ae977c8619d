"""Run by Blender's window: previews beside Cycles', a button in one, a picked pixel, Escape in a
render.

blender STATUE.blend --python render_in_window.py -- FOLDER
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside
import numpy as np

FOLDER = Path(inside.words()[0])
ESCAPE_SECONDS = 0.2
# Of a preview's mean, by its kind: Cycles adds what the sphere and its floor reflect of each other.
DARKER, BRIGHTER = 0.3, 0.1


def lamp(kind: str):
    made = bpy.data.lights.new(kind.title(), kind)
    made.color = 1.0, 0.6, 0.3
    made.use_fake_user = True
    return made


def preview(data, engine: str):
    """Blender's preview of a material, world or light, float32 (h, w, 4), and its seconds."""
    inside.window_scene().render.engine = engine
    started = time.perf_counter()
    data.asset_generate_preview()
    yield 0.0
    yield from inside.until(
        lambda: not bpy.app.is_job_running("RENDER_PREVIEW"), 300.0, f"the preview of {data.name}"
    )
    seconds = time.perf_counter() - started
    width, height = data.preview.image_size
    pixels = np.array(data.preview.image_pixels_float, np.float32).reshape(height, width, 4)
    inside.save(pixels, FOLDER / f"preview-{data.name}-{engine}.png")
    return pixels, seconds


def previews():
    """Of materials, a world and lights: as bright as Cycles', and nothing told to the user."""
    world = inside.window_scene().world
    shown = [
        inside.material("Clay", Base_Color=(0.8, 0.1, 0.05, 1.0), Roughness=0.8),
        inside.material("Gold", Base_Color=(1.0, 0.7, 0.3, 1.0), Metallic=1.0, Roughness=0.3),
        inside.material("Lit", Emission_Color=(0.2, 0.5, 1.0, 1.0), Emission_Strength=1.0),
        world,
        *map(lamp, ("POINT", "SPOT", "AREA")),
    ]
    job = inside.module("job").RenderJob
    before = job.current
    for data in shown:
        theirs, their_seconds = yield from preview(data, "CYCLES")
        ours, seconds = yield from preview(data, "IWIS")
        means = [float(picture[..., :3].mean()) for picture in (ours, theirs)]
        inside.say(
            f"preview of {data.name}: mean {means[0]:.3f}, Cycles' {means[1]:.3f}; "
            f"{seconds:.2f} s, Cycles {their_seconds:.2f} s"
        )
        inside.expect(ours[..., :3].std() > 0.02, f"the preview of {data.name} shows something")
        low, high = 1.0 - DARKER, 1.0 + BRIGHTER
        inside.expect(low < means[0] / means[1] < high, f"the preview of {data.name} is as bright")
    inside.expect(job.current is before, "a preview leaves the user's last render alone")


def convert_in_a_preview():
    """A button that sets an engine while a preview renders: Blender goes on."""
    scene, before = inside.window_scene(), inside.window_scene().world
    scene.render.engine = "IWIS"
    for name in ("Jade", "Brass"):
        inside.material(name).asset_generate_preview()
    others = inside.module("callbacks")._others_inside
    yield from inside.until(others, 60.0, "a preview")
    started = time.perf_counter()
    bpy.ops.iwis.convert_world(height=64, samples=1)
    inside.say(f"a world converted while previews render: {time.perf_counter() - started:.2f} s")
    inside.expect(scene.world != before, "the world is converted")
    scene.world = before
    yield from inside.until(
        lambda: not bpy.app.is_job_running("RENDER_PREVIEW"), 300.0, "the end of the previews"
    )


def shot_of_tab(tab: str):
    """What the properties editor shows of the active object's material, or of the world."""
    area = inside.areas("PROPERTIES")[0]
    area.spaces.active.context = tab
    yield 2.0
    yield from inside.until(
        lambda: not bpy.app.is_job_running("RENDER_PREVIEW"), 300.0, f"the previews of {tab}"
    )
    yield 1.0
    yield from inside.screenshot(FOLDER / f"tab-{tab.lower()}.png")


def watch(lines: list):
    """Remember the lines that renders show."""
    sink = inside.module("sink").BlenderSink
    line = sink.line

    def wrapped(self, *arguments):
        lines.append(line(self, *arguments))
        return lines[-1]

    sink.line = wrapped


def start_render(scene):
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.render.render("INVOKE_DEFAULT", scene=scene.name)


def rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


def click_in_view():
    """Show Sampling of Pixel, called from another editor: the pixel clicked in a rendered view."""
    inside.show_rendered()
    inside.view_area().spaces.active.region_3d.view_perspective = "CAMERA"
    yield from inside.until(inside.converged, 300.0, "the rendered view")
    region, window = inside.view_window_region(), bpy.context.window_manager.windows[0]
    x, y = region.x + region.width // 2, region.y + region.height // 2
    with bpy.context.temp_override(window=window, area=inside.areas("PROPERTIES")[0]):
        bpy.ops.iwis.inspect_pixel("INVOKE_DEFAULT")
    yield 0.5
    name = inside.xdotool("search", "--name", "Blender [0-9]").split()[0]
    for shift in (10, 0):
        inside.xdotool("windowfocus", name, "mousemove", str(x + shift), str(window.height - 1 - y))
        yield 0.5
    inside.xdotool("click", "1")
    yield from inside.until(lambda: "IWIS Sampling" in bpy.data.images, 60.0, "the picked pixel")
    picked = window.modal_operators[-1] if window.modal_operators else None
    inside.expect(picked is None, "the click ends the operator")
    last = bpy.context.window_manager.operators[-1]
    inside.say(f"clicked pixel ({last.x}, {last.y}) of a view of {region.width}x{region.height}")
    middle = last.x - region.width // 2, last.y - region.height // 2
    inside.expect(last.source == "VIEW" and max(map(abs, middle)) <= 1, "the pixel is the mouse's")
    inside.view_area().spaces.active.shading.type = "SOLID"


def result(name: str):
    """The render result as a saved file has it."""
    path = FOLDER / f"{name}.png"
    bpy.data.images["Render Result"].save_render(str(path))
    image = bpy.data.images.load(str(path))
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)


def escape(scene):
    """A long render ended by Escape; one that ends by itself at once after it."""
    lines, ended = [], []
    watch(lines)
    bpy.app.handlers.render_cancel.append(lambda *_: ended.append(time.perf_counter()))
    preferences = bpy.context.preferences
    preferences.use_preferences_save = False  # the next script has the same folder
    preferences.view.render_display_type = "AREA"
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 512
    scene.render.resolution_x, scene.render.resolution_y = 800, 800
    start_render(scene)
    yield from inside.until(lambda: any("Remaining:" in each for each in lines), 600.0, "tiles")
    yield 1.0
    for name in ("compare_cycles", "convert_world", "bake_unsupported"):
        inside.expect(not getattr(bpy.ops.iwis, name).poll(), f"{name} is grey in a render")
    yield from inside.screenshot(FOLDER / "rendering.png")
    at = yield from inside.press("Escape")
    yield from inside.until(lambda: not rendering(), 30.0, "the end after Escape")
    gone = time.perf_counter() - at
    inside.say("line:", lines[-1])
    inside.expect("Time:" not in lines[-1], "the time above the picture is Blender's own")
    inside.say(f"Escape: render over in {ended[0] - at:.3f} s, Blender's job in {gone:.3f} s")
    inside.expect(ended[0] - at < ESCAPE_SECONDS, "Escape ends a render in time")
    kept = result("after-escape")
    filled = float((kept[:, 3] > 0.0).mean())
    inside.say(f"picture kept after Escape: {filled:.0%} of its pixels")
    inside.expect(0.0 < filled < 1.0, "the part that was rendered is kept")
    scene.iwis.stop_rule, scene.iwis.max_samples = "PERCEPTUAL", 16
    again = time.perf_counter()
    start_render(scene)
    yield from inside.until(lambda: not rendering(), 300.0, "the render after Escape")
    inside.say(f"the render at once after it: {time.perf_counter() - again:.2f} s")
    inside.expect((result("again")[:, 3] > 0.0).all(), "the render after Escape is whole")


def main():
    yield from previews()
    yield from convert_in_a_preview()
    scene = inside.window_scene()
    scene.render.engine = "IWIS"
    meshes = [each for each in scene.objects if each.type == "MESH" and each.data.materials]
    scene.view_layers[0].objects.active = meshes[0]
    yield 0.5
    for tab in ("MATERIAL", "WORLD"):
        yield from shot_of_tab(tab)
    yield from click_in_view()
    yield from escape(scene)
    inside.say("END")


inside.run(main())

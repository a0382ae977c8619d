"""Run by Blender's window: what the shading menu has the rendered view show, beside Cycles' view.

blender --python shading_in_window.py -- FOLDER [quick]

Each setting is shown by both engines; the parts of the screen are compared, once both are done.
Quick, IWIS shows a few alone, and no two of them alike: Cycles takes minutes.
"""

import itertools
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside
import numpy as np

FOLDER, QUICK = Path(inside.words()[0]), "quick" in inside.words()
# Cycles tells nobody when its view is done: when the screen stays as it is.
CYCLES_SECONDS, STILL_SECONDS = 300.0, 4.0
# Of display values, over blocks of the screen that average noise and edges.
MOST, BLOCK = 0.01, 32
REGION = [0, 0, 0, 0]  # of the screen: x, y, width, height of the view


def build(scene):
    """Things of all kinds on a floor, a lamp and a colored world."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    things = (
        (bpy.ops.mesh.primitive_plane_add, {"size": 12.0}, {"Base_Color": (0.5, 0.5, 0.5, 1.0)}),
        (
            bpy.ops.mesh.primitive_uv_sphere_add,
            {"location": (-1.5, 0.0, 1.0)},
            {"Metallic": 1.0, "Roughness": 0.5},
        ),
        (
            bpy.ops.mesh.primitive_cube_add,
            {"location": (1.5, 0.5, 1.0), "rotation": (0.0, 0.0, 0.5)},
            {"Base_Color": (0.8, 0.2, 0.1, 1.0), "Roughness": 0.6},
        ),
        (
            bpy.ops.mesh.primitive_uv_sphere_add,
            {"location": (0.2, -2.0, 0.4), "radius": 0.4},
            {"Emission_Color": (0.2, 0.5, 1.0, 1.0), "Emission_Strength": 0.5},
        ),
        (
            bpy.ops.mesh.primitive_cube_add,
            {"location": (2.5, -2.5, 0.6), "scale": (0.05, 0.8, 0.6)},
            {"Base_Color": (0.2, 0.6, 0.3, 1.0), "Alpha": 0.3},
        ),
    )
    for number, (add, place, inputs) in enumerate(things):
        add(**place)
        made = bpy.context.object
        made.data.materials.append(inside.material(f"Thing {number}", **inputs))
        if "sphere" in add.idname():
            made.data.shade_smooth()
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.color, lamp.location = 300.0, (1.0, 0.9, 0.6), (2.0, -3.0, 4.0)
    lamp.data.shadow_soft_size = 0.3
    scene.collection.objects.link(lamp)
    world = scene.world = bpy.data.worlds.new("World")
    world.color = (0.1, 0.3, 0.2)
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1.0)
    world.mist_settings.start, world.mist_settings.depth = 5.0, 10.0
    world.light_settings.distance = 2.0


def settle(scene):
    """Both engines as good as they are alike."""
    own, cycles = scene.iwis.viewport, scene.cycles
    own.max_samples, own.error_threshold, own.pixel_filter = 64, 0.1, "BOX"
    cycles.preview_samples, cycles.use_preview_adaptive_sampling = 128, False
    cycles.max_bounces, cycles.use_preview_denoising = 0, False
    cycles.pixel_filter_type = "BOX"
    scene.render.preview_pixel_size = "4"
    space = inside.view_area().spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    space.show_region_toolbar = space.show_region_ui = space.show_region_header = False
    view = space.region_3d
    view.view_perspective, view.view_distance = "PERSP", 9.0
    view.view_location = 0.0, 0.0, 0.8


# Name of the picture -> shading of Blender's own, and the pass; of UV Cycles' window shows black.
STUDIO = {"use_scene_world_render": False, "studiolight_background_alpha": 1.0}
CASES = {
    "as-rendered": ({}, "COMBINED"),
    "no-lights": ({"use_scene_lights_render": False}, "COMBINED"),
    "studio": (STUDIO, "COMBINED"),
    "studio-turned": (STUDIO | {"studiolight_rotate_z": 2.0}, "COMBINED"),
    "studio-strong-faint": (
        STUDIO | {"studiolight_intensity": 2.0, "studiolight_background_alpha": 0.3},
        "COMBINED",
    ),
    "studio-alone": (
        STUDIO | {"use_scene_lights_render": False, "studio_light": "sunset.exr"},
        "COMBINED",
    ),
} | {
    f"pass-{name.lower()}": ({}, name)
    for name in (
        "EMISSION BACKGROUND AO SHADOW_CATCHER DIFFUSE_DIRECT DIFFUSE_COLOR GLOSSY_DIRECT "
        "GLOSSY_COLOR POSITION NORMAL MIST DENOISING_ALBEDO DENOISING_NORMAL"
    ).split()
}
FEW = ("as-rendered", "no-lights", "studio", "studio-turned", "pass-normal", "pass-mist")
PLAIN = {
    "use_scene_lights_render": True,
    "use_scene_world_render": True,
    "studio_light": "city.exr",
    "studiolight_rotate_z": 0.0,
    "studiolight_intensity": 1.0,
    "studiolight_background_alpha": 1.0,
}


def shown(path: Path) -> np.ndarray:
    """Display values of the view's region on a screenshot, (h, w, 3)."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    columns, rows = image.size
    pixels = np.empty(columns * rows * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    x, y, width, height = REGION
    # The text in the upper corner is the engine's own.
    return pixels.reshape(rows, columns, 4)[y : y + height - 60, x : x + width, :3]


def still(name: str):
    """Wait until two screenshots, one after the other, show the same view."""
    path, before = FOLDER / "still.png", None
    deadline = time.perf_counter() + CYCLES_SECONDS
    while True:
        path.unlink(missing_ok=True)
        yield from inside.screenshot(path)
        now = shown(path)
        if before is not None and (now == before).all():
            return
        inside.expect(time.perf_counter() < deadline, f"Cycles is not done with {name}")
        before = now
        yield STILL_SECONDS


def picture(engine: str, name: str):
    """A screenshot of a case, once the engine is done with it."""
    space = inside.view_area().spaces.active
    settings, view_pass = CASES[name]
    for key, value in (PLAIN | settings).items():
        if getattr(space.shading, key) != value:
            setattr(space.shading, key, value)
    own = space.shading.iwis if engine == "IWIS" else space.shading.cycles
    own.render_pass = view_pass
    started = time.perf_counter()
    yield 0.3
    if engine == "IWIS":
        yield from inside.until(inside.converged, 300.0, f"the view of {name}")
        inside.expect(not inside.viewport().warnings, inside.viewport().warnings)
    else:  # of its pass, set by a script, Cycles is not told
        space.shading.type = "SOLID"
        yield 0.3
        space.shading.type = "RENDERED"
        yield STILL_SECONDS
        yield from still(name)
    path = FOLDER / f"{name}-{engine.lower()}.png"
    yield from inside.screenshot(path)
    inside.say(f"{path.name}: {time.perf_counter() - started:.1f} s")


def two_views():
    """Each has its own shading; a pass in false color leaves its picture as it is."""
    window, area = bpy.context.window_manager.windows[0], inside.view_area()
    for key, value in PLAIN.items():
        setattr(area.spaces.active.shading, key, value)
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield 0.5
    one, other = (each.spaces.active.shading for each in inside.areas("VIEW_3D"))
    one.iwis.render_pass, other.iwis.render_pass = "NORMAL", "COMBINED"
    one.type = other.type = "RENDERED"
    other.use_scene_world_render = other.use_scene_lights_render = False

    def both_done():
        views = inside.addon().living()
        return len(views) == 2 and all(view.converged for view in views)

    yield 0.5
    yield from inside.until(both_done, 300.0, "two views")
    views = inside.addon().living()
    found = {view.thread.picture.shown: len(view.thread.picture.layers) for view in views}
    inside.expect(found == {"normal": 5, "combined": 4}, found)
    yield from inside.screenshot(FOLDER / "two-views.png")
    restarts = [view.restarts for view in views]
    other.iwis.render_pass = "VISIBILITY"
    yield 1.0
    inside.expect(restarts == [view.restarts for view in views], "false color begins nothing anew")
    with bpy.context.temp_override(
        window=window, area=area, region=inside.view_window_region(area)
    ):
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name="VIEW3D_PT_shading", keep_open=True)
    yield 1.0
    yield from inside.screenshot(FOLDER / "menu.png")


def compare():
    """Every case of both engines, by blocks of the screen."""
    worst = {}
    for name in CASES:
        one, other = (shown(FOLDER / f"{name}-{engine}.png") for engine in ("iwis", "cycles"))
        worst[name] = float(np.abs(blocks(one) - blocks(other)).mean())
        inside.say(f"{name}: {worst[name]:.4f}, of a mean of {other.mean():.3f}")
    too_much = {name: value for name, value in worst.items() if value > MOST}
    inside.expect(not too_much, f"unlike Cycles: {too_much}")


def differ():
    """No two of the cases that IWIS has shown alone are alike."""
    pictures = {name: blocks(shown(FOLDER / f"{name}-iwis.png")) for name in FEW}
    for one, other in itertools.combinations(FEW, 2):
        by = float(np.abs(pictures[one] - pictures[other]).mean())
        inside.expect(by > MOST, f"{one} and {other} differ by {by:.4f}")


def blocks(pixels: np.ndarray) -> np.ndarray:
    """The means of square parts of a picture."""
    rows, columns = (size // BLOCK for size in pixels.shape[:2])
    parts = pixels[: rows * BLOCK, : columns * BLOCK].reshape(rows, BLOCK, columns, BLOCK, 3)
    return parts.mean(axis=(1, 3))


def main():
    FOLDER.mkdir(exist_ok=True)
    scene = inside.window_scene()
    build(scene)
    inside.show_rendered()
    inside.view_area().spaces.active.shading.type = "SOLID"
    settle(scene)
    yield 0.5
    region = inside.view_window_region()
    REGION[:] = region.x, region.y, region.width, region.height
    for engine in ("IWIS",) if QUICK else ("CYCLES", "IWIS"):
        inside.show_rendered(engine)
        yield 3.0
        for name in FEW if QUICK else CASES:
            yield from picture(engine, name)
    yield from two_views()
    differ() if QUICK else compare()
    inside.say("END")


inside.run(main())

"""Run by Blender's window: the panel Bake, bakes that go on beside the window, Escape in one.

blender STATUE.blend --python bake_in_window.py -- FOLDER
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside
import numpy as np
from mathutils import Vector

FOLDER = Path(inside.words()[0])
SIZE = 256
ESCAPE_SECONDS = 0.5


def floor(scene):
    """A floor under the statue, with an image to bake to, selected and active."""
    bpy.ops.mesh.primitive_plane_add(size=3.0)
    obj = bpy.context.object
    obj.name = "Baked floor"
    statue = [each for each in scene.objects if each.type == "MESH" and each is not obj]
    obj.location.z = min((each.matrix_world @ Vector(each.bound_box[0])).z for each in statue)
    tree = inside.material("Floor").node_tree
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = bpy.data.images.new("Baked", SIZE, SIZE, float_buffer=True)
    tree.nodes.active = target
    obj.data.materials.append(bpy.data.materials["Floor"])
    return target.image


def pixels(image) -> np.ndarray:
    """float32 (SIZE, SIZE, 4), and a picture of it for who looks."""
    found = np.empty((SIZE, SIZE, 4), np.float32)
    image.pixels.foreach_get(found.ravel())
    return found


def baking() -> bool:
    return bpy.app.is_job_running("OBJECT_BAKE")


def start_bake(kind: str) -> None:
    view = inside.view_area()
    window = bpy.context.window_manager.windows[0]
    region = inside.view_window_region(view)
    with bpy.context.temp_override(window=window, area=view, region=region):
        bpy.ops.object.bake("INVOKE_DEFAULT", type=kind)


def whole_bake(image, kind: str):
    """A bake to its end, while the window goes on; its picture."""
    started, turns = time.perf_counter(), 0
    start_bake(kind)
    while baking():
        turns += 1
        if time.perf_counter() - started > 300.0:
            raise TimeoutError(f"the bake of {kind} did not end")
        yield 0.02
    yield 0.2
    found = pixels(image)
    inside.save(found, FOLDER / f"bake-{kind.lower()}.png")
    seconds = time.perf_counter() - started
    inside.say(f"bake of {kind}: {seconds:.2f} s, mean {found[..., :3].mean():.4f}, {turns} turns")
    return found


def escape(scene, image):
    """A long bake ended by Escape, and one after it that ends by itself."""
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 4096
    start_bake("COMBINED")
    yield from inside.until(baking, 60.0, "the bake")
    yield 3.0
    inside.expect(baking(), "the bake goes on until Escape")
    yield from inside.screenshot(FOLDER / "baking.png")
    at = yield from inside.press("Escape")
    yield from inside.until(lambda: not baking(), 60.0, "the end after Escape")
    seconds = time.perf_counter() - at
    inside.save(pixels(image), FOLDER / "after-escape.png")
    inside.say(f"Escape: bake over in {seconds:.3f} s; mean {pixels(image)[..., :3].mean():.4f}")
    inside.expect(seconds < ESCAPE_SECONDS, "Escape ends a bake in time")
    scene.iwis.stop_rule, scene.iwis.max_samples = "PERCEPTUAL", 64


def shots_of_panel(scene):
    """The panel Bake of several kinds: first and open here, where users find it last and closed."""
    panels = inside.module("panels_bake")
    panels.unregister()
    for cls in panels.CLASSES:
        cls.bl_options = set()
    panels.IWIS_PT_bake.bl_order = -1
    panels.register()
    area = inside.view_area()
    area.type = "PROPERTIES"
    area.spaces.active.context = "RENDER"
    for kind in ("COMBINED", "NORMAL"):
        scene.iwis.bake_type = kind
        yield 1.0
        yield from inside.screenshot(FOLDER / f"panel-{kind.lower()}.png")
    area.type = "VIEW_3D"
    yield 0.5


def main():
    scene = inside.window_scene()
    scene.render.engine = "IWIS"
    image = floor(scene)
    scene.render.bake.margin = 0
    scene.render.resolution_x, scene.render.resolution_y = 64, 96
    inside.view_area().spaces.active.shading.type = "SOLID"
    yield from shots_of_panel(scene)
    before = yield from whole_bake(image, "COMBINED")
    inside.expect(before[..., :3].std() > 0.02, "the bake shows something")
    inside.show_rendered()
    yield from inside.until(inside.converged, 300.0, "the rendered view")
    yield from whole_bake(image, "AO")
    yield from escape(scene, image)
    again = yield from whole_bake(image, "COMBINED")
    inside.expect(np.abs(again - before).max() < 0.3, "the bake after Escape is whole")
    inside.say("END")


inside.run(main())

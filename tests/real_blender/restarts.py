"""What begins the rendered view's picture anew, how often, and what does not.

Steps of edit_in_window.py, in a fresh statue.blend.
"""

import time

import bpy
import edits
import inside
from edits import override, scene

SKY_SECONDS = 0.3  # that Blender may wait for an update while a sky is being rendered


def thing():
    return edits.meshes()[0]


def space():
    return inside.view_area().spaces.active


def add_empty():
    empty = bpy.data.objects.new("Empty", None)
    scene().collection.objects.link(empty)


def move_empty():
    bpy.data.objects["Empty"].location.x += 1.0


def other_active():
    bpy.context.view_layer.objects.active = bpy.data.objects["Empty"]


def click_with_the_mouse():
    """As a user: select by a click in the view's middle, nothing else."""
    region = inside.view_window_region()
    with override():
        place = region.width // 2, region.height // 2
        bpy.ops.view3d.select(location=place, deselect_all=True)


def rename():
    thing().name = "Renamed"


def final_setting():
    scene().iwis.max_samples = 77
    scene().iwis.stop_rule = "FIXED" if scene().iwis.stop_rule != "FIXED" else "PERCEPTUAL"


def output_settings():
    scene().render.filepath = "//elsewhere"
    scene().render.image_settings.file_format = "OPEN_EXR"


def overlays():
    space().overlay.show_overlays = not space().overlay.show_overlays


def gizmos():
    space().show_gizmo = not space().show_gizmo


def next_frame():
    scene().frame_set(scene().frame_current + 1)


def unused_material():
    bpy.data.materials.new("Unused").diffuse_color = (1.0, 0.0, 0.0, 1.0)


def camera_elsewhere():
    """The scene's camera, while the view is not through it."""
    scene().camera.location.x += 0.1
    scene().camera.data.lens += 1.0


def hide_from_renders():
    thing().hide_render = not thing().hide_render


def other_tab():
    inside.areas("PROPERTIES")[0].spaces.active.context = "OUTPUT"


def undo_push():
    with override():
        bpy.ops.ed.undo_push(message="nothing")


def move():
    thing().location.x += 0.1


def scale():
    thing().scale.z *= 0.9


def hide():
    thing().hide_viewport = not thing().hide_viewport


def set_input(name, value):
    shader = thing().active_material.node_tree.nodes["Diffuse BSDF"]
    shader.inputs[name].default_value = value


def color():
    set_input("Color", (0.7, 0.3, 0.2, 1.0))


def roughness():
    set_input("Roughness", 0.35)


def world():
    for node in scene().world.node_tree.nodes:
        if "Strength" in node.inputs:
            node.inputs["Strength"].default_value = 1.7


def samples():
    scene().iwis.viewport.max_samples += 1


def threshold():
    scene().iwis.viewport.error_threshold *= 0.9


def pixel_filter():
    now = scene().iwis.viewport.pixel_filter
    scene().iwis.viewport.pixel_filter = "BOX" if now != "BOX" else "CENTER"


def turn_view():
    with override():
        bpy.ops.view3d.view_orbit(angle=0.2, type="ORBITLEFT")


def lens():
    space().lens += 5.0


def through(way):
    def look():
        space().region_3d.view_perspective = way

    look.__name__ = f"view {way.lower()}"
    return look


def border():
    space().use_render_border = not space().use_render_border
    space().render_border_min_x, space().render_border_max_x = 0.2, 0.8
    space().render_border_min_y, space().render_border_max_y = 0.2, 0.8


def camera_border():
    scene().render.use_border = not scene().render.use_border
    scene().render.border_min_x, scene().render.border_max_x = 0.3, 0.7


def transparent_film():
    scene().render.film_transparent = not scene().render.film_transparent


def move_camera():
    scene().camera.location.x += 0.05


def add_lamp():
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.location = 0.0, -2.0, 2.0
    scene().collection.objects.link(lamp)


def lamp_power():
    bpy.data.lights["Lamp"].energy = 500.0


QUIET = [
    add_empty, edits.select_object, click_with_the_mouse, other_active, move_empty, rename,
    final_setting, output_settings, overlays, overlays, gizmos, gizmos, next_frame,
    unused_material, camera_elsewhere, hide_from_renders, hide_from_renders, other_tab, undo_push,
]  # fmt: skip
CHANGES = [
    move, scale, hide, hide, color, roughness, world, samples, threshold, pixel_filter, turn_view,
    lens, through("ORTHO"), border, border, through("CAMERA"), camera_border, camera_border,
    move_camera, through("PERSP"), transparent_film, transparent_film, add_lamp, lamp_power,
    edits.undo,
]  # fmt: skip


def check_restarts():
    """Each change alone, with the count of restarts that came of it: one, or none."""
    inside.show_rendered()
    through("PERSP")()
    scene().iwis.viewport.max_samples = 8  # each change waits for its picture
    yield from inside.until(inside.converged, 900.0, "the first picture")
    undo_push()
    counts = {}
    for wanted, some in ((0, QUIET), (1, CHANGES)):
        for edit in some:
            before = inside.viewport().restarts
            edit()
            if edit is not edits.undo:
                undo_push()
            yield 0.4
            yield from inside.until(inside.converged, 120.0, f"the picture after {edit.__name__}")
            count = inside.viewport().restarts - before
            counts.setdefault(edit.__name__, []).append(count)
            if min(count, 1) != wanted:
                raise AssertionError(f"{edit.__name__}: {count} restarts, expected {wanted}")
    for wanted, some in ((0, QUIET), (1, CHANGES)):
        names = dict.fromkeys(edit.__name__ for edit in some)
        said = ", ".join(f"{name} {counts[name]}" for name in names)
        inside.say("OK", "restart:" if wanted else "do not restart:", said)


def check_sky():
    """A sky's slider: Blender does not wait, the status says what is going on, the sky comes."""
    before, scene().world = scene().world, bpy.data.worlds.new("Sky")
    tree = scene().world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    longest, said = 0.0, set()
    for step in range(12):
        # never asked for before, by any run: else it would be found on disk
        sky.sun_elevation = 0.3 + 0.05 * step + time.time() % 1.0 * 1e-3
        yield 0.1
        longest = max(longest, inside.viewport().export_seconds)
        said.add("Sky Texture" in inside.viewport().line())
    if True not in said:
        raise AssertionError(f"the status says {inside.viewport().line()!r}")
    if longest > SKY_SECONDS:
        raise AssertionError(f"Blender waited {longest:.2f} s for an update")
    at = time.perf_counter()
    yield from inside.until(lambda: "Sky" not in inside.viewport().line(), 120.0, "the last sky")
    came = time.perf_counter() - at
    yield from inside.until(inside.converged, 120.0, "the picture of the sky")
    light = inside.viewport()._scene.environment
    if len(light.radiance) < 512:
        raise AssertionError(f"the light is a map of {light.radiance.shape}")
    inside.say(
        f"OK a sky's slider: Blender waits {longest:.3f} s at the most, the last sky comes "
        f"{came:.1f} s after it was let go"
    )
    scene().world = before

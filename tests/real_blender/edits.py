"""What a user does in Blender's window, each by chance where there is a choice.

The driver (edit_in_window.py) pushes an undo step after each edit.
"""

import random

import bpy
import inside

SEED, EDITS, FOLDER, OTHER = inside.words()
RANDOM = random.Random(int(SEED))
START = bpy.data.filepath


def scene():
    return bpy.context.window_manager.windows[0].scene


def override():
    area = inside.view_area()
    return bpy.context.temp_override(
        window=bpy.context.window_manager.windows[0],
        area=area,
        region=inside.view_window_region(area),
    )


def meshes():
    return [thing for thing in scene().objects if thing.type == "MESH"]


def pick():
    return RANDOM.choice(meshes() or [add_object()])


def add_object():
    with override():
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        mesh = bpy.ops.mesh
        kinds = [mesh.primitive_cube_add, mesh.primitive_monkey_add, bpy.ops.object.text_add]
        RANDOM.choice(kinds)(location=[RANDOM.uniform(-1.0, 1.0) for _ in range(3)])
        return bpy.context.object


def remove_object():
    if len(meshes()) > 1:
        bpy.data.objects.remove(pick())


def move_object():
    pick().location.x += RANDOM.uniform(-0.3, 0.3)


def turn_object():
    pick().rotation_euler.z += RANDOM.uniform(-1.0, 1.0)


def scale_object():
    pick().scale.z *= RANDOM.choice([0.8, 1.25, -1.0])


def hide_object():
    thing = pick()
    thing.hide_viewport = not thing.hide_viewport


def select_object():
    pick().select_set(RANDOM.random() < 0.5)


def add_modifier():
    thing = pick()
    if len(thing.modifiers) < 2:
        thing.modifiers.new("Array", RANDOM.choice(["ARRAY", "MIRROR", "WIREFRAME"]))
    else:
        thing.modifiers.clear()


def paint_object():
    material = bpy.data.materials.new("Painted")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    shader = material.node_tree.nodes.get("Principled BSDF")
    shader.inputs["Base Color"].default_value = (*(RANDOM.random() for _ in range(3)), 1.0)
    shader.inputs["Roughness"].default_value = RANDOM.random()
    thing = pick()
    thing.data.materials.clear()
    thing.data.materials.append(material)


def change_material():
    for material in bpy.data.materials:
        if material.node_tree is not None:
            for node in material.node_tree.nodes:
                for name in {"Color", "Base Color"} & set(node.inputs.keys()):
                    node.inputs[name].default_value = (RANDOM.random(), 0.5, 0.5, 1.0)


def change_world():
    if scene().world is None:
        scene().world = bpy.data.worlds[0]
    for node in scene().world.node_tree.nodes:
        if "Strength" in node.inputs:
            node.inputs["Strength"].default_value = RANDOM.uniform(0.2, 3.0)


def no_world():
    scene().world = None if scene().world is not None else bpy.data.worlds[0]


def change_settings():
    iwis = scene().iwis
    iwis.viewport.max_samples = RANDOM.choice([8, 32, 128])
    iwis.viewport.pixel_filter = RANDOM.choice(["CENTER", "BOX"])
    iwis.viewport.error_threshold = RANDOM.choice([0.1, 0.3, 0.5])
    iwis.seed = RANDOM.randrange(100)


def change_overlay():
    scene().iwis.viewport.overlay = RANDOM.choice(["COMBINED", "SAMPLES", "ERROR", "VISIBILITY"])


def change_film():
    scene().render.film_transparent = not scene().render.film_transparent
    scene().render.preview_pixel_size = RANDOM.choice(["AUTO", "1", "4"])


def orbit():
    view = inside.view_area().spaces.active.region_3d
    view.view_perspective = RANDOM.choice(["PERSP", "PERSP", "ORTHO", "CAMERA"])
    with override():
        bpy.ops.view3d.view_orbit(angle=RANDOM.uniform(-1.0, 1.0), type="ORBITLEFT")


def toggle_border():
    space = inside.view_area().spaces.active
    for owner, prefix in ((space, "render_border"), (scene().render, "border")):
        setattr(owner, f"use_{prefix}", RANDOM.random() < 0.5)
        low, high = sorted(RANDOM.random() for _ in range(2))
        for side, value in (("min_x", low), ("max_x", high), ("min_y", low), ("max_y", high)):
            setattr(owner, f"{prefix}_{side}", value)


def change_frame():
    scene().frame_set(RANDOM.randrange(1, 250))


def edit_mode():
    thing = pick()
    thing.hide_viewport = False
    bpy.context.view_layer.objects.active = thing
    with override():
        bpy.ops.object.mode_set(mode="OBJECT" if bpy.context.mode != "OBJECT" else "EDIT")
        if bpy.context.mode == "EDIT_MESH":
            bpy.ops.transform.translate(value=(0.1, 0.0, 0.0))


def instance_collection():
    empty = bpy.data.objects.new("Instance", None)
    group = bpy.data.collections.new("Group")
    group.objects.link(pick())
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    empty.location.y = RANDOM.uniform(-1.0, 1.0)
    scene().collection.objects.link(empty)


def local_view():
    with override():
        if bpy.ops.view3d.localview.poll():
            bpy.ops.view3d.localview()


def undo():
    with override():
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()


def redo():
    with override():
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()


def other_engine():
    scene().render.engine = RANDOM.choice(["BLENDER_WORKBENCH", "CYCLES"])


def other_shading():
    inside.view_area().spaces.active.shading.type = RANDOM.choice(["SOLID", "WIREFRAME"])


def resize_window():
    inside.say("RESIZE", RANDOM.randrange(700, 1280), RANDOM.randrange(500, 800))


def maximize_view():
    with override():
        bpy.ops.screen.screen_full_area()


def second_view():
    """Two rendered views at once, or one again."""
    views = inside.areas("VIEW_3D")
    with override():
        if len(views) > 1:
            bpy.ops.screen.area_close()
        elif bpy.ops.screen.area_split.poll():
            bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)


def final_render():
    scene().render.resolution_percentage = 10
    with override():
        bpy.ops.render.render("INVOKE_DEFAULT")


def load_file():
    bpy.ops.wm.open_mainfile(filepath=RANDOM.choice([START, OTHER]), load_ui=False)


OFTEN = [
    move_object, turn_object, scale_object, paint_object, change_material, change_world, orbit,
    select_object, undo, redo, change_settings,
]  # fmt: skip
SELDOM = [
    add_object, remove_object, hide_object, add_modifier, no_world, change_overlay, change_film,
    toggle_border, change_frame, edit_mode, instance_collection, local_view, other_engine,
    other_shading, resize_window, maximize_view, second_view, final_render, load_file,
]  # fmt: skip

"""Run by Blender's window: an extension's life, from the zip to its removal, with no trace left.

blender STATUE.blend --python life_in_window.py -- FOLDER IWIS.zip
"""

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside

FOLDER, ZIP = map(Path, inside.words()[:2])
MODULE = "bl_ext.user_default.iwis"


def is_ours(thing) -> bool:
    return "iwis" in (getattr(thing, "__module__", "") or "").lower().split(".")


def traces() -> dict[str, list]:
    """All of IWIS that Blender knows of now, but for what only names it in a file."""
    found = {"types": [name for name in dir(bpy.types) if "IWIS" in name]}
    found["operators"] = dir(bpy.ops.iwis)
    found["handlers"] = [
        f"{name}: {each.__name__}"
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
        for each in getattr(bpy.app.handlers, name)
        if is_ours(each)
    ]
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types)]
    found["properties"] = sorted(kind.__name__ for kind in kinds if hasattr(kind, "iwis"))
    found["panels"] = sorted(
        kind.__name__ for kind in kinds if "IWIS" in (getattr(kind, "COMPAT_ENGINES", None) or ())
    )
    found["menus"] = sorted(
        f"{kind.__name__}: {draw.__name__}"
        for kind in kinds
        for draw in getattr(getattr(kind, "draw", None), "_draw_funcs", ())
        if is_ours(draw)
    )
    found["presets"] = [path for path in bpy.utils.preset_paths("iwis/sampling") if "ext" in path]
    names = [thread.name for thread in threading.enumerate()]
    found["threads"] = sorted(name for name in names if name.startswith("iwis"))
    return found


def no_view() -> bool:
    return not any(name.startswith("iwis") for name in traces()["threads"])


def install():
    """As Preferences, Get Extensions, Install from Disk does."""
    done = bpy.ops.extensions.package_install_files(
        filepath=str(ZIP), repo="user_default", enable_on_install=True, overwrite=True
    )
    inside.expect(done == {"FINISHED"}, f"installing answered {done}")


def show():
    """The rendered view is there and ends."""
    inside.show_rendered()
    yield from inside.until(inside.converged, 900.0, "a picture of the rendered view")


def lives():
    """Installed, disabled while it renders, enabled, upgraded while it renders, removed."""
    nothing = traces()
    inside.expect(not any(nothing.values()), f"there before it was installed: {nothing}")
    install()
    yield from show()
    enabled = traces()
    inside.expect(all(enabled.values()), f"not all is there: {enabled}")
    inside.expect(len(enabled["operators"]) > 10, f"operators: {enabled['operators']}")
    for _ in range(2):
        inside.view_area().spaces.active.region_3d.view_distance *= 1.01
        yield 0.1
        bpy.ops.preferences.addon_disable(module=MODULE)
        yield from inside.until(no_view, 10.0, "the end of the threads")
        left = traces()
        inside.expect(left == nothing, f"left when disabled: {left}")
        bpy.ops.preferences.addon_enable(module=MODULE)
        yield from show()
        inside.expect(traces() == enabled, f"otherwise than before: {traces()} {enabled}")
    inside.say("OK disabled and enabled twice while it rendered:", sizes(enabled))
    yield from disabled_in_a_render()
    inside.view_area().spaces.active.region_3d.view_distance *= 1.01
    yield 0.1
    install()
    yield from show()
    inside.expect(traces() == enabled, f"otherwise after an upgrade: {traces()} {enabled}")
    inside.say("OK installed over itself while it rendered")


def disabled_in_a_render():
    """The render ends with it; Blender is told, and can render again."""

    def rendering():
        return bpy.app.is_job_running("RENDER")

    bpy.context.preferences.view.render_display_type = "NONE"
    scene = inside.window_scene()
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 4096
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from inside.until(rendering, 20.0, "the render")
    yield 2.0
    inside.expect(rendering(), "the render goes on until the add-on is disabled")
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield from inside.until(lambda: not rendering(), 10.0, "the end of Blender's job")
    bpy.ops.preferences.addon_enable(module=MODULE)
    scene.iwis.stop_rule, scene.iwis.max_samples = "PERCEPTUAL", 256
    yield from show()
    inside.say("OK disabled while a final render went on")


def sizes(found) -> str:
    return ", ".join(f"{len(each)} {name}" for name, each in found.items())


def remove():
    """Of the file system, too."""
    repositories = bpy.context.preferences.extensions.repos
    number = next(n for n, each in enumerate(repositories) if each.module == "user_default")
    done = bpy.ops.extensions.package_uninstall(repo_index=number, pkg_id="iwis")
    inside.expect(done == {"FINISHED"}, f"removing answered {done}")
    yield from inside.until(no_view, 10.0, "the end of the threads")
    left = traces()
    inside.expect(not any(left.values()), f"left when removed: {left}")
    folder = Path(bpy.utils.user_resource("EXTENSIONS"))
    files = [path for path in folder.rglob("*") if "iwis" in path.name.lower()]
    inside.expect(not files, f"files left when removed: {files}")
    inside.say("OK removed: nothing is left, in Blender or on disk")


def presets():
    """The three that come with it, one's own added and removed."""
    iwis = inside.window_scene().iwis
    seen = set()
    for path in sorted(Path(bpy.utils.preset_paths("iwis/sampling")[0]).glob("*.py")):
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname="IWIS_PT_sampling_presets")
        seen.add((path.stem, iwis.estimator, iwis.max_samples))
    inside.expect(len(seen) == 3, f"presets: {seen}")
    iwis.max_samples = 123
    bpy.ops.iwis.sampling_preset_add(name="Own")
    own = [p for f in bpy.utils.preset_paths("iwis/sampling") for p in Path(f).glob("Own.py")]
    inside.expect(len(own) == 1 and "123" in own[0].read_text(), f"one's own preset: {own}")
    iwis.max_samples = 5
    bpy.ops.script.execute_preset(filepath=str(own[0]), menu_idname="IWIS_PT_sampling_presets")
    inside.expect(iwis.max_samples == 123, "one's own preset is used")
    bpy.ops.iwis.sampling_preset_add(name="Own", remove_active=True)
    inside.expect(not own[0].exists(), "one's own preset is removed")
    inside.say("OK presets:", sorted(seen))


def undo_of_operators():
    """What changes data is one step back."""
    scene = inside.window_scene
    tree = scene().world.node_tree

    def world():
        return scene().world.name

    def overlay():
        return scene().iwis.viewport.overlay

    def seed():
        return scene().iwis.seed

    scene().cycles.seed = 4321
    del tree
    steps = [
        (world, lambda: bpy.ops.iwis.convert_world("EXEC_DEFAULT", True, height=16, samples=1)),
        (overlay, lambda: bpy.ops.iwis.view_overlay("EXEC_DEFAULT", True, overlay="SAMPLES")),
        (seed, lambda: bpy.ops.iwis.copy_cycles_settings("EXEC_DEFAULT", True)),
    ]
    for value, operator in steps:
        area = inside.view_area()
        window = bpy.context.window_manager.windows[0]
        with bpy.context.temp_override(
            window=window, area=area, region=inside.view_window_region(area)
        ):
            bpy.ops.ed.undo_push(message="before")
            before = value()
            done = operator()
            inside.expect(
                done == {"FINISHED"} and value() != before, f"{value.__name__} has changed"
            )
            bpy.ops.ed.undo()
        yield 0.2
        inside.expect(value() == before, f"undo of {value.__name__}: {value()}, before {before}")
    inside.say("OK undo of", ", ".join(value.__name__ for value, _ in steps))


def main():
    bpy.context.preferences.use_preferences_save = False
    yield from lives()
    presets()
    yield from undo_of_operators()
    yield from remove()
    inside.say("END")


inside.run(main())

"""Run by Blender's window: rules of restarting, then random edits while the rendered view renders.

blender STATUE.blend --python edit_in_window.py -- SEED EDITS FOLDER OTHER.blend
"""

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import edits
import inside
from edits import EDITS, OFTEN, RANDOM, SELDOM, START, override, scene
from restarts import check_restarts, check_sky


def back_to_iwis():
    """As a user who goes back to work after a look at another engine."""
    if scene().render.engine != "IWIS":
        scene().render.engine = "IWIS"
    inside.view_area().spaces.active.shading.type = "RENDERED"


def edit_at_random():
    # Every kind comes, and most of them are small changes.
    count = int(EDITS)
    weights = [3] * len(OFTEN) + [1] * len(SELDOM)
    chosen = [*SELDOM, *RANDOM.choices(OFTEN + SELDOM, weights, k=count)]
    chosen = chosen[:count] if count > len(SELDOM) else RANDOM.sample(chosen, count)
    RANDOM.shuffle(chosen)
    for number, edit in enumerate(chosen):
        print(f"edit {number}: {edit.__name__}", flush=True)
        back_to_iwis()
        edit()
        if edit not in (edits.undo, edits.redo, edits.load_file):
            with override():
                if bpy.ops.ed.undo_push.poll():
                    bpy.ops.ed.undo_push(message=edit.__name__)
        yield RANDOM.choice([0.02, 0.1, 0.3])
        for found in inside.addon().living():
            failed = found.failure or found.thread.failure
            if failed:
                raise AssertionError(f"after {edit.__name__}: {failed}")
    inside.say("OK", count, "edits, and the view still renders")


def check_the_end():
    """A view that shows something else is forgotten; the file as it was saved converges again."""
    for area in inside.areas("VIEW_3D"):
        area.spaces.active.shading.type = "SOLID"
    yield from inside.until(lambda: not inside.addon().living(), 10.0, "the end of the views")
    bpy.ops.wm.open_mainfile(filepath=START, load_ui=False)
    back_to_iwis()
    yield 1.0
    yield from inside.until(inside.converged, 120.0, "the last picture")
    if not inside.viewport().thread.picture.layers["combined"][..., :3].mean() > 0.0:
        raise AssertionError("the last picture is black")
    names = [thread.name for thread in threading.enumerate()]
    views = names.count("iwis-view")
    if views > len(inside.areas("VIEW_3D")):
        raise AssertionError(f"{views} threads of rendered views are left: {names}")
    inside.say("OK", "no thread is left over")


def main():
    yield from check_restarts()
    yield from check_sky()
    bpy.ops.wm.open_mainfile(filepath=START, load_ui=False)
    yield 1.0
    yield from edit_at_random()
    yield from check_the_end()
    inside.say("END")


inside.run(main())

"""Run by Blender's window: how long a change takes to be seen, and pictures a second in an orbit.

    blender --python measure_in_window.py -- FOLDER [TRIANGLES]

Prints one line a change: seconds from the change to its first picture on the screen, of which the
export (Blender waits for it) and the thread's first picture; then the orbit's figures.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside
import numpy as np
from mathutils import Quaternion

TRIANGLES = int(inside.words()[1]) if len(inside.words()) > 1 else 1_000_000


def grid(name: str, triangles: int):
    """A hilly square of so many triangles."""
    side = max(int((triangles / 2) ** 0.5), 1)
    x, y = np.meshgrid(np.linspace(-3, 3, side + 1), np.linspace(-3, 3, side + 1))
    z = 0.3 * np.sin(3.0 * x) * np.cos(2.0 * y) + 0.05 * np.sin(25.0 * x) * np.sin(25.0 * y)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    faces = corner[:, None] + np.array([0, 1, side + 2, side + 1])
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([], [], [])
    mesh.vertices.add(x.size)
    mesh.attributes["position"].data.foreach_set(
        "vector", np.stack([x, y, z], -1).astype(np.float32).ravel()
    )
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel().astype(np.int32))
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def until_seen(change, name: str):
    """Seconds from a change until its first picture has been drawn."""
    viewport = inside.viewport()
    before = viewport.thread.version
    started = time.perf_counter()
    change()
    yield from inside.until(lambda: viewport.thread.version > before, 120.0, name)
    there, thread = time.perf_counter() - started, viewport.thread
    inside.say(
        f"{name:28s} {there:.3f} s with Blender's drawing; IWIS' part: export "
        f"{viewport.export_seconds:.3f} s, first picture {thread.first_seconds:.3f} s"
    )
    yield from inside.until(inside.converged, 300.0, f"the end of {name}")


def orbit(seconds: float, name: str):
    """Turn the view as fast as Blender draws: pictures a second, every one after its turn."""
    viewport, view = inside.viewport(), inside.view_area().spaces.active.region_3d
    began, version = time.perf_counter(), viewport.thread.version
    times, firsts = [], []
    while time.perf_counter() - began < seconds:
        seen = viewport.thread.version
        view.view_rotation = Quaternion((0.0, 0.0, 1.0), 0.02) @ view.view_rotation
        at = time.perf_counter()
        while viewport.thread.version == seen and time.perf_counter() - at < 5.0:
            yield 0.0
        times.append(time.perf_counter() - at)
        firsts.append(viewport.thread.first_seconds)
    first = float(np.median(firsts))
    seen = (viewport.thread.version - version) / (time.perf_counter() - began)
    inside.say(
        f"orbit of {name}: {len(times)} turns, median {np.median(times):.3f} s drawn in "
        f"software, {seen:.1f} pictures a second; IWIS' part: "
        f"median {first:.3f} s, longest {max(firsts):.3f} s, {1.0 / first:.0f} pictures a second"
    )


def drag(thing, steps: int, name: str):
    """Move an object again as soon as its last place was seen: what each picture takes."""
    viewport, times, parts = inside.viewport(), [], []
    for step in range(steps):
        seen, at = viewport.thread.version, time.perf_counter()
        thing.location.y = 0.02 * step
        while viewport.thread.version == seen and time.perf_counter() - at < 5.0:
            yield 0.0
        times.append(time.perf_counter() - at)
        parts.append(viewport.export_seconds + viewport.thread.first_seconds)
    inside.say(
        f"drag {name}: {steps} moves, median {np.median(times):.3f} s drawn in software; IWIS' "
        f"part: median {np.median(parts):.3f} s, longest {max(parts):.3f} s"
    )
    at = time.perf_counter()
    yield from inside.until(inside.converged, 300.0, f"the end of dragging {name}")
    inside.say(f"converged {time.perf_counter() - at:.2f} s after it")


def draw_seconds() -> float:
    """What Blender takes to draw its window once, whoever renders."""
    started = time.perf_counter()
    bpy.ops.wm.redraw_timer(type="DRAW_WIN", iterations=3)
    return (time.perf_counter() - started) / 3


def main():
    scene = bpy.context.scene
    inside.view_area().spaces.active.overlay.show_overlays = False  # slow in software
    yield 0.5
    inside.say(f"Blender draws its window, solid view, in {draw_seconds():.3f} s")
    inside.show_rendered()
    cube = bpy.data.objects["Cube"]
    material = bpy.data.materials.new("Plain")
    cube.data.materials.clear()
    cube.data.materials.append(material)
    yield from inside.until(inside.converged, 900.0, "the first picture")
    region = inside.view_window_region()
    inside.say(f"view of {region.width} x {region.height} pixels, Blender {bpy.app.version_string}")
    background = scene.world.node_tree.nodes["Background"]
    shader = material.node_tree.nodes["Principled BSDF"]

    def set_view(way):
        inside.view_area().spaces.active.region_3d.view_perspective = way

    changes = [
        ("move the cube", lambda: setattr(cube.location, "x", cube.location.x + 0.1)),
        ("roughness", lambda: setattr(shader.inputs["Roughness"], "default_value", 0.3)),
        ("world strength", lambda: setattr(background.inputs["Strength"], "default_value", 2.0)),
        ("camera view", lambda: set_view("CAMERA")),
        ("perspective view", lambda: set_view("PERSP")),
        ("a setting", lambda: setattr(scene.iwis.viewport, "max_samples", 48)),
    ]
    for name, change in changes:
        yield from until_seen(change, name)
    yield from orbit(4.0, "the cube")
    hills = grid("Hills", TRIANGLES)
    yield from until_seen(lambda: None, f"add {TRIANGLES} triangles")
    yield from orbit(6.0, f"{TRIANGLES} triangles")
    yield from inside.until(inside.converged, 300.0, "rest")
    yield from until_seen(lambda: setattr(cube.location, "x", 0.5), "move the cube among them")
    yield from until_seen(lambda: setattr(hills.location, "z", 0.1), "move the triangles")
    yield from drag(cube, 25, "the cube among them")
    yield from drag(hills, 25, "the triangles")
    yield from until_seen(
        lambda: setattr(shader.inputs["Roughness"], "default_value", 0.6), "a material among them"
    )
    inside.say("END")


inside.run(main())

"""Part "export": what a picture costs before the core has it, and how much memory instances take.

    python benchmarks/bench_export.py FOLDER [--quick]       all: writes FOLDER/export.json
    python benchmarks/bench_export.py --case CASE VALUE      one, as JSON: a process of its own

An export is timed as a render has it: Blender has evaluated the scene, and keeps nothing that it
derives when it is asked. The next frame's graph is a new one, whose meshes were copied anew.
"""

from __future__ import annotations

import gc
import time
from pathlib import Path

import bpy
import numpy as np
from apart import in_own_process, run_cases
from bench_scaling import peak_bytes, resident_bytes

import iwis
from iwis.core.render_cache import RenderCache
from iwis.iwis_addon.export import ExportCache, export_scene

REPEATS = 5
FULL = {"triangles": 2_000_000, "objects": 10_000, "instances": 300_000}
QUICK = {"triangles": 20_000, "objects": 200, "instances": 2_000}


def main() -> None:
    """One case or all."""
    run_cases("Measure exports; the number of threads is Blender's own.", CASES, "export", _all)


def _all(quick: bool) -> dict:
    wanted = QUICK if quick else FULL
    return {name: in_own_process(__file__, name, wanted[size]) for name, (size, _) in PLAN.items()}


def of_triangles(count: int) -> dict:
    """One object with UVs, custom normals and an image on them; then a frame without a change."""
    grid(new_scene(), count)
    return _two_frames(lambda: None)


def of_moving_triangles(count: int) -> dict:
    """The same beside a small object that moves."""
    scene = new_scene()
    grid(scene, count)
    box = add_object(scene, cube("Box"), "Box")
    return _two_frames(lambda: setattr(box.location, "z", box.location.z + 0.5))


def of_objects(count: int) -> dict:
    """Objects with a mesh each; one of them moves."""
    scene = new_scene()
    for k in range(count):
        add_object(scene, cube(f"Box{k}"), f"Box{k}").location = k % 100, k // 100, 0.0
    return _two_frames(lambda: _step(scene))


def of_linked_objects(count: int) -> dict:
    """Objects that share one mesh; one of them moves."""
    scene, mesh = new_scene(), cube("Box")
    for k in range(count):
        add_object(scene, mesh, f"Box{k}").location = k % 100, k // 100, 0.0
    return _two_frames(lambda: _step(scene))


def _step(scene):
    scene.objects["Box0"].location.z += 0.5


def of_instances(count: int) -> dict:
    """Instances of geometry nodes: seconds, and the memory of table and hierarchy."""
    scene = new_scene()
    scatter(scene, count)
    graph = bpy.context.evaluated_depsgraph_get()
    gc.collect()
    before = resident_bytes()
    Path("/proc/self/clear_refs").write_text("5")  # forget the peak so far
    found = _timed(graph, cache := ExportCache())
    mesh = cache.mesh
    found["peak_bytes"] = peak_bytes() - before
    gc.collect()
    found["table_bytes"] = sum(getattr(mesh, name).nbytes for name in mesh.__slots__)
    found["export_bytes"] = resident_bytes() - before
    RenderCache().accel(mesh)  # kernels and libraries, whose memory is not asked
    gc.collect()
    kept, with_export = RenderCache(), resident_bytes()
    Path("/proc/self/clear_refs").write_text("5")
    kept.accel(mesh)
    found["bvh_bytes"] = resident_bytes() - with_export
    found["bvh_peak_bytes"] = peak_bytes() - with_export
    return found


PLAN = {
    "triangles": ("triangles", of_triangles),
    "moving_triangles": ("triangles", of_moving_triangles),
    "objects": ("objects", of_objects),
    "linked_objects": ("objects", of_linked_objects),
    "instances": ("instances", of_instances),
}
CASES = {name: case for name, (_, case) in PLAN.items()}


def _two_frames(change) -> dict:
    """Medians of the first frame's export and of the one after ``change``, after a first of all."""
    export(bpy.context.evaluated_depsgraph_get(), ExportCache())
    first, second = [], []
    for _ in range(REPEATS):
        cache = ExportCache()
        first.append(_timed(_new_graph(), cache))
        change()
        second.append(_timed(_new_graph(), cache))
    return _medians(first) | {f"next_{name}": v for name, v in _medians(second).items()}


def _medians(runs: list[dict]) -> dict:
    """The run of the median CPU time: both its figures."""
    return sorted(runs, key=lambda run: run["cpu"])[len(runs) // 2]


def _new_graph():
    """A graph that has just copied every mesh, as a render's is."""
    for mesh in bpy.data.meshes:
        mesh.update_tag()
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    return graph


def _timed(graph, cache) -> dict:
    gc.collect()
    cpu, wall = time.process_time(), time.perf_counter()
    scene = export(graph, cache)
    found = {"cpu": time.process_time() - cpu, "wall": time.perf_counter() - wall}
    mesh = scene.mesh
    return found | {"triangles": len(mesh.triangles), "objects": len(scene.object_pass_index)}


def export(graph, cache):
    """As a final render does."""
    return export_scene(graph, warnings=[], cache=cache)


def new_scene():
    """An empty one with a camera and IWIS."""
    iwis.register()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "IWIS"
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    return scene


def add_object(scene, data, name):
    """Put data into the scene."""
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    return obj


def cube(name):
    """A cube of 12 triangles."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.5
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners.tolist(), [], faces)
    return mesh


def grid(scene, count):
    """A bumpy square of quads, count triangles, with a UV map, custom normals and an image."""
    side = max(round((count / 2) ** 0.5), 2)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side, y_subdivisions=side, calc_uvs=True)
    mesh = bpy.context.object.data
    xyz = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", xyz)
    xyz[2::3] = 0.05 * np.sin(20.0 * xyz[0::3]) * np.cos(20.0 * xyz[1::3])
    mesh.vertices.foreach_set("co", xyz)
    mesh.shade_smooth()
    normals = np.stack([xyz[0::3], xyz[1::3], np.ones(len(xyz) // 3)], -1)
    mesh.normals_split_custom_set_from_vertices(normals)
    mesh.materials.append(textured())


def textured():
    """A material with an image on the active UV map."""
    material = bpy.data.materials.new("Painted")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = material.node_tree
    image = bpy.data.images.new("Image", 64, 64)
    image.generated_type = "COLOR_GRID"
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return material


def scatter(scene, count):
    """A geometry-nodes object with cubes at so many points."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    side = max(round(count**0.5), 2)
    nodes, links = tree.nodes, tree.links
    base, box = nodes.new("GeometryNodeMeshGrid"), nodes.new("GeometryNodeMeshCube")
    for name in ("Vertices X", "Vertices Y"):
        base.inputs[name].default_value = side
    for name in ("Size X", "Size Y"):
        base.inputs[name].default_value = float(side)
    box.inputs["Size"].default_value = 0.3, 0.3, 0.6
    put, out = nodes.new("GeometryNodeInstanceOnPoints"), nodes.new("NodeGroupOutput")
    links.new(base.outputs["Mesh"], put.inputs["Points"])
    links.new(box.outputs["Mesh"], put.inputs["Instance"])
    links.new(put.outputs["Instances"], out.inputs[0])
    mesh = bpy.data.meshes.new("Scatter")
    add_object(scene, mesh, "Scatter").modifiers.new("Scatter", "NODES").node_group = tree


if __name__ == "__main__":
    main()

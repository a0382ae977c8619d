"""Run by blender --background: every operator from a script, and what each poll says.

blender -b STATUE.blend --python-exit-code 4 --python operators_in_background.py -- FOLDER
"""

import sys
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])


def expect(condition, what: str) -> None:
    if not condition:
        raise AssertionError(what)


def refused(operator, **options) -> str:
    """The poll's own words."""
    expect(not operator.poll(), f"{operator.idname()} can be called")
    try:
        operator(**options)
    except RuntimeError as error:
        return str(error).strip().splitlines()[-1].rpartition("poll() ")[2]
    raise AssertionError(f"{operator.idname()} was called")


def run(operator, **options) -> None:
    expect(operator.poll(), f"{operator.idname()} cannot be called")
    done = operator(**options)
    expect(done == {"FINISHED"}, f"{operator.idname()} answered {done}")
    print("IWIS-TEST OK", operator.idname(), options, flush=True)


def main() -> None:
    scene, iwis = bpy.context.scene, bpy.ops.iwis
    scene.render.engine = "IWIS"
    scene.render.resolution_percentage, scene.iwis.max_samples = 10, 8
    for operator in (iwis.save_film, iwis.false_color, iwis.copy_warnings, iwis.select_warned):
        print("IWIS-TEST before a render:", operator.idname(), refused(operator), flush=True)
    run(iwis.copy_cycles_settings)
    scene.iwis.max_samples, scene.iwis.stop_rule = 8, "PERCEPTUAL"
    scene.iwis.keep_film = True
    odd = bpy.data.materials.new("Odd")
    tree = odd.node_tree
    portal = tree.nodes.new("ShaderNodeBsdfRayPortal")
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(portal.outputs[0], output.inputs["Surface"])
    thing = next(each for each in scene.objects if each.type == "MESH")
    thing.data.materials[0] = odd
    bpy.ops.render.render()
    run(iwis.select_warned, number=0)
    expect(thing.select_get(), "the object that a warning names is selected")
    print("IWIS-TEST in background:", refused(iwis.copy_warnings), flush=True)
    for layer in ("samples", "error", "visibility"):
        run(iwis.false_color, layer=layer)
        expect(f"IWIS {layer.capitalize()}" in bpy.data.images, f"image of {layer}")
    film = FOLDER / "film.exr"
    run(iwis.save_film, filepath=str(film))
    expect(film.stat().st_size > 1000, "the film is a file")
    run(iwis.inspect_pixel, x=10, y=20, height=64)
    expect("IWIS Sampling" in bpy.data.images, "image of a pixel")
    run(iwis.view_overlay, overlay="SAMPLES")
    run(iwis.bake_tables)
    run(iwis.compare_cycles, samples=4)
    expect(bpy.data.images["IWIS Difference to Cycles"]["mre"] > 0.0, "a mean relative error")
    run(iwis.convert_world, height=16, samples=1)
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    pattern = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(pattern.outputs["Color"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    thing.data.materials[0] = bpy.data.materials.new("Plain")
    bpy.ops.mesh.primitive_plane_add()  # has a UV map
    bpy.context.object.data.materials.append(odd)
    run(iwis.bake_unsupported, size=16, samples=1)
    run(iwis.clear_cache)
    scene.camera = scene.world = None
    for operator in (iwis.compare_cycles, iwis.inspect_pixel, iwis.convert_world):
        print("IWIS-TEST no camera, no world:", operator.idname(), refused(operator), flush=True)
    print("IWIS-TEST END", flush=True)


main()

"""Images and lamps that export makes for a moment: Blender must get over them."""

import subprocess
import sys

import bpy
import pytest
from parity.scene import Tree

from support.iwis_render import use_format

SECONDS = 280  # the first render on a machine compiles the kernels
ANIMATE = "import bpy, iwis; iwis.register(); bpy.ops.wm.open_mainfile(filepath={!r}); "
ANIMATE += "bpy.ops.render.render(animation=True); import os; os._exit(0)"


def _painted(tree, folder):
    """An image of fractional alpha, and one in another space, on disk."""
    for name, alpha, space in (("half", 0.5, "sRGB"), ("wide", 1.0, "Linear Rec.2020")):
        image = bpy.data.images.new(name, 8, 8, alpha=True)
        image.pixels.foreach_set([0.5, 0.4, 0.2, alpha] * 64)
        image.filepath_raw, image.file_format = str(folder / f"{name}.png"), "PNG"
        image.save()
        image.colorspace_settings.name = space
        yield tree.made("ShaderNodeTexImage", 0, image=image)


@pytest.mark.slow
def test_frames_of_an_animation_with_images_and_black_bodies(cube_scene, tmp_path):
    """In a process of its own, for Blender 5.2 ended with a crash at the second frame."""
    material = bpy.data.materials.new("Painted")
    if material.node_tree is None:
        material.use_nodes = True
    tree = Tree(material.node_tree)
    first, second = _painted(tree, tmp_path)
    glow = tree.made("ShaderNodeBlackbody", 0, {"Temperature": 4000.0})
    inputs = {"Base Color": first, "Specular Tint": second, "Emission Color": glow}
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs | {"Emission Strength": 0.1}))
    for obj in cube_scene.objects:
        if obj.type == "MESH":
            obj.data.materials.clear()
            obj.data.materials.append(material)
    cube_scene.frame_end = 3
    use_format(cube_scene, "PNG")
    cube_scene.render.filepath = str(tmp_path / "frame_")
    path = str(tmp_path / "painted.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    command = [sys.executable, "-c", ANIMATE.format(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    assert done.returncode == 0, done
    assert len(list(tmp_path.glob("frame_*.png"))) == 3

"""A window's export when another frame is shown, and nothing else has changed."""

import dataclasses

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.same import same
from support.live_window import Window


@pytest.fixture
def window(cube_scene, monkeypatch):
    window = Window(monkeypatch)
    bpy.context.view_layer.update()
    window.export(bpy.data.objects["Cube"].update_tag)
    return window


def add_sequence(tree, kind: str, target, folder):
    """An image that is darker in frame 2, linked to an input of a node."""
    for frame, value in ((1, 0.9), (2, 0.2)):
        picture = bpy.data.images.new("Frame", 4, 2, float_buffer=True)
        picture.pixels.foreach_set(np.full(4 * 2 * 4, value, np.float32))
        picture.filepath_raw, picture.file_format = str(folder / f"f{frame}.exr"), "OPEN_EXR"
        picture.save()
        bpy.data.images.remove(picture)
    node = tree.nodes.new(kind)
    node.image = bpy.data.images.load(str(folder / "f1.exr"))
    node.image.source = "SEQUENCE"
    node.image_user.frame_start, node.image_user.frame_duration = 1, 2
    node.image_user.use_auto_refresh = True
    tree.links.new(node.outputs["Color"], target)


def of_world(folder):
    tree = bpy.context.scene.world.node_tree
    background = tree.nodes["Background"].inputs["Color"]
    add_sequence(tree, "ShaderNodeTexEnvironment", background, folder)


def of_material(folder):
    material = bpy.data.materials.new("Shown")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    bpy.data.objects["Cube"].data.materials.append(material)
    tree = material.node_tree
    color = tree.nodes["Principled BSDF"].inputs["Base Color"]
    add_sequence(tree, "ShaderNodeTexImage", color, folder)


def of_attribute(_folder):
    tree = bpy.context.scene.world.node_tree
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = "VIEW_LAYER", "frame_current"
    tree.links.new(node.outputs["Fac"], tree.nodes["Background"].inputs["Strength"])


@pytest.mark.parametrize("shading", [of_world, of_material, of_attribute])
def test_shading_that_depends_on_the_frame_follows_it(window, shading, tmp_path):
    """Blender tells of no world and no material when only their images are of another frame."""
    scene = bpy.context.scene
    before = window.export(lambda: (scene.frame_set(1), shading(tmp_path)))[0]
    after = window.export(lambda: scene.frame_set(2))[0]
    assert not same(before, after)
    expected = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
    assert same(dataclasses.replace(after, object_to_world=None), expected)


def test_a_frame_changes_no_other_shading(window):
    """Nothing is read anew where nothing depends on it."""
    before = window.export(bpy.data.objects["Cube"].update_tag)[0]
    scene = bpy.context.scene
    assert same(window.export(lambda: scene.frame_set(scene.frame_current + 1))[0], before)

"""A window's export reads what has changed, nothing else, and is what an export from scratch is."""

import dataclasses

import bpy
import numpy as np
import pytest
from parity.element_cases import add_curves, add_particle_hair, add_points, bent_strands

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.same import same
from support.above import add_monkey
from support.live_window import Window


@pytest.fixture
def window(cube_scene, monkeypatch):
    add_monkey()
    window = Window(monkeypatch)
    bpy.context.view_layer.update()
    window.export(bpy.data.objects["Cube"].update_tag)
    return window


def move():
    bpy.data.objects["Cube"].location.x += 0.5


def bend():
    mesh = bpy.data.objects["Cube"].data
    mesh.vertices[0].co.z += 0.5
    mesh.update()


def add_modifier():
    bpy.data.objects["Cube"].modifiers.new("Array", "ARRAY")


def paint():
    material = bpy.data.materials.new("Red")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 0, 0, 1)
    bpy.data.objects["Cube"].data.materials.append(material)


def brighten():
    tree = bpy.context.scene.world.node_tree
    tree.nodes["Background"].inputs["Strength"].default_value = 3.0


def add_lamp():
    obj = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(obj)
    return obj


def move_lamp():
    bpy.data.objects["Lamp"].location.z += 1.0


def dim_lamp():
    bpy.data.lights["Lamp"].energy *= 0.5


def instance():
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["Cube"])
    empty = bpy.data.objects.new("Copy", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    empty.location = (1.0, 2.0, 0.0)
    bpy.context.scene.collection.objects.link(empty)


def remove():
    bpy.data.objects.remove(bpy.data.objects["Cube"])


def click():
    bpy.data.objects["Cube"].select_set(not bpy.data.objects["Cube"].select_get())


def leave_out_the_world():
    bpy.context.view_layer.use_sky = False


def leave_out_surfaces():
    bpy.context.view_layer.use_solid = False


CHANGES = [move, bend, add_modifier, paint, brighten, add_lamp, instance, remove, click]
CHANGES += [leave_out_the_world, leave_out_surfaces]


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_is_exported_as_from_scratch(window, change):
    """Whatever is kept, the result is equal to the last array."""
    scene, _, lines = window.export(change)
    expected_lines = []
    expected = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=expected_lines)
    assert len(scene.object_to_world) == len(scene.object_pass_index)  # told to windows alone
    assert same(dataclasses.replace(scene, object_to_world=None), expected)
    assert lines == expected_lines


def test_a_move_keeps_the_table_and_tells_the_place(window):
    """By which rays find moved objects in the hierarchy that is there."""
    before, *_ = window.export(click)
    after, *_ = window.export(move)
    assert after.mesh.triangles is before.mesh.triangles
    moved = np.flatnonzero((before.object_to_world != after.object_to_world).any(axis=(1, 2)))
    assert len(moved) == 1
    row = moved[0]
    shift = after.object_to_world[row] - before.object_to_world[row]
    np.testing.assert_allclose(shift[:3, 3], [0.5, 0.0, 0.0], atol=1e-6)
    own = np.unique(after.mesh.triangles[after.mesh.object_index == row])
    way = after.mesh.vertices - before.mesh.vertices
    np.testing.assert_allclose(way[own], np.tile([0.5, 0.0, 0.0], (len(own), 1)), atol=1e-6)
    assert not np.delete(way, own, axis=0).any()


@pytest.mark.parametrize("change", [move, brighten, click])
def test_unchanged_meshes_are_not_read(window, change):
    """A transform, the world or a click reads no mesh at all."""
    assert window.export(change)[1] == []


@pytest.mark.parametrize("change", [move_lamp, dim_lamp])
def test_a_lamp_changes_without_its_meshes(window, change):
    """Other lamps, the very same mesh table, whose BVH is kept; a click changes nothing."""
    before = window.export(add_lamp)[0]
    after, read, _ = window.export(change)
    assert not same(before.lamps, after.lamps) and after.mesh is before.mesh and read == []
    assert same(window.export(click)[0], after)


def test_only_the_changed_mesh_is_read(window):
    """One of three."""
    assert len(window.export(bend)[1]) == 1


def test_forgetting_reads_everything(window):
    """After an undo nothing is believed."""
    window.live.forget()
    assert len(window.export(click)[1]) >= 2


def test_a_click_exports_the_very_same_parts(window):
    """So that neither BVH nor light is built anew."""
    before, after = window.export(click)[0], window.export(click)[0]
    assert after.mesh is before.mesh and after.environment is before.environment
    assert same(before, after)


def test_an_edited_tree_of_the_world_is_seen(window):
    """A smaller map than a final render's; a click makes no new one, a node's value does."""
    tree = bpy.context.scene.world.node_tree

    def add_noise():
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], tree.nodes["Background"].inputs["Color"])

    before = window.export(add_noise)[0]
    assert before.environment.radiance.shape == (512, 1024, 3)
    assert window.export(click)[0].environment is before.environment

    def edit():
        tree.nodes["Noise Texture"].inputs["Scale"].default_value = 9.0

    after = window.export(edit)[0]
    assert not same(after.environment, before.environment)
    assert not same(after.backdrop, before.backdrop)


def test_same_tells_differences():
    """However deep; of arrays shape, type and values."""
    one = {"a": [np.zeros(3), (1, "x")]}
    assert same(one, {"a": [np.zeros(3), (1, "x")]})
    assert not same(one, {"a": [np.zeros(4), (1, "x")]})
    assert not same(one, {"a": [np.zeros(3, np.float32), (1, "x")]})
    assert not same(one, {"a": [np.zeros(3), (2, "x")]})
    assert not same(one, {"b": [np.zeros(3), (1, "x")]})


def comb():
    bpy.data.objects["Strands"].data.attributes["radius"].data[0].value = 0.4
    bpy.data.objects["Strands"].data.update_tag()


def thicken():
    bpy.data.objects["Cube"].particle_systems[0].settings.radius_scale *= 2.0


def grow():
    bpy.data.objects["Points"].data.attributes["size"].data[0].value = 0.5
    bpy.data.objects["Points"].data.update()


def test_points_and_strands_are_read_when_they_change(window):
    """Strands, points and the hair on a mesh: a click keeps all of them, a change of each is what
    an export from scratch gives, with what materials ask of them."""
    material = bpy.data.materials.new("By strand")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    color = nodes["Principled BSDF"].inputs["Base Color"]
    link(nodes.new("ShaderNodeHairInfo").outputs["Random"], color)

    def add():
        add_curves(material, bent_strands(20, 5), np.full((20, 5), 0.05))
        add_points(material, np.zeros((2, 3), np.float32), np.float32([0.1, 0.2]))
        add_particle_hair(bpy.data.objects["Cube"], 10)

    before = window.export(add)[0]
    assert same(window.export(click)[0], before)
    for change in (comb, thicken, grow):
        after = window.export(change)[0]
        assert after.mesh is not before.mesh
        expected = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
        assert same(dataclasses.replace(after, object_to_world=None), expected)
        before = after

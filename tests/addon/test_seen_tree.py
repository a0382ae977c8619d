"""Trees as the renderer gets them: names that users know, and what lives how long."""

import gc

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.meshes.live import _scene_is_asked
from iwis.iwis_addon.export.shaders.program_nodes import HANDLERS
from iwis.iwis_addon.export.shaders.seen_tree import name_of, seen_tree
from iwis.iwis_addon.unsupported import unsupported_of
from support.material_builds import Build, only

IS_5 = bpy.app.version >= (5, 0, 0)


@pytest.fixture
def build(scene):
    return Build()


def _grouped(build, inner_kind, name, output=0):
    """A group node around one node; its first output is the node's."""
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketColor")
    inner = build.node(inner_kind, name, group)
    end = build.node("NodeGroupOutput", tree=group)
    build.link(inner.outputs[output], end.inputs[0], group)
    return build.node("ShaderNodeGroup", node_tree=group)


def test_warnings_name_nodes_as_the_user_does(build, monkeypatch):
    """A node of a group too, and one whose own name begins with a number."""
    monkeypatch.delitem(HANDLERS, "ShaderNodeWavelength")
    for name in ("Waves", "2_Waves"):
        build = Build()
        group = _grouped(build, "ShaderNodeWavelength", name)
        diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Color", group.outputs[0])])
        _, warnings = only(build.surface(diffuse))
        assert len(warnings) == 1 and f'node "{name}": Wavelength is not' in warnings[0], warnings


def test_names_of_the_users_own_trees_are_left_alone(build):
    assert name_of(build.node("ShaderNodeMath", "2_Math")) == "2_Math"


def test_the_tree_lives_as_long_as_it_is_held(build):
    build.surface(build.node("ShaderNodeBsdfDiffuse", "Matte"))
    seen = seen_tree(build.material)
    gc.collect()
    assert [name_of(node) for node in seen.tree.nodes if "Bsdf" in node.bl_idname] == ["Matte"]
    assert seen.output.bl_idname == "ShaderNodeOutputMaterial"


def test_worlds_and_lights_have_trees(scene):
    """Before Blender 5, where they use nodes."""
    light, world = bpy.data.lights.new("L", "POINT"), bpy.data.worlds.new("W")
    if not IS_5:
        assert seen_tree(light) is None and seen_tree(world) is None
        light.use_nodes = world.use_nodes = True
    for data, kind in ((light, "ShaderNodeOutputLight"), (world, "ShaderNodeOutputWorld")):
        seen = seen_tree(data)
        assert kind in [node.bl_idname for node in seen.tree.nodes]


if IS_5:

    def _halved(build, rounds):
        """A zone that halves 8 in each round."""
        begin, end = build.node("GeometryNodeRepeatInput"), build.node("GeometryNodeRepeatOutput")
        begin.pair_with_output(end)
        end.repeat_items.clear()
        end.repeat_items.new("FLOAT", "Value")
        begin.inputs["Iterations"].default_value = rounds
        begin.inputs["Value"].default_value = 8.0
        half = build.node("ShaderNodeMath", operation="MULTIPLY")
        half.inputs[1].default_value = 0.5
        build.link(begin.outputs["Value"], half.inputs[0])
        build.link(half.outputs[0], end.inputs["Value"])
        return end.outputs["Value"]

    def test_a_zone_is_what_its_rounds_make(build):
        emission = build.node("ShaderNodeEmission", links=[("Strength", _halved(build, 4))])
        row, warnings = only(build.surface(emission))
        assert warnings == [] and row["emission"] == [0.5, 0.5, 0.5]

    def test_nothing_is_baked_for_a_zone_alone(build, monkeypatch):
        """But it is where something in the tree is not known, for the user's own tree has it."""
        monkeypatch.delitem(HANDLERS, "ShaderNodeWavelength")
        build.surface(build.node("ShaderNodeEmission", links=[("Strength", _halved(build, 2))]))
        assert unsupported_of(build.material) == []
        wave = build.node("ShaderNodeWavelength", "Waves")
        build.link(wave.outputs[0], build.tree.nodes["Emission"].inputs["Color"])
        found = [each.node for each in unsupported_of(build.material)]
        assert build.tree.nodes["Waves"] in found
        assert all(node.id_data == build.tree for node in found)

    def test_the_scenes_time_is_asked_for(scene, build):
        """A window reads its materials anew then, in each frame."""
        assert not _scene_is_asked()
        time = build.node("GeometryNodeInputSceneTime")
        build.surface(build.node("ShaderNodeEmission", links=[("Strength", time.outputs["Frame"])]))
        assert _scene_is_asked()
        assert np.isfinite(only(build)[0]["emission"]).all()

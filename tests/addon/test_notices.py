"""What IWIS tells before a render and after it, and the tools that go on from a warning."""

import bpy
import pytest

from iwis.core.stats import RenderStats
from iwis.iwis_addon import dependencies
from iwis.iwis_addon.job import RenderJob, RenderRecord
from iwis.iwis_addon.notices import advice_before_render, environment_node, merge
from iwis.iwis_addon.output import NO_LAYER
from iwis.operators.warned import select_named, warnings_text


def test_notices_merge_what_is_the_same_of_many():
    """One notice for a kind, with its lines, and how often it came."""
    lines = [
        "Object A: 3 triangles left out",
        'object "B", material "M", node "N": Anisotropy is not supported',
        "Object C: 12 triangles left out",
        "Object A: 3 triangles left out",
        'object "C", material "K", node "N": Anisotropy is not supported',
        "Not rendered, volumes are not supported: Cloud",
    ]
    notices = merge(lines)
    assert [(notice.count, len(notice.lines)) for notice in notices] == [(3, 2), (2, 2), (1, 1)]
    assert notices[0].text == "Object A: 3 triangles left out (and 1 more like it)"


def test_view_layers_that_are_all_off_are_told_of_before_a_render(cube_scene):
    """The picture would be of nothing."""
    cube_scene.view_layers[0].use = False
    assert NO_LAYER in advice_before_render(cube_scene)
    cube_scene.view_layers[0].use = True
    assert NO_LAYER not in advice_before_render(cube_scene)


@pytest.mark.parametrize(("samples", "seconds"), [(0, 0.0), (64, 0.0), (0, 2.0)])
def test_an_empty_budget_is_told_of_before_a_render(cube_scene, samples, seconds):
    """A render of it could not begin."""
    iwis = cube_scene.iwis
    iwis.target_samples, iwis.time_limit = samples, seconds
    assert not any("budget" in line for line in advice_before_render(cube_scene))
    iwis.stop_rule = "BUDGET"
    empty = any("budget" in line for line in advice_before_render(cube_scene))
    assert empty == (samples == 0 and seconds == 0.0)


def test_warned_objects_are_selected_by_whole_names(cube_scene):
    """ "Cube" is not "Cube.001"; nothing else stays selected."""
    other = bpy.data.objects["Cube"].copy()
    cube_scene.collection.objects.link(other)
    bpy.context.view_layer.update()
    assert other.name == "Cube.001"
    for line, expected in (
        ("Object Cube.001: broken", ["Cube.001"]),
        ("Not rendered: Cube, Plane", ["Cube", "Plane"]),
        ("Object Cub: broken", []),
    ):
        found = select_named(cube_scene.view_layers[0], [line])
        assert sorted(thing.name for thing in found) == expected
    assert sorted(thing.name for thing in bpy.context.selected_objects) == ["Cube", "Plane"]


def test_advice_before_a_render(cube_scene):
    """No camera, no world, a world of one colour: each has a line; a sky and an HDRI have none."""
    world, camera = cube_scene.world, cube_scene.camera
    sky = world.node_tree.nodes.new("ShaderNodeTexSky")
    assert advice_before_render(cube_scene) == []
    world.node_tree.nodes.remove(sky)
    assert ["HDRI" in line for line in advice_before_render(cube_scene)] == [True]
    gradient = world.node_tree.nodes.new("ShaderNodeTexGradient")
    assert advice_before_render(cube_scene) == []
    world.node_tree.nodes.remove(gradient)
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.new("Sky", 8, 4, float_buffer=True)
    assert environment_node(world) == texture
    assert advice_before_render(cube_scene) == []
    cube_scene.world = None
    cube_scene.camera = None
    text = " ".join(advice_before_render(cube_scene))
    assert "camera" in text and "world" in text
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
    cube_scene.collection.objects.link(light)
    assert "world" not in " ".join(advice_before_render(cube_scene))  # lamps may be all there is
    cube_scene.world, cube_scene.camera = world, camera


def test_missing_package_is_told_first(cube_scene, monkeypatch):
    """The panel and the preferences name the package and what to install."""
    monkeypatch.setattr(dependencies, "NEEDED", ("numba", "not_there"))
    lines = advice_before_render(cube_scene)
    assert "not_there" in lines[0] and "zip" in lines[1]


def test_warnings_are_copied_with_their_counts_and_select_objects(cube_scene):
    """Each line once, with how often it came; the button of a warning selects what it names."""
    lines = ["Object Cube: broken", "The scene is dark", "Object Cube: broken"]
    RenderJob.get().records.append(
        RenderRecord(1, "ViewLayer", "", RenderStats(warnings=list(lines)))
    )
    assert warnings_text() == "Object Cube: broken (x 2)\nThe scene is dark"
    assert bpy.ops.iwis.select_warned(number=0) == {"FINISHED"}
    assert [thing.name for thing in bpy.context.selected_objects] == ["Cube"]
    assert bpy.ops.iwis.select_warned(number=1) == {"CANCELLED"}
    with pytest.raises(RuntimeError, match="no such warning"):
        bpy.ops.iwis.select_warned(number=7)
    with pytest.raises(RuntimeError, match="no clipboard in background"):
        bpy.ops.iwis.copy_warnings()
    RenderJob.current = None
    with pytest.raises(RuntimeError, match="Nothing to warn of"):
        bpy.ops.iwis.select_warned(number=0)

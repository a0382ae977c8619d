"""Light groups beside Cycles', in files and in Blender's compositor."""

import bpy
import numpy as np
import pytest

from iwis.core.data.lamps import MESH
from iwis.core.exr import read_exr_layers
from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.job import RenderJob
from iwis.operators.save_film import film_layers
from support.compositor import sockets_by_engine
from support.cycles_render import use_cycles
from support.iwis_render import by_pass, render_iwis
from support.material_builds import Build

GROUPS = ("Sky", "Key", "Shining", "Made by", "Empty")


@pytest.fixture
def lit_scene(cube_scene):
    """The cube on its floor; a sky, lamps, a bulb that the camera sees, a sheet that shines, a
    hole and a catcher; a lamp of a group and a sheet of none that a collection brings."""
    scene = cube_scene
    scene.world.lightgroup = "Sky"
    for name in GROUPS:
        bpy.ops.scene.view_layer_add_lightgroup(name=name)
    _add_lamp("Key", "SUN", (0.0, 0.0, 4.0), 1.5)
    bulb = _add_lamp("Key", "POINT", (-0.9, -0.6, 1.4), 40.0, visible_camera=True)
    bulb.data.shadow_soft_size = 0.2
    _add_lamp("", "POINT", (2.0, 1.0, 3.0), 60.0)
    _add_lamp("Not of the layer", "POINT", (-2.0, 1.0, 3.0), 30.0)
    for name, x in (("Hole", 0.6), ("Catcher", 1.4)):
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(x, -1.2, 0.25))
        bpy.context.object.name = name
    bpy.data.objects["Hole"].is_holdout = True
    bpy.data.objects["Catcher"].is_shadow_catcher = True
    sheet = _add_sheet("Shining", (-1.5, 0.8, 1.0))
    _add_instancer(sheet)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 512
    return scene


def _add_lamp(group, kind, place, energy, **fields):
    bpy.ops.object.light_add(type=kind, location=place, rotation=(0.4, 0.3, 0.0))
    lamp = bpy.context.object
    lamp.data.energy, lamp.lightgroup = energy, group
    lamp.visible_camera = False
    for name, value in fields.items():
        setattr(lamp, name, value)
    return lamp


def _add_sheet(group, place):
    bpy.ops.mesh.primitive_plane_add(size=0.8, location=place, rotation=(0.0, 1.2, 0.3))
    sheet = bpy.context.object
    sheet.lightgroup = group
    build = Build("Shines")
    build.surface(build.node("ShaderNodeEmission", Color=(1.0, 0.5, 0.2, 1.0), Strength=4.0))
    sheet.data.materials.append(build.material)
    return sheet


def _add_instancer(sheet):
    """A collection of a lamp and a sheet, shown by an empty that is in a group itself."""
    inner = bpy.data.collections.new("Inner")
    lamp = _add_lamp("Key", "POINT", (0.0, 0.0, 0.6), 15.0)
    copy = sheet.copy()
    copy.lightgroup, copy.location = "", (0.4, 0.0, 0.3)
    bpy.context.scene.collection.objects.unlink(lamp)
    for obj in (lamp, copy):
        inner.objects.link(obj)
    empty = bpy.data.objects.new("Maker", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", inner
    empty.location, empty.lightgroup = (1.2, 1.4, 0.6), "Made by"
    bpy.context.scene.collection.objects.link(empty)


@pytest.mark.slow
@pytest.mark.parametrize("transparent", [False, True])
def test_groups_are_those_of_cycles(lit_scene, tmp_path, transparent):
    """Means within 1 %, and pixels within the noise of Cycles' 256 samples: 2 % of a mean of the
    sky's group, 7 and 11 % of the sheets', half of that at 1024."""
    scene = lit_scene
    scene.render.film_transparent = transparent
    ours = by_pass(render_iwis(scene, tmp_path))
    use_cycles(scene, samples=256, filter_width=1.5)
    scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(tmp_path / "cycles.exr"))
    names = [f"Combined_{name}" for name in GROUPS]
    assert [name for name in ours if name.startswith("Combined_")] == [
        name for name in theirs if name.startswith("Combined_")
    ]
    for name in names:
        a, b = ours[name], theirs[name]
        np.testing.assert_allclose(a.mean(axis=(0, 1)), b.mean(axis=(0, 1)), rtol=0.01, atol=1e-4)
        assert np.abs(a - b).mean() <= 0.15 * b.mean()
    assert not ours["Combined_Empty"].any()


def test_sockets_are_those_of_cycles(cube_scene):
    """One for each group of the layer, under its name."""
    for name in ("Key", "Füll light"):
        bpy.ops.scene.view_layer_add_lightgroup(name=name)
    for sockets in sockets_by_engine(cube_scene).values():
        groups = {name for name in sockets if name.startswith("Combined")}
        assert groups == {"Combined_Key", "Combined_Füll light"}


def test_a_kept_film_has_its_groups(cube_scene, tmp_path):
    """Save Film writes them under Blender's names; without groups there is none."""
    cube_scene.iwis.keep_film = True
    cube_scene.world.lightgroup = "Sky"
    bpy.ops.scene.view_layer_add_lightgroup(name="Sky")
    render_iwis(cube_scene, tmp_path)
    layers, letters = film_layers(RenderJob.current.films)
    assert letters["ViewLayer.Combined_Sky"] == "RGB"
    combined = layers["ViewLayer.Combined"][..., :3]
    np.testing.assert_allclose(layers["ViewLayer.Combined_Sky"], combined, rtol=1e-5, atol=1e-6)
    bpy.ops.scene.view_layer_remove_lightgroup()
    render_iwis(cube_scene, tmp_path)
    layers, _ = film_layers(RenderJob.current.films)
    assert not any("Combined_" in name for name in layers)


def test_what_is_exported(lit_scene):
    """Groups by their place in the layer; those of other layers are none."""
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
    groups, lamps = scene.asked.groups, scene.lamps
    assert groups.layers == tuple(f"light_group:{name}" for name in GROUPS)
    assert groups.world == 0
    assert sorted(lamps.group[lamps.kind != MESH].tolist()) == [-1, -1, 1, 1, 1]
    assert sorted(lamps.group[lamps.kind == MESH].tolist()) == [2, 3]
    assert [(groups.objects == number).sum() for number in (0, 1, 2, 3)] == [0, 0, 1, 1]

"""Linked files that are gone are named, with what of them is missing, and only those."""

import bpy
import pytest

from iwis.iwis_addon.export.libraries import warn_of_missing_libraries
from iwis.iwis_addon.export.worlds.world import read_world


@pytest.fixture
def linked(cube_scene, tmp_path):
    """The file of a scene whose world and five materials are of a library, and the library."""
    library, path = tmp_path / "lib.blend", tmp_path / "scene.blend"
    world = bpy.data.worlds.new("Sky")
    if world.node_tree is None:
        world.use_nodes = True
    materials = {bpy.data.materials.new(f"M{k}") for k in range(5)}
    for material in materials:
        material.use_fake_user = True
    bpy.data.libraries.write(str(library), {world, *materials})
    for block in (world, *materials):
        bpy.data.batch_remove([block])
    with bpy.data.libraries.load(str(library), link=True) as (there, here):
        here.worlds, here.materials = there.worlds, there.materials
    cube_scene.world = here.worlds[0]
    mesh = next(o.data for o in cube_scene.objects if o.type == "MESH")
    mesh.materials.clear()
    for material in here.materials:
        mesh.materials.append(material)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path, library


def _warnings(path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    warnings = []
    warn_of_missing_libraries(warnings)
    read_world(bpy.context.evaluated_depsgraph_get(), warnings)
    return warnings


def test_library_that_is_there_is_not_told_of(linked):
    assert _warnings(linked[0]) == []


def test_missing_library_is_one_line(linked):
    """Its path, what is missing, and what to do; nothing is said of the empty world beside."""
    path, library = linked
    library.unlink()
    (line,) = (text for text in _warnings(path) if "no light" not in text)
    assert f'library "lib.blend": there is no file {library}; ' in line
    assert line.endswith(" and 3 more are missing: put it there, or relocate the library")
    assert line.count('Material "M') + line.count('World "Sky"') == 3

"""export_scene gathers what the parts export, and the film's own settings."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import ExportCancelled, export_scene


def test_scene_has_film_settings_and_pass_indices(cube_scene):
    """Transparency and exposure of the film; the rows of objects and materials belong together."""
    cube_scene.render.film_transparent = True
    cube_scene.cycles.film_exposure = 2.5
    cube = bpy.data.objects["Cube"]
    cube.pass_index = 3
    material = bpy.data.materials.new("Red")
    material.pass_index = 4
    cube.data.materials.append(material)
    warnings = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=warnings)
    assert warnings == []
    assert (scene.transparent_film, scene.exposure) == (True, 2.5)
    of_cube = scene.object_pass_index[scene.mesh.object_index] == 3.0
    assert of_cube.sum() == 12
    np.testing.assert_array_equal(
        scene.material_pass_index[scene.mesh.material_index], np.where(of_cube, 4.0, 0.0)
    )
    assert scene.camera.region == (0, 0, 32, 24)


def test_scene_defaults_and_region(cube_scene):
    """An opaque film of exposure 1; the region may be given."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    scene = export_scene(depsgraph, region=(2, 3, 10, 11), warnings=[])
    assert (scene.transparent_film, scene.exposure) == (False, 1.0)
    assert scene.camera.region == (2, 3, 10, 11)


def test_material_warnings_name_the_objects(cube_scene):
    """Each object once, though it may be there several times."""
    plane, cube = bpy.data.objects["Plane"], bpy.data.objects["Cube"]
    material = bpy.data.materials.new("Skin")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Transmission Weight"].default_value = 1.0
    for obj in (plane, cube):
        obj.data.materials.append(material)
    warnings = []
    export_scene(bpy.context.evaluated_depsgraph_get(), warnings=warnings)
    assert len(warnings) == 1
    assert warnings[0].startswith('object "Cube" and 1 more, material "Skin", node "Principled')
    cube.data.materials.clear()
    warnings.clear()
    export_scene(bpy.context.evaluated_depsgraph_get(), warnings=warnings)
    assert warnings[0].startswith('object "Plane", material "Skin", node "Principled')


def test_scene_without_objects_is_exported(scene):
    """A camera alone sees the world."""
    bpy.ops.object.camera_add()
    scene.camera = bpy.context.object
    exported = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
    assert len(exported.mesh.triangles) == len(exported.object_pass_index) == 0
    assert len(exported.materials.model) == 0


def test_scene_export_can_be_cancelled(cube_scene):
    """Nothing is returned after a cancel."""
    with pytest.raises(ExportCancelled):
        export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[], cancelled=lambda: True)

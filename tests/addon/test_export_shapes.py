"""What changes its shape while the shutter is open: which meshes are read, and into which rows."""

import math

import bpy
import numpy as np
import pytest
from parity.movers import by_armature, by_keys, by_wave

from iwis.iwis_addon.export import ExportCache, export_scene
from iwis.iwis_addon.export.motion import changing_shapes
from support.frames import exported_in_motion, objects_of


def table_at(frame):
    """The mesh table of the scene at another time, as a still picture has it."""
    scene = bpy.context.scene
    scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
    found = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[])
    scene.frame_set(1)
    return found.mesh


def assert_same_as_tables(found, steps):
    """At each step corners and normals are those of a still picture of that time."""
    for shapes in found.motion.shapes:
        k = len(shapes.positions)
        assert k in steps
        for step, frame in enumerate(np.linspace(0.5, 1.5, k)):
            mesh = table_at(frame)
            corners = shapes.positions[step][shapes.corners]
            wanted = mesh.vertices[mesh.triangles[shapes.triangle]]
            np.testing.assert_allclose(corners, wanted, atol=2e-6)
            smooth = (shapes.normal_index >= 0).all(axis=1)
            normals = shapes.normals[step][shapes.normal_index[smooth]]
            wanted = mesh.corner_normals[shapes.triangle[smooth]]
            np.testing.assert_allclose(normals, wanted, atol=2e-5)


@pytest.mark.parametrize("shading", ["smooth", "flat", "some"])
def test_shapes_are_those_of_pictures_at_their_times(parts, shading):
    """Of shape keys, with flat, smooth and mixed faces; by rows of the mesh table."""
    _, sphere, *_ = parts
    by_keys(sphere)
    if shading == "flat":
        sphere.data.shade_flat()
    elif shading == "some":
        sphere.data.polygons.foreach_set("use_smooth", np.arange(len(sphere.data.polygons)) % 3 > 0)
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(found.motion.objects) == 0
    assert len(shapes.triangle) == np.bincount(found.mesh.object_index)[0]
    assert_same_as_tables(found, {3})
    assert np.ptp(shapes.positions, axis=0).max() > 0.2
    assert (shapes.normal_index < 0).any() == (shading == "flat") or shading == "some"
    middle = shapes.positions[1][shapes.corners]
    wanted = found.mesh.vertices[found.mesh.triangles[shapes.triangle]]
    np.testing.assert_array_equal(middle, wanted)


def test_modifiers_change_shapes_each_in_its_steps(parts):
    """An armature in 5 times, a wave in 3; the sphere, which stands, in none."""
    _, _, cube, floor = parts
    by_armature(cube)
    cube.cycles.motion_steps = 2
    bpy.context.view_layer.objects.active = floor
    modifier = floor.modifiers.new("Fine", "SUBSURF")
    modifier.subdivision_type, modifier.render_levels = "SIMPLE", 4
    by_wave(floor)
    found, lines = exported_in_motion()
    assert lines == [] and [len(s.positions) for s in found.motion.shapes] == [3, 5]
    assert [objects_of(found, s) for s in found.motion.shapes] == [{2}, {1}]
    assert_same_as_tables(found, {3, 5})


def test_instances_share_what_is_read_and_stand_each_in_its_place(parts):
    """Mirrored, scaled and moving ones: in the middle's place, and their own motion beside it."""
    scene, sphere, *_ = parts
    by_keys(sphere)
    own = bpy.data.collections.new("Own")
    own.objects.link(sphere)
    scene.collection.objects.unlink(sphere)
    for k, scale in enumerate(((0.5, 0.6, 0.7), (-0.5, 0.5, 0.5))):
        empty = bpy.data.objects.new("Instance", None)
        scene.collection.objects.link(empty)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty.location, empty.scale = (2.0 * k, 1.0, 0.0), scale
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(objects_of(found, shapes)) == 2
    assert_same_as_tables(found, {3})


def test_left_out_triangles_are_left_out_of_shapes_too(parts):
    """A fan without area among the faces: rows go on counting as the table's."""
    _, _, cube, _ = parts
    mesh = cube.data
    corners = [vertex.co.copy() for vertex in mesh.vertices]
    faces = [tuple(p.vertices) for p in mesh.polygons]
    mesh.clear_geometry()
    mesh.from_pydata([*corners, (0, 0, 3), (0, 0, 4)], [], [*faces[:2], (8, 9, 8 - 8), *faces[2:]])
    mesh.vertices[9].co = mesh.vertices[8].co
    mesh.update()
    by_keys(cube)
    found, _ = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert len(shapes.triangle) == 12
    corners = shapes.positions[1][shapes.corners]
    wanted = found.mesh.vertices[found.mesh.triangles[shapes.triangle]]
    np.testing.assert_allclose(corners, wanted, atol=1e-6)


def test_what_may_not_deform_does_not(parts):
    """Deformation off, motion blur off, of the object or its instancer; a key that stands."""
    _, sphere, *_ = parts
    by_keys(sphere)
    assert exported_in_motion()[0].motion.shapes
    sphere.cycles.use_deform_motion = False
    assert exported_in_motion()[0].motion is None
    sphere.cycles.use_deform_motion, sphere.cycles.use_motion_blur = True, False
    assert exported_in_motion()[0].motion is None
    sphere.cycles.use_motion_blur = True
    sphere.data.shape_keys.animation_data_clear()
    assert exported_in_motion()[0].motion is None


def test_meshes_that_geometry_nodes_instance_are_looked_at(parts):
    """Cycles cannot tell whether they deform: a scale by the scene's time, before instancing."""
    _, sphere, *_ = parts
    group = bpy.data.node_groups.new("Grow", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    made = {
        name: group.nodes.new(f"GeometryNode{name}")
        for name in ("MeshCube", "SetPosition", "InstanceOnPoints", "MeshLine")
    }
    time, out = group.nodes.new("GeometryNodeInputSceneTime"), group.nodes.new("NodeGroupOutput")
    position = group.nodes.new("GeometryNodeInputPosition")
    scaled = group.nodes.new("ShaderNodeVectorMath")
    scaled.operation = "SCALE"
    link = group.links.new
    link(position.outputs[0], scaled.inputs[0])
    link(time.outputs["Frame"], scaled.inputs["Scale"])
    link(made["MeshCube"].outputs["Mesh"], made["SetPosition"].inputs["Geometry"])
    link(scaled.outputs[0], made["SetPosition"].inputs["Position"])
    link(made["MeshLine"].outputs[0], made["InstanceOnPoints"].inputs["Points"])
    link(made["SetPosition"].outputs[0], made["InstanceOnPoints"].inputs["Instance"])
    link(made["InstanceOnPoints"].outputs[0], out.inputs[0])
    sphere.modifiers.new("Grow", "NODES").node_group = group
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(objects_of(found, shapes)) == 10
    own = shapes.triangle < 12
    size = np.ptp(shapes.positions[:, shapes.corners[own]].reshape(3, -1, 3), axis=1)
    np.testing.assert_allclose(size, np.array([[0.5], [1.0], [1.5]]) * np.ones(3), rtol=1e-5)


def test_other_vertices_at_other_times_stay_sharp_and_are_told(parts):
    """A remesher: as in Cycles nothing of it is blurred."""
    _, sphere, *_ = parts
    by_keys(sphere)
    modifier = sphere.modifiers.new("Remesh", "REMESH")
    modifier.mode, modifier.voxel_size = "VOXEL", 0.3
    found, lines = exported_in_motion()
    assert found.motion is None
    (line,) = lines
    assert "1 objects have other vertices at other times" in line and "Sphere" in line


def test_more_steps_than_fit_into_memory_are_told(parts, monkeypatch):
    """The object stays sharp, by name; what fits is blurred."""
    _, sphere, cube, _ = parts
    by_keys(sphere)
    by_keys(cube)
    sphere.cycles.motion_steps = 4
    monkeypatch.setattr(changing_shapes, "free_memory_bytes", lambda: 1_000_000)
    found, lines = exported_in_motion()
    (shapes,), (line,) = found.motion.shapes, lines
    assert objects_of(found, shapes) == {1}
    assert line.startswith("Object Sphere: its shapes at 17 times need 0.0 GB")


def test_the_cache_of_frames_knows_shapes(parts):
    """The second frame finds its mesh in the cache, and reads the shapes anew."""
    _, sphere, *_ = parts
    by_keys(sphere)
    cache = ExportCache()
    first, second = exported_in_motion(cache)[0], exported_in_motion(cache)[0]
    assert second.mesh is first.mesh
    for one, two in zip(first.motion.shapes[0], second.motion.shapes[0], strict=True):
        np.testing.assert_array_equal(one, two)

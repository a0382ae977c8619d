"""What changes its shape while the shutter is open: which meshes are read, and into which rows."""

import functools
import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from parity.element_cases import add_curves, add_particle_hair, add_points, bent_strands
from parity.motion_cases import by_armature, by_keys, by_wave, lean, with_velocity
from parity.scene import empty_scene

from iwis.iwis_addon.export import ExportCache, changing_shapes, export_scene
from iwis.iwis_addon.export.motion import export_in_motion
from iwis.iwis_addon.export.strand_tubes import Strands, choose_shape


@pytest.fixture
def parts(scene):
    """(scene, a sphere, a cube, a floor), blurred over a whole frame at frame 1."""
    scene, tree = empty_scene(lit=True)
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)
    meshes = [obj for obj in scene.objects if obj.type == "MESH"]
    sphere, cube, floor = (next(o for o in meshes if w in o.name) for w in ("here", "ube", "lane"))
    return scene, sphere, cube, floor


def exported(cache=None):
    """(scene, warnings) of an export with motion."""
    scene = bpy.context.scene
    for obj in scene.objects:  # Cycles' own settings of an object tell nobody that they change
        obj.update_tag()
    engine = SimpleNamespace(frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))
    graph, lines = bpy.context.evaluated_depsgraph_get(), []
    export = functools.partial(export_scene, graph, warnings=lines, cache=cache)
    return export_in_motion(engine, graph, lines, export), lines


def objects_of(scene, shapes):
    return set(scene.mesh.object_index[shapes.triangle].tolist())


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
    found, lines = exported()
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
    found, lines = exported()
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
    found, lines = exported()
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
    found, _ = exported()
    (shapes,) = found.motion.shapes
    assert len(shapes.triangle) == 12
    corners = shapes.positions[1][shapes.corners]
    wanted = found.mesh.vertices[found.mesh.triangles[shapes.triangle]]
    np.testing.assert_allclose(corners, wanted, atol=1e-6)


def test_what_may_not_deform_does_not(parts):
    """Deformation off, motion blur off, of the object or its instancer; a key that stands."""
    _, sphere, *_ = parts
    by_keys(sphere)
    assert exported()[0].motion.shapes
    sphere.cycles.use_deform_motion = False
    assert exported()[0].motion is None
    sphere.cycles.use_deform_motion, sphere.cycles.use_motion_blur = True, False
    assert exported()[0].motion is None
    sphere.cycles.use_motion_blur = True
    sphere.data.shape_keys.animation_data_clear()
    assert exported()[0].motion is None


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
    found, lines = exported()
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
    found, lines = exported()
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
    found, lines = exported()
    (shapes,), (line,) = found.motion.shapes, lines
    assert objects_of(found, shapes) == {1}
    assert line.startswith("Object Sphere: its shapes at 17 times need 0.0 GB")


def test_the_cache_of_frames_knows_shapes(parts):
    """The second frame finds its mesh in the cache, and reads the shapes anew."""
    _, sphere, *_ = parts
    by_keys(sphere)
    cache = ExportCache()
    first, second = exported(cache)[0], exported(cache)[0]
    assert second.mesh is first.mesh
    for one, two in zip(first.motion.shapes[0], second.motion.shapes[0], strict=True):
        np.testing.assert_array_equal(one, two)


def leaning(middle, t):
    """Where parity.motion_cases.lean has places at a time from the frame."""
    return middle + np.float32([0.6 * t, 0.0, 0.0]) * middle[..., 2:]


def test_strands_bend_with_their_keys(parts):
    """Rings of tubes go where the nodes have their keys, round, and turned alike."""
    scene, *_, floor = parts
    places, radii = bent_strands(24, 5), np.full((24, 5), 0.05, np.float32)
    lean(add_curves(floor.data.materials[0], places, radii))
    scene.cycles_curves.shape = "THICK"
    found, lines = exported()
    (shapes,) = found.motion.shapes
    assert lines == [] and objects_of(found, shapes) == {3}
    keys = np.concatenate([places, radii[..., None]], axis=-1).reshape(-1, 4)
    sides = choose_shape(Strands(keys, np.arange(0, 121, 5)), 16, False).sides
    rings = shapes.positions.reshape(3, -1, sides, 3)
    middles = rings[1].mean(axis=1)
    for step, t in ((0, -0.5), (2, 0.5)):  # a spline of keys that lean leans as they do
        np.testing.assert_allclose(rings[step].mean(axis=1), leaning(middles, t), atol=2e-6)
    away = np.linalg.norm(rings - rings.mean(axis=2, keepdims=True), axis=-1)
    np.testing.assert_allclose(away, away[0, 0, 0], rtol=1e-4)
    # The strands lean by 17 degrees; corners that were turned by a side more would be at .3.
    moved = np.einsum("kni,kni->kn", shapes.normals[[0, 2]], shapes.normals[[1, 1]])
    assert moved.min() > 0.9


def test_points_move_with_their_spheres(parts):
    """Centres go where the nodes have them; normals stay."""
    *_, floor = parts
    places = np.random.default_rng(2).uniform(-1.0, 1.0, (20, 3)).astype(np.float32)
    radii = np.linspace(0.05, 0.2, 20, dtype=np.float32)
    lean(add_points(floor.data.materials[0], places, radii))
    found, lines = exported()
    (shapes,) = found.motion.shapes
    assert lines == []
    shift = shapes.positions - shapes.positions[1]
    assert np.abs(shift[..., 1:]).max() < 1e-6
    for step, t in ((0, -0.5), (2, 0.5)):
        wanted = np.sort(0.6 * t * places[:, 2])
        rounded = np.unique(np.round(shift[step, :, 0], 5))
        np.testing.assert_allclose(rounded, wanted, atol=2e-5)
        np.testing.assert_array_equal(shapes.normals[step], shapes.normals[1])


def test_hair_goes_along_with_what_it_grows_on(parts):
    """Particle hair of a sphere with a shape key: both change."""
    _, sphere, *_ = parts
    by_keys(sphere)
    add_particle_hair(sphere, 30, radius_scale=0.02)
    found, lines = exported()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(objects_of(found, shapes)) == 2
    for row in objects_of(found, shapes):
        own = np.unique(shapes.corners[found.mesh.object_index[shapes.triangle] == row])
        shift = shapes.positions[:, own] - shapes.positions[1, own]
        assert 0.1 < np.abs(shift[0]).max() < 1.0
        np.testing.assert_allclose(shift[0], -shift[2], atol=0.1)  # roots go straight


def test_meshes_go_along_velocities(parts):
    """Half a shutter's time to either side, in three times, whatever the object's steps are."""
    scene, sphere, *_ = parts
    sphere.cycles.motion_steps = 3
    scene.render.fps, scene.render.motion_blur_shutter = 10, 0.5
    with_velocity(sphere, size=4.0)
    found, lines = exported()
    (shapes,) = found.motion.shapes
    assert lines == [] and len(shapes.positions) == 3
    middle = shapes.positions[1]
    for step, seconds in ((0, -0.025), (2, 0.025)):
        wanted = middle + np.float32([4.0 * seconds, 0.0, 0.0]) * middle[:, 2:]
        np.testing.assert_allclose(shapes.positions[step], wanted, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(shapes.normals, axis=-1), 1.0, atol=1e-6)
    # The normal (x, y, z) of what is sheared by s becomes (x, y, z - s x), made unit.
    x, _, z = shapes.normals[1].T
    leans = shapes.normals[2, :, 2] - shapes.normals[0, :, 2]
    np.testing.assert_allclose(leans, -0.2 * x * (1.0 - z**2), atol=0.01)  # s squared
    sphere.cycles.use_deform_motion = False
    assert exported()[0].motion is None

"""Materials that move vertices: what is exported, when it is made anew, and in motion."""

import dataclasses

import bpy
import numpy as np
import pytest
from parity.element_cases import add_points
from parity.movers import by_keys

from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.meshes.local_mesh import read_mesh
from iwis.iwis_addon.export.placed.displaced_mesh import _vertex_normals
from iwis.iwis_addon.export.same import same
from iwis.iwis_addon.export.shaders.material import export_shaders
from support.frames import exported_in_motion


def material(height=0.5, method="DISPLACEMENT", texture=None):
    """That moves by a height, or by .5 times a texture's."""
    made = bpy.data.materials.new("Moving")
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    made.displacement_method = method
    nodes, links = made.node_tree.nodes, made.node_tree.links
    node = nodes.new("ShaderNodeDisplacement")
    node.inputs["Height"].default_value = height
    node.inputs["Midlevel"].default_value, node.inputs["Scale"].default_value = 0.0, 1.0
    if texture is not None:
        links.new(nodes.new(texture).outputs[0], node.inputs["Height"])
        node.inputs["Scale"].default_value = 0.5
    links.new(node.outputs[0], nodes["Material Output"].inputs["Displacement"])
    return made


def exported(**options):
    lines = []
    found = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines, **options)
    assert lines == []
    return found


def vertices_of(scene, name="Cube"):
    """Of the first object: the cube."""
    rows = scene.mesh.object_index == list(bpy.context.scene.objects).index(bpy.data.objects[name])
    return scene.mesh.vertices[np.unique(scene.mesh.triangles[rows])]


@pytest.fixture
def cube(cube_scene):
    return bpy.data.objects["Cube"]


def _moved(before, after):
    """How far vertices have moved, float32 (n, 3)."""
    assert np.array_equal(before.mesh.triangles, after.mesh.triangles)
    return after.mesh.vertices - before.mesh.vertices


@pytest.mark.parametrize("smooth", [False, True])
def test_vertices_move_along_their_normals(cube, smooth):
    """Of flat faces too, as in Cycles: a corner of the cube goes by a third of it along each axis.
    All other objects stay."""
    if smooth:
        cube.data.shade_smooth()
    before = exported()
    cube.data.materials.append(material(np.sqrt(3.0) * 0.3))
    after = exported()
    by = _moved(before, after)
    own = np.unique(before.mesh.triangles[before.mesh.object_index == _row(before, cube)])
    center = np.array(cube.matrix_world.translation)
    np.testing.assert_allclose(
        by[own], 0.3 * np.sign(before.mesh.vertices[own] - center), atol=1e-5
    )
    assert not np.delete(by, own, axis=0).any() and after.shaders is None
    # Smooth ones are sums of those of triangles, as in Cycles: two of a side that is cut so.
    turned = (after.mesh.corner_normals * before.mesh.corner_normals).sum(-1)
    assert turned.min() > (0.9 if smooth else 0.99999)


def _row(scene, obj):
    """The row of an object whose middle is nearest to that of its triangles."""
    mesh = scene.mesh
    middles = [
        mesh.vertices[mesh.triangles[mesh.object_index == row]].mean(axis=(0, 1))
        for row in range(len(scene.object_pass_index))
    ]
    return int(np.argmin(np.linalg.norm(middles - np.array(obj.matrix_world.translation), axis=1)))


@pytest.mark.parametrize(
    ("method", "moves", "bumps"),
    [("BUMP", False, True), ("DISPLACEMENT", True, False), ("BOTH", True, True)],
)
def test_methods(scene, method, moves, bumps):
    found = export_shaders([material(method=method, texture="ShaderNodeTexNoise")], [])
    program, displacement = found.programs[0], found.displacements[0]
    assert (program is not None and program.displaced is not None) == bumps
    assert (displacement is not None) == moves
    assert displacement is None or displacement.keeps_normals == bumps


def test_points_do_not_move(cube_scene):
    places, radii = np.float32([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0]]), np.float32([0.2, 0.3])
    add_points(material(), places, radii)
    found = exported()
    distance = np.linalg.norm(found.mesh.vertices[:, None] - places, axis=-1).min(axis=1)
    assert (np.abs(distance[:, None] - radii).min(axis=1) < 0.02).sum() > 100
    assert found.shaders is None or found.shaders.rest is None


def test_a_mirrored_copy_moves_as_its_original(cube):
    cube.data.materials.append(material(texture="ShaderNodeTexNoise"))
    copy = cube.copy()
    copy.location.x += 5.0
    copy.scale.x *= -1.0
    bpy.context.scene.collection.objects.link(copy)
    found = exported()
    rows = [_row(found, obj) for obj in (cube, copy)]
    own, other = (
        found.mesh.vertices[np.unique(found.mesh.triangles[found.mesh.object_index == row])]
        - np.float32(obj.matrix_world.translation)
        for row, obj in zip(rows, (cube, copy), strict=True)
    )
    np.testing.assert_allclose(other, own * np.float32([-1.0, 1.0, 1.0]), atol=1e-5)


def test_without_its_mesh_normals_are_those_of_faces(cube):
    """As while it is being edited."""
    cube.data.shade_smooth()
    found = _vertex_normals(None, read_mesh(cube.data))
    expected = np.sign(read_mesh(cube.data).positions) / np.sqrt(3.0)
    assert (found * expected > 0.0).all()


def test_an_unchanged_frame_has_the_same_table(cube):
    """So that nobody builds a hierarchy anew: materials are read again in each frame."""
    cube.data.materials.append(material(texture="ShaderNodeTexNoise"))
    cache = ExportCache()
    first = exported(cache=cache)
    again = exported(cache=cache)
    assert again.mesh is first.mesh and again.shaders is first.shaders is None
    cube.data.materials[0].node_tree.nodes["Noise Texture"].inputs["Scale"].default_value = 2.3
    changed = exported(cache=cache)
    assert changed.mesh is not first.mesh
    assert not np.array_equal(changed.mesh.vertices, first.mesh.vertices)


def _scale():
    tree = bpy.data.materials["Moving"].node_tree
    tree.nodes["Displacement"].inputs["Scale"].default_value = 0.2


def _bump_only():
    bpy.data.materials["Moving"].displacement_method = "BUMP"


def _move():
    bpy.data.objects["Cube"].location.z += 0.5


def _click():
    bpy.data.objects["Cube"].select_set(not bpy.data.objects["Cube"].select_get())


@pytest.mark.parametrize("change", [_scale, _bump_only, _move, _click])
@pytest.mark.parametrize("method", ["DISPLACEMENT", "BOTH"])
def test_a_window_shows_what_an_export_from_scratch_does(cube, change, method):
    cube.data.materials.append(material(method=method, texture="ShaderNodeTexNoise"))
    live, cache, found = LiveExport(), ExportCache(), []
    cache.live = live.meshes

    def take(_scene, depsgraph):
        live.begin(depsgraph.updates)
        found.append(export_scene(depsgraph, warnings=[], cache=cache, live=live))

    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(take)
    try:
        for step in (cube.update_tag, change):
            step()
            bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(take)
    assert same(dataclasses.replace(found[-1], object_to_world=None), exported())
    assert (found[-1].mesh is found[0].mesh) == (change is _click)


@pytest.mark.parametrize("method", ["DISPLACEMENT", "BOTH"])
def test_shapes_in_motion_move_as_in_the_middle(parts, method):
    """As in Cycles; normals turn by as much as in the middle."""
    _, sphere, *_ = parts
    by_keys(sphere)
    sphere.data.materials.clear()
    plain, _ = exported_in_motion()
    sphere.data.materials.append(material(method=method, texture="ShaderNodeTexNoise"))
    found, lines = exported_in_motion()
    (shapes,), (before,) = found.motion.shapes, plain.motion.shapes
    assert lines == []
    own = found.mesh.triangles[shapes.triangle]
    middle = shapes.positions[1][shapes.corners]
    np.testing.assert_allclose(middle, found.mesh.vertices[own], atol=1e-6)
    by = shapes.positions - before.positions
    assert np.abs(by).max() > 0.1
    np.testing.assert_allclose(by, np.broadcast_to(by[1], by.shape), atol=1e-6)
    normals = shapes.normals[1][shapes.normal_index]
    np.testing.assert_allclose(normals, found.mesh.corner_normals[shapes.triangle], atol=1e-5)

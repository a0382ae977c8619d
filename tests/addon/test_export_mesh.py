"""Exported shapes and normals are what Cycles renders."""

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from support.above import BENT, QUADS, add_mesh, add_monkey, look_from_above
from support.trace_scene import assert_seen_as_in_cycles, export_as_render


@pytest.fixture
def above(scene):
    """An empty file seen from above."""
    look_from_above(scene)
    return scene


def set_custom_normals(mesh, domain):
    """Free normals, as geometry nodes store them."""
    attribute = mesh.attributes.new("custom_normal", "FLOAT_VECTOR", domain)
    attribute.data.foreach_set("vector", [0.0, 0.6, 0.8] * len(attribute.data))


def mark_sharp_edge(mesh, edge):
    attribute = mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
    for i, item in enumerate(mesh.edges):
        attribute.data[i].value = set(item.vertices) == edge


def make_half_flat(mesh):
    mesh.polygons[0].use_smooth = False


SHADINGS = {
    "smooth": [],
    "flat": [lambda mesh: mesh.shade_flat()],
    "one face flat": [make_half_flat],
    "custom": [lambda mesh: mesh.normals_split_custom_set([(0.3, 0.0, 1.0)] * 8)],
    "custom, one face flat": [
        make_half_flat,
        lambda mesh: mesh.normals_split_custom_set([(0.3, 0.0, 1.0)] * 8),
    ],
    "free on points": [lambda mesh: set_custom_normals(mesh, "POINT")],
    "free on points, one face flat": [
        make_half_flat,
        lambda mesh: set_custom_normals(mesh, "POINT"),
    ],
    "free on faces": [lambda mesh: set_custom_normals(mesh, "FACE")],
    "free on corners": [lambda mesh: set_custom_normals(mesh, "CORNER")],
    "sharp edge": [lambda mesh: mark_sharp_edge(mesh, {1, 4})],
    "sharp edge, one face flat": [make_half_flat, lambda mesh: mark_sharp_edge(mesh, {0, 1})],
}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("name", SHADINGS)
def test_normals_are_those_of_cycles(above, tmp_path, name, mirrored):
    """Every way to shade, in a turned, stretched and perhaps mirrored object."""
    obj = add_mesh(above, BENT, QUADS)
    obj.data.shade_smooth()
    for change in SHADINGS[name]:
        change(obj.data)
    obj.rotation_euler = (0.4, -0.3, 0.2)
    obj.scale = (-1.2 if mirrored else 1.2, 0.9, 2.0)
    assert assert_seen_as_in_cycles(above, tmp_path).warnings == []


MATRICES = {
    "stretched": Matrix.Diagonal((1.4, 0.6, 0.9, 1.0))
    @ Euler((0.4, 0.2, 0.9)).to_matrix().to_4x4(),
    "mirrored": Matrix.Diagonal((1.0, -1.2, 1.0, 1.0)),
    "turned inside out": Matrix.Diagonal((-1.0, -1.0, -1.0, 1.0)),
    "skewed": Matrix(
        ((1.0, 0.5, 0.0, 0.2), (0.0, 1.0, 0.3, 0.0), (0.0, 0.2, 1.0, 0.0), (0, 0, 0, 1))
    ),
    "far away": Matrix.Translation((0.3, 0.2, -2000.0)),
}


@pytest.mark.parametrize("name", MATRICES)
def test_transforms_are_those_of_cycles(above, tmp_path, name):
    """A monkey under matrices that treat positions and normals differently."""
    add_monkey().matrix_world = MATRICES[name]
    above.camera.data.clip_end = 3000.0
    exported = assert_seen_as_in_cycles(above, tmp_path)
    sides = exported.mesh.vertices[exported.mesh.triangles].astype(np.float64)
    geometric = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    agree = np.einsum("na,nca->nc", geometric, exported.mesh.corner_normals) > 0.0
    assert agree.mean() > 0.99  # smooth normals may lean over the edge of a sharp triangle


def test_flattened_object_keeps_its_normals(above):
    """A scale of 0 along z has no inverse; what is left has normals along z, and no NaN."""
    obj = add_monkey()
    obj.scale = (1.0, 1.0, 0.0)
    exported = export_as_render(above)
    normals = exported.mesh.corner_normals
    assert np.isfinite(normals).all()
    np.testing.assert_allclose(np.abs(normals[..., 2]), 1.0, atol=1e-6)  # float32


MODIFIERS = {
    "subdivision": ("SUBSURF", {"levels": 0, "render_levels": 2}),
    "array": ("ARRAY", {"count": 3, "constant_offset_displace": (0.5, 0.1, 0.0)}),
    "mirror": ("MIRROR", {"use_axis": (False, True, False)}),
    "solidify": ("SOLIDIFY", {"thickness": 0.3}),
    "weighted normals": ("WEIGHTED_NORMAL", {}),
    "wireframe": ("WIREFRAME", {"thickness": 0.2}),
}


@pytest.mark.parametrize("name", MODIFIERS)
def test_modifiers_are_applied_as_for_a_render(above, tmp_path, name):
    """Render levels count, not the viewport's."""
    kind, values = MODIFIERS[name]
    obj = add_monkey(rotation=(0.3, 0.5, 0.0))
    modifier = obj.modifiers.new(name, kind)
    for key, value in values.items():
        setattr(modifier, key, value)
    if kind == "ARRAY":
        modifier.use_constant_offset = True
    assert_seen_as_in_cycles(above, tmp_path)


def add_text(scene):
    bpy.ops.object.text_add(location=(-1.5, -0.5, 0.0))
    bpy.context.object.data.body = "IW"
    bpy.context.object.data.extrude, bpy.context.object.data.bevel_depth = 0.1, 0.05
    bpy.context.object.scale = (2.0, 2.0, 2.0)


def add_bevelled_curve(scene):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.2)
    bpy.context.object.data.bevel_depth = 0.3
    bpy.context.object.modifiers.new("Array", "ARRAY")


def add_filled_curve(scene):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.2)
    bpy.context.object.data.dimensions, bpy.context.object.data.fill_mode = "2D", "BOTH"


def add_surface(scene):
    bpy.ops.surface.primitive_nurbs_surface_torus_add(radius=0.7)


def add_metaballs(scene):
    for x in (-0.6, 0.6):
        bpy.ops.object.metaball_add(location=(x, 0.0, 0.0))
        bpy.context.object.data.render_resolution = 0.15


SHAPES = (add_text, add_bevelled_curve, add_filled_curve, add_surface, add_metaballs)


@pytest.mark.parametrize("add", SHAPES, ids=lambda add: add.__name__)
def test_shapes_that_are_no_meshes_are_converted(above, tmp_path, add):
    """Text, curves, surfaces and metaballs, each once and at its render resolution."""
    add(above)
    for obj in above.objects:
        obj.pass_index = 3
    exported = assert_seen_as_in_cycles(above, tmp_path)
    assert list(exported.geometry.object_pass_index) == [3]
    assert exported.warnings == []


def test_what_has_no_faces_is_left_out(above, tmp_path):
    """Loose edges, an empty mesh, a curve without thickness: nothing, and no warning."""
    add_mesh(above, BENT, QUADS)
    wire = bpy.data.meshes.new("Wire")
    wire.from_pydata([(0, 0, 1), (1, 0, 1)], [(0, 1)], [])
    for mesh in (wire, bpy.data.meshes.new("Nothing")):
        above.collection.objects.link(bpy.data.objects.new(mesh.name, mesh))
    bpy.ops.curve.primitive_bezier_curve_add()
    exported = assert_seen_as_in_cycles(above, tmp_path)
    assert len(exported.mesh.triangles) == 4
    assert exported.warnings == []


def test_empty_scene_has_no_triangles(above):
    """A camera alone: arrays of length 0."""
    exported = export_as_render(above)
    assert exported.mesh.vertices.shape == (0, 3)
    assert exported.mesh.corner_normals.shape == (0, 3, 3)
    assert exported.warnings == []


def test_triangles_without_area_are_dropped_with_a_warning(above):
    """NaN, infinite and collapsed triangles go, one line says whose and how many."""
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (0, 0, 1), (1, 1, 1)]
    faces = [(0, 1, 2), (0, 1, 3), (0, 2, 4), (1, 2, 5), (1, 5, 5)]
    obj = add_mesh(above, points, faces[:4], "Broken")
    points[4:] = [(0, 0, np.nan), (1, np.inf, 1)]
    positions = np.array(points, np.float32).ravel()  # vertex.co would clamp an infinity
    obj.data.attributes["position"].data.foreach_set("vector", positions)
    add_mesh(above, BENT, QUADS, "Sound")
    exported = export_as_render(above)
    assert exported.warnings == [
        "Object Broken: 3 triangles left out (1 without area, "
        "2 with a vertex that is infinite or not a number): clean up its mesh"
    ]
    assert len(exported.mesh.triangles) == 5
    assert np.isfinite(exported.mesh.vertices).all()
    assert np.isfinite(exported.mesh.corner_normals).all()


@pytest.mark.parametrize("size", [1e-7, 1e10])
def test_tiny_and_huge_triangles_are_kept(above, size):
    """Squared areas that underflow or overflow float32 are areas nevertheless."""
    add_mesh(above, np.array(BENT) * size, QUADS).data.shade_flat()
    exported = export_as_render(above)
    assert exported.warnings == []
    lengths = np.linalg.norm(exported.mesh.corner_normals.astype(np.float64), axis=-1)
    np.testing.assert_allclose(lengths, 1.0, rtol=1e-6)  # float32


def test_object_with_broken_transform_is_left_out(above):
    """A scale that is no number: one line, and the others are rendered."""
    add_mesh(above, BENT, QUADS, "Lost").scale = (float("nan"), 1.0, 1.0)
    add_mesh(above, BENT, QUADS, "Sound")
    exported = export_as_render(above)
    assert exported.warnings == ["Not rendered, the object's transform is not finite: Lost"]
    assert len(exported.mesh.triangles) == 4

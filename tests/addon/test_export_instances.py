"""Who is rendered, where, and with which material: as in Cycles."""

import bmesh
import bpy
import numpy as np
import pytest
from parity.element_cases import add_nodes

from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS
from iwis.iwis_addon.export import ExportCancelled
from iwis.iwis_addon.export.placed.mesh import export_mesh
from support.above import BENT, QUADS, add_materials, add_mesh, add_monkey, look_from_above
from support.cycles_render import render_cycles
from support.trace_scene import assert_seen_as_in_cycles, export_as_render, trace


@pytest.fixture
def above(scene):
    """An empty file seen from above."""
    look_from_above(scene)
    return scene


def add_collection(scene, name, *objects):
    """A collection that is not in the scene itself, to be instanced."""
    collection = bpy.data.collections.new(name)
    for obj in objects:
        for owner in obj.users_collection:
            owner.objects.unlink(obj)
        collection.objects.link(obj)
    return collection


def add_instance(scene, collection, name="Instance", **place):
    empty = bpy.data.objects.new(name, None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    for key, value in place.items():
        setattr(empty, key, value)
    scene.collection.objects.link(empty)
    return empty


def test_collection_instances_stand_where_cycles_sees_them(above, tmp_path):
    """Turned, mirrored, nested in another collection; each object keeps its pass index."""
    monkey = add_monkey()
    monkey.pass_index, monkey.scale = 5, (0.5, 0.5, 0.5)
    text_data = bpy.data.curves.new("Text", "FONT")
    text_data.body, text_data.extrude = "W", 0.1
    text = bpy.data.objects.new("Text", text_data)
    text.pass_index, text.location = 6, (0.4, 0.3, 0.0)
    inner = add_collection(above, "Inner", monkey, text)
    add_instance(above, inner, location=(-1.0, -1.0, 0.0), rotation_euler=(0.4, 0.2, 0.5))
    add_instance(above, inner, location=(-1.0, 1.0, 0.0), scale=(-1.0, 1.4, 1.0))
    nested = bpy.data.objects.new("Nested", None)
    nested.instance_type, nested.instance_collection = "COLLECTION", inner
    nested.rotation_euler = (0.0, 0.0, 1.0)
    outer = add_collection(above, "Outer", nested)
    add_instance(above, outer, location=(1.0, 0.0, 0.0), rotation_euler=(0.3, 0.0, 0.0))
    exported = assert_seen_as_in_cycles(above, tmp_path)
    assert sorted(exported.geometry.object_pass_index.tolist()) == [5, 5, 5, 6, 6, 6]
    assert exported.warnings == []


@pytest.mark.parametrize("kind", ["VERTS", "FACES"])
def test_instances_on_vertices_and_faces(above, tmp_path, kind):
    """A parent's children stand on its vertices or faces; it shows if it is meant to."""
    parent = add_mesh(above, name="Parent")
    parent.instance_type = kind
    parent.show_instancer_for_render = kind == "FACES"
    child = add_monkey()
    child.parent, child.scale = parent, (0.3, 0.3, 0.3)
    assert_seen_as_in_cycles(above, tmp_path)


@pytest.mark.parametrize("emitter", [False, True])
def test_particles_show_their_object(above, tmp_path, emitter):
    """Each particle is a copy of the object; the emitter shows if it is meant to."""
    plane = add_mesh(above, name="Emitter")
    plane.show_instancer_for_render = emitter
    leaf = add_monkey(location=(9.0, 9.0, 0.0))
    plane.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = plane.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end = 12, 1, 1
    settings.physics_type, settings.lifetime = "NO", 100.0
    settings.render_type, settings.instance_object = "OBJECT", leaf
    settings.particle_size, settings.size_random = 0.5, 0.5
    above.frame_set(2)
    exported = assert_seen_as_in_cycles(above, tmp_path)
    assert len(exported.geometry.object_pass_index) == 12 + 1 + emitter


def scatter(nodes, link, geometry, out, material=None, realize=False):
    """An icosphere on each vertex of the mesh, beside the mesh itself."""
    sphere, place = (
        nodes.new("GeometryNodeMeshIcoSphere"),
        nodes.new("GeometryNodeInstanceOnPoints"),
    )
    sphere.inputs["Radius"].default_value = 0.3
    colour, join = nodes.new("GeometryNodeSetMaterial"), nodes.new("GeometryNodeJoinGeometry")
    colour.inputs["Material"].default_value = material
    link(sphere.outputs[0], colour.inputs["Geometry"])
    link(geometry, place.inputs["Points"])
    link(colour.outputs[0], place.inputs["Instance"])
    link(geometry, join.inputs[0])
    link(place.outputs[0], join.inputs[0])
    last = join.outputs[0]
    if realize:
        real = nodes.new("GeometryNodeRealizeInstances")
        link(last, real.inputs[0])
        last = real.outputs[0]
    link(last, out)


@pytest.mark.parametrize("realize", [False, True])
def test_geometry_nodes_instances_are_seen_as_in_cycles(above, tmp_path, realize):
    """Instances without an object of their own, with a material that only the nodes name."""
    obj = add_mesh(above)
    obj.pass_index = 2
    obj.rotation_euler = (0.2, 0.1, 0.3)
    add_materials(obj.data, 1)
    ball = bpy.data.materials.new("Ball")
    ball.pass_index = 8
    add_nodes(obj, lambda *sockets: scatter(*sockets, material=ball, realize=realize))
    assert_seen_as_in_cycles(above, tmp_path)
    exported = assert_same_materials(above, tmp_path)
    assert set(exported.materials) >= {("M1", 1), ("Ball", 8)}
    assert len(exported.geometry.object_pass_index) == (1 if realize else 7)


def test_geometry_nodes_may_turn_curves_into_meshes(above, tmp_path):
    """A curve object whose nodes make a mesh of it: the mesh is what renders."""
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.3)

    def build(nodes, link, geometry, out):
        fill = nodes.new("GeometryNodeFillCurve")
        link(geometry, fill.inputs[0])
        link(fill.outputs[0], out)

    add_nodes(bpy.context.object, build)
    assert_seen_as_in_cycles(above, tmp_path)


def test_ngons_are_cut_as_in_cycles(above, tmp_path):
    """A bent star of ten corners beside triangles and quads, with a material for each face."""
    angles = np.linspace(0.0, 2.0 * np.pi, 10, endpoint=False)
    radii = np.where(np.arange(10) % 2, 0.5, 1.3)
    star = [
        (r * np.cos(a), r * np.sin(a), 0.3 * np.cos(2 * a))
        for r, a in zip(radii, angles, strict=True)
    ]
    corners = [(-1.9, -1.9, 0), (-1.3, -1.9, 0), (-1.3, -1.3, 0.2), (-1.9, -1.3, 0)]
    lone = [(1.3, 1.3, 0), (1.9, 1.3, 0), (1.6, 1.9, 0.5)]
    faces = [tuple(range(10)), (10, 11, 12, 13), (14, 15, 16)]
    obj = add_mesh(above, star + corners + lone, faces)
    add_materials(obj.data, 3)
    for i, polygon in enumerate(obj.data.polygons):
        polygon.material_index = i
    assert_same_materials(above, tmp_path)


def assert_same_materials(scene, tmp_path):
    """The material that each pixel sees is the one in Cycles' Material Index pass."""
    layers = render_cycles(scene, tmp_path, ("z", "material_index"))
    exported = export_as_render(scene)
    mine = trace(exported)
    seen = layers.get("Material Index", layers.get("IndexMA"))[..., 0]
    index = np.array([material[1] if material else 0 for material in exported.materials])
    hit = mine["hit"] & (layers["Depth"][..., 0] < 1e9)
    different = (index[mine["material"]] != seen) & hit
    assert len(np.unique(seen[hit])) > 1
    assert different.mean() <= 0.003  # rays that graze an edge
    return exported


def test_material_slots_of_object_and_data(above, tmp_path):
    """A slot may belong to the object, be empty, or be named by a face though it does not exist."""
    obj = add_mesh(above, BENT, QUADS)
    grid = bmesh.new()
    bmesh.ops.create_grid(grid, x_segments=6, y_segments=1, size=1.5)
    grid.to_mesh(obj.data)
    add_materials(obj.data, 2)
    obj.data.materials.append(None)
    own = bpy.data.materials.new("Own")
    own.pass_index = 7
    twin = bpy.data.objects.new("Twin", obj.data)
    twin.location = (0.1, 0.2, -1.0)
    twin.scale = (1.3, 1.3, 1.0)
    above.collection.objects.link(twin)
    twin.material_slots[1].link = "OBJECT"
    twin.material_slots[1].material = own
    obj.data.materials.append(bpy.data.materials["M1"])
    for i, polygon in enumerate(obj.data.polygons):
        polygon.material_index = (0, 1, 2, 3, 9, 200)[i % 6]
    exported = assert_same_materials(above, tmp_path)
    assert set(exported.materials) == {("M1", 1), ("M2", 2), None, ("Own", 7)}


def test_object_without_slots_has_no_material(above):
    """No slot at all: None, the default grey."""
    add_mesh(above, BENT, QUADS)
    exported = export_as_render(above)
    assert exported.materials == [None]
    assert not exported.mesh.material_index.any()


def test_material_override_of_the_view_layer_wins(above):
    """The view layer's override replaces every slot."""
    obj = add_mesh(above, BENT, QUADS)
    add_materials(obj.data, 2)
    obj.data.polygons[1].material_index = 1
    above.view_layers[0].material_override = bpy.data.materials["M2"]
    assert export_as_render(above).materials == [("M2", 2)]


def test_hidden_objects_are_left_out(above, tmp_path):
    """hide_render, a collection hidden from renders, one excluded, and no ray at all to see by."""
    add_mesh(above, BENT, QUADS, "Seen").pass_index = 2
    add_mesh(above, np.add(BENT, (0, 0, 1)), QUADS, "Hidden").hide_render = True
    for name in ("Hidden Collection", "Excluded"):
        collection = bpy.data.collections.new(name)
        above.collection.children.link(collection)
        obj = bpy.data.objects.new(name, bpy.data.meshes["Hidden"])
        collection.objects.link(obj)
    bpy.data.collections["Hidden Collection"].hide_render = True
    above.view_layers[0].layer_collection.children["Excluded"].exclude = True
    ghost = add_mesh(above, np.add(BENT, (0, 0, 2)), QUADS, "Ghost")
    ghost.visible_camera = ghost.visible_shadow = False
    exported = assert_seen_as_in_cycles(above, tmp_path)
    assert len(exported.mesh.triangles) == 4
    assert exported.warnings == []


def test_what_is_not_rendered_is_named(above):
    """Volumes; curves without a point are nothing at all."""
    bpy.ops.object.light_add(type="SUN")
    bpy.ops.object.light_add(type="POINT")
    for kind, data in (
        ("Curves", bpy.data.hair_curves.new("c")),
        ("Cloud", bpy.data.volumes.new("v")),
    ):
        above.collection.objects.link(bpy.data.objects.new(kind, data))
    assert sorted(export_as_render(above).warnings) == [
        "Not rendered, volumes are not supported: Cloud",
    ]


def test_a_shading_offset_is_told(above):
    """Of the two settings of the shadow terminator the one that is left out, by object."""
    for name, offset in (("Plain", 0.0), ("Low", 0.2), ("Lower", 0.5)):
        obj = add_mesh(above, BENT, QUADS, name)
        obj.shadow_terminator_geometry_offset = 0.1
        obj.shadow_terminator_shading_offset = offset
    (line,) = export_as_render(above).warnings
    assert "Shading Offset" in line and line.endswith(": Low, Lower")


def test_flags_of_objects(above):
    """Who sees an object, and how: flags, one an object."""
    changes = {
        "Shy": ("visible_camera", False),
        "Pale": ("visible_shadow", False),
        "Hole": ("is_holdout", True),
        "Ground": ("is_shadow_catcher", True),
    }
    for name, (setting, value) in changes.items():
        setattr(add_mesh(above, BENT, QUADS, name), setting, value)
    add_mesh(above, BENT, QUADS, "Plain")
    mesh = export_as_render(above)
    both = CAMERA_RAYS | SHADOW_RAYS
    wanted = {
        "Shy": SHADOW_RAYS,
        "Pale": CAMERA_RAYS,
        "Hole": both | HOLDOUT,
        "Ground": both | SHADOW_CATCHER,
        "Plain": both,
    }
    found = {i.name: i.flags for i in mesh.geometry.inventory.instances if i.name in wanted}
    assert found == wanted


def test_cancel_stops_the_export(above):
    """cancelled() is asked before meshes are read and while they are placed."""
    add_monkey()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for patience in range(4):
        answers = iter([False] * patience + [True] * 100)
        with pytest.raises(ExportCancelled):
            export_mesh(depsgraph, [], cancelled=lambda answers=answers: next(answers))

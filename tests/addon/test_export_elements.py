"""Point clouds, hair curves and particle hair as parts of a scene."""

import bpy
import numpy as np
import pytest
from parity.element_cases import add_curves, add_particle_hair, add_points, bent_strands

from iwis.core.scene import ROUND
from iwis.iwis_addon.export import ExportError
from iwis.iwis_addon.export.meshes import mesh_size
from iwis.iwis_addon.export.placed.mesh import ExportCache
from support.above import add_mesh, look_from_above
from support.trace_scene import export_as_render, render_diffuse, trace


@pytest.fixture
def above(scene):
    """An empty file seen from above."""
    look_from_above(scene)
    return scene


def new_material(name="M", index=0):
    material = bpy.data.materials.new(name)
    material.pass_index = index
    return material


def test_points_of_geometry_nodes_are_spheres(above):
    """Where the points are, as large as their radius, with the material that nodes give."""
    add_points(new_material(index=3), np.float32([[0, 0, 0], [1, 1, 0.5]]), np.float32([0.5, 0.2]))
    exported = export_as_render(above)
    assert exported.warnings == []
    assert exported.materials == [("M", 3)]
    assert exported.geometry.terminator_offset.tolist() == [np.float32(ROUND)]
    seen = trace(exported)
    # The height over the middle of the larger one; 1e-3: chords of 5120 triangles.
    place, hit = seen["position"], seen["hit"]
    near = hit & (np.hypot(place[..., 0], place[..., 1]) < 0.4)
    assert near.sum() > 50
    np.testing.assert_allclose(np.linalg.norm(place[near], axis=-1), 0.5, atol=2e-3)
    np.testing.assert_allclose(seen["normal"][near], place[near] / 0.5, atol=2e-2)


def test_curves_follow_their_transform_and_slots(above):
    """Strands go with their object; a curve without a point is nothing."""
    places, radii = bent_strands(20, 5), np.full((20, 5), 0.05)
    obj = add_curves(new_material(index=4), places, radii, location=(1.0, 0.0, 0.0))
    obj.data.attributes.new("material_index", "INT", "CURVE").data[3].value = 7
    exported = export_as_render(above)
    assert exported.warnings == [] and exported.materials == [("M", 4)]
    low, high = exported.mesh.vertices.min(0), exported.mesh.vertices.max(0)
    assert (low[0] - 1.0) == pytest.approx(places[..., 0].min(), abs=0.06)
    assert high[2] == pytest.approx(places[..., 2].max(), abs=0.06)


@pytest.mark.parametrize(
    ("types", "straight_in_5"),
    [
        ([("POLY", None)], True),
        ([("POLY", None), ("CATMULL_ROM", [0])], False),
        ([("NURBS", None)], False),
        ([("NURBS", None), ("POLY", [0])], True),
    ],
)
def test_curves_are_polylines_where_the_first_one_is(above, types, straight_in_5):
    """As Cycles of Blender 5 draws all; 4.5 knows splines alone, which swing out at a corner."""
    corner = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    strands = np.stack([corner, corner + np.float32([0, 0, 1])])
    obj = add_curves(new_material(), strands, np.full((2, 3), 0.05))
    for kind, some in types:
        obj.data.set_types(type=kind, **({} if some is None else {"indices": some}))
    lowest = export_as_render(above).mesh.vertices[:, 1].min()
    straight = straight_in_5 and bpy.app.version >= (5, 0)
    assert (lowest > -0.0501) == straight  # a spline: a sixteenth below, and the radius


def test_particle_hair_stands_on_its_emitter(above):
    """As many strands as Blender says, of the length and the slot that the settings have; the
    emitter itself may be hidden."""
    plane = add_mesh(above, name="Lawn")
    plane.data.materials.append(new_material("Soil", 1))
    plane.data.materials.append(new_material("Grass", 2))
    plane.show_instancer_for_render = False
    hair = add_particle_hair(plane, 40, hair_length=0.5, material=2)
    hair.render_step = 2
    exported = export_as_render(above)
    assert exported.warnings == []
    assert {exported.materials[k] for k in set(exported.mesh.material_index)} == {("Grass", 2)}
    # Four segments of four pieces and 32 sides; the tips have no radius.
    assert len(exported.mesh.triangles) == 40 * (4 * 4 * 2 - 1) * 32
    assert 0.4 < np.ptp(exported.mesh.vertices[:, 2]) < 1.4
    assert set(exported.mesh.object_index) == {0}


def test_hair_of_an_instance_stands_with_it(above):
    """A collection's hairy object shows its hair at each instance."""
    plane = add_mesh(above, name="Lawn")
    add_particle_hair(plane, 10)
    plane.show_instancer_for_render = False
    alone = len(export_as_render(above).mesh.triangles)
    collection = bpy.data.collections.new("Lawns")
    above.collection.objects.unlink(plane)
    collection.objects.link(plane)
    for x in (-1.0, 1.0):
        empty = bpy.data.objects.new("E", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location = (x, 0.0, 0.0)
        above.collection.objects.link(empty)
    exported = export_as_render(above)
    assert len(exported.mesh.triangles) == 2 * alone
    first, second = np.split(exported.mesh.vertices, 2)
    # 1e-5: float32, and Blender's own through another matrix
    np.testing.assert_allclose(np.abs(second - first)[:, 0], 2.0, atol=1e-5)
    np.testing.assert_allclose(second[:, 1:], first[:, 1:], atol=1e-5)


def test_unchanged_strands_are_not_made_again(above):
    """The next frame gets the very same table of triangles."""
    add_curves(new_material(), bent_strands(20, 5), np.full((20, 5), 0.05))
    add_points(new_material(), np.zeros((1, 3), np.float32), np.float32([0.2]))
    cache = ExportCache()
    first = export_as_render(above, cache=cache).mesh
    assert export_as_render(above, cache=cache).mesh is first
    bpy.data.objects["Strands"].data.attributes["radius"].data[0].value = 0.5
    assert export_as_render(above, cache=cache).mesh is not first


def test_strands_without_room_name_their_object(above, monkeypatch):
    """Before they are made."""
    monkeypatch.setattr(mesh_size, "free_memory_bytes", lambda: 100_000)
    add_curves(new_material(), bent_strands(20, 5), np.full((20, 5), 0.05))
    with pytest.raises(ExportError, match=r"Object Strands: its 20 strands are [\d,]+ triangles"):
        export_as_render(above)


def test_zero_and_broken_radii(above):
    """Points and strands of no size are left out; one that is not a number too."""
    radii = np.float32([0.0, np.nan, 0.3])
    add_points(new_material(), np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), radii)
    add_curves(new_material(), bent_strands(4, 3), np.zeros((4, 3)))
    exported = export_as_render(above)
    assert len(exported.mesh.triangles) == 20 * 4**4


def test_large_points_are_seen_as_in_cycles(above, tmp_path):
    """First hits and normals: spheres of 5120 triangles against Cycles' own."""
    add_points(new_material(), np.float32([[0, 0, 0]]), np.float32([0.8]))
    seen = render_diffuse(above, tmp_path)
    mine = trace(export_as_render(above))
    hit = (seen["Depth"][..., 0] < 1e9) & mine["hit"]
    assert ((seen["Depth"][..., 0] < 1e9) != mine["hit"]).mean() < 0.01
    inner = hit & (np.hypot(*np.moveaxis(mine["position"], -1, 0)[:2]) < 0.6)
    np.testing.assert_allclose(mine["position"][inner], seen["Position"][inner], atol=3e-3)
    np.testing.assert_allclose(mine["normal"][inner], seen["Normal"][inner], atol=1e-2)

"""An animation copies only what has changed, and never renders an older frame's geometry."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import ExportCache, ExportError, free_memory
from iwis.iwis_addon.export.meshes import mesh_size
from support.above import add_materials, add_mesh, add_monkey, look_from_above
from support.trace_scene import export_as_render


@pytest.fixture
def above(scene):
    """A monkey and two bent quads, seen from above."""
    look_from_above(scene)
    add_monkey(location=(0.0, 0.0, -1.0))
    obj = add_mesh(scene)
    add_materials(obj.data, 2)
    return scene


def change_nothing(obj):
    pass


def move(obj):
    obj.location.x += 0.25


def bend(obj):
    obj.data.vertices[2].co.z += 0.25
    obj.data.update()


def turn_a_face(obj):
    obj.data.polygons[0].flip()
    obj.data.update()


def shade_smooth(obj):
    obj.data.shade_smooth()


def set_normals(obj):
    obj.data.normals_split_custom_set([(0.0, 0.6, 0.8)] * 8)


def paint_a_face(obj):
    obj.data.polygons[1].material_index = 1


def swap_materials(obj):
    obj.material_slots[0].link = "OBJECT"
    obj.material_slots[0].material = bpy.data.materials["M2"]


def add_modifier(obj):
    obj.modifiers.new("Array", "ARRAY")


def hide(obj):
    obj.hide_render = True


def instance(obj):
    twin = bpy.data.objects.new("Twin", obj.data)
    twin.location.y = 3.0
    bpy.context.scene.collection.objects.link(twin)


CHANGES = (
    move,
    bend,
    turn_a_face,
    shade_smooth,
    set_normals,
    paint_a_face,
    swap_materials,
    add_modifier,
    hide,
    instance,
)


def arrays(exported):
    mesh = exported.mesh
    seen = np.array([name for name, _ in filter(None, exported.materials)] + ["None"])
    return (
        mesh.vertices,
        mesh.triangles,
        mesh.corner_normals,
        seen[np.minimum(mesh.material_index, len(seen) - 1)],
        mesh.object_index,
    )


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_cache_sees_every_change(above, change):
    """After any change the cached export equals one without a cache, and differs from the last."""
    cache = ExportCache()
    before = export_as_render(above, cache)
    change(bpy.data.objects["Thing"])
    after = export_as_render(above, cache)
    fresh = export_as_render(above)
    assert after.mesh is not before.mesh
    for cached, new in zip(arrays(after), arrays(fresh), strict=True):
        np.testing.assert_array_equal(cached, new)
    assert any(
        old.shape != new.shape or (old != new).any()
        for old, new in zip(arrays(before), arrays(after), strict=True)
    )


def test_cache_returns_the_same_mesh_while_nothing_changes(above):
    """Frames, cameras and renders may change: the table is the same object, so a BVH can stay."""
    cache = ExportCache()
    first = export_as_render(above, cache)
    above.frame_set(17)
    above.camera.location.x += 0.5
    second = export_as_render(above, cache)
    assert second.mesh is first.mesh
    assert second.camera.camera_to_world[0, 3] != first.camera.camera_to_world[0, 3]


def test_cache_repeats_its_warnings(above):
    """A frame taken from the cache tells of left-out triangles as the first one did."""
    thing = bpy.data.objects["Thing"].data
    positions = np.zeros(3 * len(thing.vertices), np.float32)
    thing.attributes["position"].data.foreach_set("vector", positions)
    cache = ExportCache()
    first, second = export_as_render(above, cache), export_as_render(above, cache)
    assert second.mesh is first.mesh
    assert second.warnings == first.warnings != []


def test_cache_tells_objects_apart_by_their_pass_index(above):
    """A pass index may change without any geometry changing."""
    cache = ExportCache()
    first = export_as_render(above, cache)
    bpy.data.objects["Thing"].pass_index = 5
    second = export_as_render(above, cache)
    assert second.mesh is first.mesh
    assert sorted(second.geometry.object_pass_index) == [0.0, 5.0]


def test_next_frame_shares_what_has_not_moved(above):
    """Of a frame in which one object moves, only vertices and normals are new arrays."""
    cache = ExportCache()
    before = export_as_render(above, cache).mesh
    move(bpy.data.objects["Thing"])
    after = export_as_render(above, cache).mesh
    assert after.triangles is before.triangles
    assert after.material_index is before.material_index
    moved = (after.vertices != before.vertices).any(axis=1)
    assert moved.sum() == len(bpy.data.objects["Thing"].data.vertices)


def test_object_that_turns_inside_out_is_placed_anew(above):
    """A negative scale turns the winding round, which is not shared with the last frame."""
    cache = ExportCache()
    before = export_as_render(above, cache).mesh
    bpy.data.objects["Thing"].scale.x = -1.0
    after, fresh = export_as_render(above, cache), export_as_render(above)
    assert after.mesh.triangles is not before.triangles
    for cached, new in zip(arrays(after), arrays(fresh), strict=True):
        np.testing.assert_array_equal(cached, new)


def test_scene_larger_than_the_free_memory_is_refused(above, monkeypatch):
    """The message says how much is needed and free, and names the object with most triangles."""
    monkeypatch.setattr(mesh_size, "free_memory_bytes", lambda: 100_000)
    with pytest.raises(ExportError, match=r"they need 0\.0 GB, .* Object Suzanne has 968 of them"):
        export_as_render(above)
    monkeypatch.setattr(mesh_size, "free_memory_bytes", lambda: 300_000)
    assert len(export_as_render(above).mesh.triangles) > 968


def test_memory_of_a_container_counts(tmp_path):
    """What a control group leaves, with the caches of files that it holds; no limit: not known."""
    assert free_memory._of_container(tmp_path) is None
    (tmp_path / "memory.current").write_text("700\n")
    (tmp_path / "memory.stat").write_text("anon 500\ninactive_file 150\n")
    (tmp_path / "memory.max").write_text("1000\n")
    assert free_memory._of_container(tmp_path) == 450
    (tmp_path / "memory.max").write_text("max\n")
    assert free_memory._of_container(tmp_path) is None
    assert free_memory.free_memory_bytes() is None or free_memory.free_memory_bytes() > 0

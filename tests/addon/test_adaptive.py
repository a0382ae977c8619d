"""Adaptive subdivision: what is diced, how finely, when anew, and what is carried over."""

import bpy
import numpy as np
import pytest
from parity.dicing_cases import diced
from parity.movers import by_keys

from iwis.core.fine_meshes import dicing
from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.meshes import diced_mesh
from iwis.iwis_addon.export.same import same
from support.frames import exported_in_motion

_OWN = "Cube"


@pytest.fixture
def cube(cube_scene):
    """Seen by 100 x 100 pixels, in a window, whose graph is the one outside of a render."""
    render = cube_scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 100, 100, 100
    cube_scene.cycles.preview_dicing_rate = 1.0
    return bpy.data.objects[_OWN]


def exported(**options):
    lines, found = [], []
    scene = export_scene(
        bpy.context.evaluated_depsgraph_get(), warnings=lines, geometry=found, **options
    )
    assert lines == []
    return scene, found[0]


def part_of(geometry, name=_OWN):
    row = [i.name for i in geometry.inventory.instances].index(name)
    return geometry.inventory.parts[geometry.inventory.instances[row].part]


def set_pixels(obj, pixels):
    if bpy.app.version >= (5, 0):
        obj.modifiers[-1].adaptive_pixel_size = pixels
    else:
        obj.cycles.dicing_rate = pixels


def count():
    return len(part_of(exported()[1]).triangles)


def test_it_is_as_fine_as_it_is_seen(cube):
    """Four times as many for half the pixels to an edge; in a window by the preview's rate."""
    settings = bpy.context.scene.cycles
    settings.dicing_rate = 50.0
    diced(cube, 2.0, "SIMPLE")
    coarse = count()
    set_pixels(cube, 1.0)
    assert 3.5 < count() / coarse < 4.5
    settings.preview_dicing_rate = 2.0
    assert count() == coarse
    settings.max_subdivisions = 1
    assert count() == 6 * 2 * 2**2


def test_what_is_not_adaptive_is_taken_as_it_is(cube):
    """No other array, with the modifier as one of all, hidden, not the last one, or for baking."""
    modifier = cube.modifiers.new("Plain", "SUBSURF")
    plain = part_of(exported()[1])
    assert plain.diced is None and len(plain.triangles) == 6 * 2 * 4
    cube.modifiers.remove(modifier)
    diced(cube)
    assert part_of(exported()[1]).diced is not None
    assert part_of(exported(diced=False)[1]).diced is None
    cube.modifiers.new("Last", "TRIANGULATE")
    assert part_of(exported()[1]).diced is None
    cube.modifiers.move(1, 0)
    assert part_of(exported()[1]).diced is not None
    cube.modifiers["Diced"].show_viewport = False
    assert len(part_of(exported()[1]).triangles) == 12


if bpy.app.version < (5, 0):

    def test_it_is_experimental_in_older_blenders(cube):
        """As in Cycles, the feature set decides."""
        diced(cube)
        bpy.context.scene.cycles.feature_set = "SUPPORTED"
        assert part_of(exported()[1]).diced is None


def test_nothing_of_the_users_is_touched(cube):
    """No update follows an export: a window would never come to rest."""
    diced(cube)
    exported()
    seen = []

    def see(*_):
        seen.append(1)

    bpy.app.handlers.depsgraph_update_post.append(see)
    try:
        exported()
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(see)
    assert seen == [] and len(cube.data.vertices) == 8


def test_faces_keep_materials_and_shading(cube):
    """Slots and flat faces, by area of the cube's six faces."""
    diced(cube, 8.0, "SIMPLE")
    for name in ("A", "B"):
        cube.data.materials.append(bpy.data.materials.new(name))
    faces = np.arange(6)
    cube.data.polygons.foreach_set("material_index", (faces % 2).astype(np.int32))
    cube.data.polygons.foreach_set("use_smooth", faces < 3)
    scene, geometry = exported()
    part = part_of(geometry)
    a, b, c = (part.positions[corner] for corner in part.triangles.T)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert areas @ part.slots == pytest.approx(areas.sum() / 2, rel=1e-5)
    assert areas[part.flat].sum() == pytest.approx(areas.sum() / 2, rel=1e-5)
    assert set(scene.mesh.material_index[scene.mesh.object_index == 0].tolist()) == {0, 1}


def test_instances_share_what_is_diced_once(cube):
    """As fine as the object itself is seen, as in Cycles, wherever copies of it stand."""
    diced(cube)
    alone = part_of(exported()[1])
    own = bpy.data.collections.new("Own")
    own.objects.link(cube)
    for place in (1.0, -30.0):
        empty = bpy.data.objects.new("Copy", None)
        bpy.context.scene.collection.objects.link(empty)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty.location.y = place
    _, geometry = exported()
    instances = [i for i in geometry.inventory.instances if i.name == _OWN]
    assert len(instances) == 3 and len({i.part for i in instances}) == 1
    np.testing.assert_array_equal(part_of(geometry).triangles, alone.triangles)


def test_it_is_diced_again_only_when_something_differs(cube):
    """The same mesh for the same camera; another one for another camera, and place."""
    diced(cube)
    cache = ExportCache()
    first, _ = exported(cache=cache)
    assert exported(cache=cache)[0].mesh is first.mesh
    bpy.context.scene.camera.location.z += 1.0
    second, _ = exported(cache=cache)
    assert len(second.mesh.triangles) != len(first.mesh.triangles)
    cube.data.uv_layers[0].data[0].uv = 0.3, 0.4  # not of the shape
    cube.data.update_tag()
    assert exported(cache=cache)[0].mesh is second.mesh
    cube.data.vertices[0].co.x -= 0.5
    cube.data.update_tag()
    assert exported(cache=cache)[0].mesh is not second.mesh


def test_a_window_does_not_dice_again_as_the_view_turns(cube):
    """As Cycles': a new view alone reads nothing anew; the preview's rate does."""
    diced(cube)
    cache, live = ExportCache(), LiveExport()
    cache.live = live.meshes

    def update():
        graph = bpy.context.evaluated_depsgraph_get()
        live.begin(graph.updates)
        return exported(cache=cache, live=live)[0]

    first = update()
    bpy.context.scene.camera.location.z += 1.0
    bpy.context.view_layer.update()
    live.begin([])
    assert same(exported(cache=cache, live=live)[0].mesh, first.mesh)
    bpy.context.scene.cycles.preview_dicing_rate /= 2.0
    assert len(update().mesh.triangles) > len(first.mesh.triangles)


def test_too_little_memory_is_told(cube, monkeypatch):
    """It is diced as finely as there is room, with a warning that names it."""
    diced(cube, 1.0, "SIMPLE")
    whole = count()
    monkeypatch.setattr(diced_mesh, "free_memory_bytes", lambda: 500 * (whole // 3))
    lines, found = [], []
    graph = bpy.context.evaluated_depsgraph_get()
    export_scene(graph, warnings=lines, geometry=found)
    (line,) = lines
    assert line.startswith("Object Cube: diced to edges of ") and "more than" in line
    assert whole // 8 < len(part_of(found[0]).triangles) < whole // 2


@pytest.mark.parametrize("place", [float("nan"), float("inf"), 1e30])
def test_places_that_are_no_numbers_end(cube, place):
    """They were diced without end; what is not finite is told and left out, as of other meshes."""
    diced(cube, 1.0)
    cube.data.vertices[0].co.x = place
    lines = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    assert np.isfinite(scene.mesh.vertices).all()
    if not np.isfinite(place):
        assert any("Object Cube" in line and "left out" in line for line in lines)


def test_absurd_fineness_comes_to_an_end(cube, monkeypatch):
    """Far from what there is room for, it gets coarser in ever larger steps: ten at the most."""
    diced(cube, 1.0, "SIMPLE")
    set_pixels(cube, 0.1)
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 4000
    bpy.context.scene.cycles.preview_dicing_rate = 0.1
    asked = []
    monkeypatch.setattr(diced_mesh, "free_memory_bytes", lambda: 500 * 5000)
    original = dicing.split_patches
    monkeypatch.setattr(dicing, "split_patches", lambda *own: asked.append(1) or original(*own))
    lines = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    assert any(line.startswith("Object Cube: diced to edges of ") for line in lines)
    assert 24 < len(scene.mesh.triangles) < 10_000 and len(asked) <= 10


def test_micropolygons_move_with_their_cage(cube):
    """While the shutter is open they stay where they are on its faces: a cube that a shape key
    stretches stays one of flat faces."""
    diced(cube, 4.0, "SIMPLE")
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)
    by_keys(cube)
    found, lines = exported_in_motion()
    (shapes,) = found.motion.shapes
    assert lines == []
    middle = shapes.positions[1][shapes.corners]
    np.testing.assert_allclose(middle, found.mesh.vertices[found.mesh.triangles[shapes.triangle]])
    first, _, last = (places[shapes.corners] for places in shapes.positions)
    np.testing.assert_allclose((first + last) / 2.0, middle, atol=2e-6)  # keys are linear
    assert np.abs(last - first).max() > 0.09


def test_seams_are_kept(cube):
    """Corner values are those of the triangle's own face: maps of a cube's faces do not mix."""
    diced(cube, 4.0, "SIMPLE")
    material = bpy.data.materials.new("Mapped")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    nodes = [tree.nodes.new(f"ShaderNode{kind}") for kind in ("UVMap", "TexChecker")]
    tree.links.new(nodes[0].outputs[0], nodes[1].inputs["Vector"])
    tree.links.new(nodes[1].outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    cube.data.materials.append(material)
    scene, geometry = exported()
    part, surface = part_of(geometry), scene.shaders.surface
    uv = surface.tables["uv:"][surface.row[scene.mesh.object_index == 0]]
    places = part.positions[part.triangles]
    (du, dv), (eu, ev) = (uv[:, k].T - uv[:, 0].T for k in (1, 2))
    areas = np.linalg.norm(
        np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]), axis=1
    )
    ratios = np.abs(du * ev - dv * eu) / areas  # the same all over a cube's map
    np.testing.assert_allclose(ratios, ratios.mean(), rtol=1e-2)

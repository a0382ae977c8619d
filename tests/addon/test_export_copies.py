"""Which instances are left to Embree, and that they look as if they were written out."""

import bpy
import numpy as np
import pytest

from iwis.core.embree.copied_rows import written_out
from iwis.core.film import Film
from iwis.core.render import render
from iwis.core.settings import RenderSettings
from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.motion import object_motion
from iwis.iwis_addon.export.placed import copied
from support.above import add_mesh, look_from_above
from support.frames import exported_in_motion

LEAVES = 60


@pytest.fixture
def few(monkeypatch):
    """Copies of meshes as small as those here."""
    for name, least in (("_LEAST", 2), ("_LEAST_OF_ONE", 2), ("_FEW", 2), ("_MANY", 2)):
        monkeypatch.setattr(copied, name, least)


def node(material, kind):
    """A new node, and the material's own BSDF."""
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    bsdf = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    return tree.nodes.new(kind), bsdf, tree.links


def leaves(n=LEAVES):
    """Quads that lie in all directions, with a UV map."""
    rng = np.random.default_rng(1)
    middle = rng.normal(size=(n, 3)) * 0.15
    u, v = (rng.normal(size=(n, 3)) * 0.1 for _ in range(2))
    corners = np.stack([middle, middle + u, middle + u + v, middle + v], 1)
    quads = np.arange(4 * n).reshape(n, 4)
    mesh = bpy.data.meshes.new("Leaves")
    mesh.from_pydata(corners.reshape(-1, 3).tolist(), [], quads.tolist())
    uv = mesh.uv_layers.new(name="UV")
    uv.data.foreach_set("uv", np.tile(np.float32([0, 0, 1, 0, 1, 1, 0, 1]), n))
    return mesh


def dotted_leaf():
    """A material with a color of the object's own, and an alpha of an image."""
    material = bpy.data.materials.new("Leaf")
    info, bsdf, links = node(material, "ShaderNodeObjectInfo")
    ramp, _, _ = node(material, "ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color = (0.8, 0.1, 0.05, 1.0)
    ramp.color_ramp.elements[1].color = (0.1, 0.6, 0.9, 1.0)
    links.new(info.outputs["Random"], ramp.inputs[0])
    links.new(ramp.outputs[0], bsdf.inputs["Base Color"])
    image = bpy.data.images.new("Alpha", 16, 16, alpha=True)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[4:12, 4:12, 3] = 0.0
    image.pixels.foreach_set(pixels.ravel())
    texture, _, _ = node(material, "ShaderNodeTexImage")
    texture.image, texture.interpolation = image, "Closest"
    links.new(texture.outputs["Alpha"], bsdf.inputs["Alpha"])
    return material


def forest(scene, mesh, n=12):
    """Objects of one mesh: turned, stretched, some mirrored, one a holdout; above a floor."""
    rng = np.random.default_rng(2)
    objects = []
    for k in range(n):
        obj = bpy.data.objects.new(f"Tree {k}", mesh)
        obj.location = (*rng.uniform(-1.2, 1.2, 2), 0.3)
        obj.rotation_euler = rng.uniform(0.0, 6.0, 3)
        obj.scale = rng.uniform(0.6, 1.4, 3) * (-1.0 if k % 4 == 1 else 1.0, 1.0, 1.0)
        obj.is_holdout = k == 3
        obj.pass_index = k + 1
        scene.collection.objects.link(obj)
        objects.append(obj)
    corners = [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)]
    floor = add_mesh(scene, corners, [(0, 1, 2, 3)], "Floor")
    floor.pass_index = 99
    return objects


@pytest.fixture
def above(scene, few):
    """A forest of leaves seen from above."""
    look_from_above(scene)
    scene.world = bpy.data.worlds.new("Grey")
    scene.world.color = (0.5, 0.6, 0.7)
    mesh = leaves()
    mesh.materials.append(dotted_leaf())
    return scene, forest(scene, mesh)


def export(**options):
    return export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[], **options)


def picture(scene, **options):
    own = {"max_samples": 16, "stop_rule": "FIXED", "threads": 2} | options
    film = Film(scene.camera.region)
    render(scene, RenderSettings(**own), film)
    return film.layers


def shares_off(found, expected):
    """Of each layer the share of pixels that differ by more than float32's steps explain."""
    return {
        name: (np.abs(found[name] - values) > 1e-2 * np.abs(values) + 1e-3).any(axis=2).mean()
        for name, values in expected.items()
    }


def test_a_forest_is_copies_and_looks_as_if_it_were_written_out(above):
    _, objects = above
    found, expected = export(), export(written_out=True)
    assert expected.copies is None
    assert len(found.copies.objects) == len(objects) - 1
    assert len(found.mesh.triangles) == 2 * LEAVES + 2
    assert len(expected.mesh.triangles) == 2 * LEAVES * len(objects) + 2
    ours, theirs = picture(found), picture(expected)
    off = shares_off(ours, theirs)
    assert off["object_index"] == off["depth"] == off["uv"] == 0.0
    # What half clear borders of the dots let through is drawn, of instances with other numbers.
    mean = {"max_samples": 256}
    means = (picture(one, **mean)["combined"].mean(axis=(0, 1)) for one in (found, expected))
    np.testing.assert_allclose(*means, rtol=2e-3)
    assert (ours["combined"][..., 3] < 0.5).any()  # the holdout


def test_opaque_copies_are_the_same_pixel_by_pixel(above):
    _, objects = above
    material = objects[0].data.materials[0]
    alpha = node(material, "ShaderNodeValue")[1].inputs["Alpha"]
    material.node_tree.links.remove(alpha.links[0])
    off = shares_off(*map(picture, (export(), export(written_out=True))))
    # A shadow ray in thousands that grazes an edge is told otherwise by instances.
    assert max(off.values()) < 0.01, off


def test_copies_written_out_by_the_core_are_those_of_the_export(above):
    found, expected = written_out(export()), export(written_out=True)
    corners = (m.vertices[m.triangles].mean(axis=1) for m in (found.mesh, expected.mesh))
    ours, theirs = (places[np.lexsort(np.round(places, 4).T)] for places in corners)
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=2e-4)


@pytest.mark.parametrize("kind", ["shines", "moves", "hidden", "fresnel", "linked", "few"])
def test_what_needs_triangles_of_its_own_is_written_out(above, kind):
    scene, objects = above
    material = objects[0].data.materials[0]
    if kind == "shines":
        node(material, "ShaderNodeValue")[1].inputs["Emission Strength"].default_value = 1.0
    elif kind == "moves":
        displacement, _, links = node(material, "ShaderNodeDisplacement")
        displacement.inputs["Height"].default_value = 0.7
        output = next(n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
        links.new(displacement.outputs[0], output.inputs["Displacement"])
        material.displacement_method = "DISPLACEMENT"
    elif kind == "hidden":
        for obj in objects:
            obj.visible_shadow = False
    elif kind == "fresnel":
        fresnel, bsdf, links = node(material, "ShaderNodeFresnel")
        links.new(fresnel.outputs[0], bsdf.inputs["Alpha"])
    elif kind == "linked":
        group = bpy.data.collections.new("Lit")
        light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
        scene.collection.objects.link(light)
        light.light_linking.receiver_collection = group
    else:
        for obj in objects[2:]:
            bpy.data.objects.remove(obj)
        objects[1].scale = (0.0, 1.0, 1.0)  # flat: there is no way back from it
    assert export().copies is None


def test_those_that_rays_see_otherwise_are_written_out_alone(above):
    _, objects = above
    objects[0].visible_camera = False
    objects[1].is_shadow_catcher = True
    found = export()
    assert len(found.copies.objects) == len(objects) - 3
    assert len(np.unique(found.mesh.object_index)) == 1 + 3  # and the floor


def test_many_copies_beside_what_moves_leave_fewer_slices(above, monkeypatch):
    """Each slice has a hierarchy over all of them."""
    scene, _ = above
    scene.render.use_motion_blur = True
    floor = scene.objects["Floor"]
    for frame, height in ((0, 0.0), (2, -1.0)):
        floor.location.z = height
        floor.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    assert len(exported_in_motion()[0].motion.times) == 64
    monkeypatch.setattr(object_motion, "_MOST_PLACES", 64)  # one moves, and eleven stand
    assert len(exported_in_motion()[0].motion.times) == 16


def test_copies_of_what_has_no_area_are_nothing(above):
    """With others beside them, and alone."""
    scene, objects = above
    mesh = objects[0].data
    mesh.vertices.foreach_set("co", np.zeros(3 * len(mesh.vertices), np.float32))
    mesh.update()
    bpy.context.view_layer.update()
    found = export()
    assert found.copies is None and len(found.mesh.triangles) == 2
    bpy.data.objects.remove(scene.objects["Floor"])
    assert len(export().mesh.triangles) == 0
    assert not picture(export())["samples"].any()


def test_the_mesh_table_is_kept_while_copies_stand_still(above):
    _, objects = above
    cache = ExportCache()
    first, second = (export(cache=cache) for _ in range(2))
    assert second.mesh is first.mesh and second.copies is first.copies
    objects[5].location.x += 0.5
    bpy.context.view_layer.update()
    third = export(cache=cache)
    assert third.mesh is first.mesh and third.copies is not first.copies
    assert np.abs(third.copies.matrices - first.copies.matrices).max() == pytest.approx(0.5)
    original = objects[int(first.mesh.object_index[first.copies.first[0]])]
    original.location.x += 0.5
    bpy.context.view_layer.update()
    assert export(cache=cache).mesh is not first.mesh
    emission = node(objects[0].data.materials[0], "ShaderNodeValue")[1].inputs["Emission Strength"]
    emission.default_value = 1.0
    bpy.context.view_layer.update()
    assert export(cache=cache).copies is None


def test_a_window_makes_copies_of_less(above, monkeypatch):
    monkeypatch.setattr(copied, "_MANY", 1 << 30)
    monkeypatch.setattr(copied, "_OF_A_PIXEL", 10)  # 23,040 for 48 x 48 pixels
    assert export().copies is None
    assert export(cache=ExportCache(), live=LiveExport()).copies is not None


def test_alpha_of_an_object_s_own_is_not_that_of_another(above):
    """Triangles that look the same share a grid, but not where their object has a say."""
    _, objects = above
    material = objects[0].data.materials[0]
    attribute, bsdf, links = node(material, "ShaderNodeAttribute")
    attribute.attribute_type, attribute.attribute_name = "OBJECT", "clear"
    links.new(attribute.outputs["Fac"], bsdf.inputs["Alpha"])
    for k, obj in enumerate(objects):
        obj["clear"] = float(k % 2)
    shared = export()
    assert shared.copies is None
    for obj in objects:
        obj.data = obj.data.copy()
        obj.data.vertices[0].co.x += 1e-5  # no grid is shared between different corners
    bpy.context.view_layer.update()
    ours, theirs = picture(shared)["combined"], picture(export())["combined"]
    assert ours[..., :3].mean() == pytest.approx(theirs[..., :3].mean(), rel=1e-3)


@pytest.mark.parametrize("moves", ["camera", "tree", "leaves", "floor"])
def test_copies_stand_still_while_the_shutter_is_open(above, moves):
    """What moves, or has the shape of what changes it, is no copy; the rest is."""
    scene, objects = above
    scene.render.use_motion_blur = True
    alpha = node(objects[0].data.materials[0], "ShaderNodeValue")[1].inputs["Alpha"]
    alpha.id_data.links.remove(alpha.links[0])
    if moves == "leaves":
        mesh = objects[0].data
        objects[0].shape_key_add(name="Basis")
        objects[0].shape_key_add(name="Wide").data[0].co.x += 0.5
        moved = mesh.shape_keys.key_blocks["Wide"]
        for frame, value in ((0, 0.0), (2, 1.0)):
            moved.value = value
            moved.keyframe_insert("value", frame=frame)
    else:
        what = {"camera": scene.camera, "tree": objects[5], "floor": scene.objects["Floor"]}
        moved = what[moves]
        for frame, value in ((0, 0.0), (2, 1.0)):
            moved.location.z = moved.location.z + value
            moved.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    found, lines = exported_in_motion()
    assert (found.copies is None) == (moves in ("tree", "leaves"))
    assert (found.motion is None) == (moves == "camera")
    assert len(lines) == len(set(lines))
    ours = picture(found, max_samples=64)
    if found.copies is None:
        return
    copied._MANY = copied._FEW = 1 << 40
    whole, _ = exported_in_motion()
    assert whole.copies is None
    off = shares_off(ours, picture(whole, max_samples=64))
    # As above, at more rays: one that meets an edge otherwise teaches a whole cell otherwise.
    assert max(off.values()) * ours["depth"].size <= 64, off

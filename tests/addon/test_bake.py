"""Baking by Blender's operator, beside Cycles' bakes of the same objects."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon import panels_bake
from iwis.iwis_addon.bake_kinds import KINDS, is_baked, parts_of
from iwis.iwis_addon.job import RenderJob
from support.cycles_render import use_cycles

SIZE = 32  # finer than the ball's faces: over coarse texels Cycles spreads points otherwise
ALONG = {"normal_space": "OBJECT"}


@pytest.fixture
def ball_scene(cube_scene):
    """The cube, a smooth ball beside it that is mirrored, stretched and turned, with a checkered
    material that shines, and an image for it to be baked to."""
    scene = cube_scene
    world = scene.world.node_tree.nodes["Background"].inputs
    world["Color"].default_value = (0.6, 0.8, 1.0, 1.0)
    ball_at = {"segments": 16, "ring_count": 8, "radius": 0.7}
    bpy.ops.mesh.primitive_uv_sphere_add(location=(1.4, 0.1, 0.6), **ball_at)
    bpy.ops.object.shade_smooth()
    ball = bpy.context.object
    ball.name, ball.scale, ball.rotation_euler = "Ball", (-1.0, 1.3, 0.8), (0.3, 0.2, 0.5)
    bpy.ops.object.light_add(type="AREA", location=(2.0, -2.0, 3.0))
    bpy.context.object.data.energy = 40.0
    _shade(ball)
    scene.render.bake.margin = 0
    scene.iwis.max_samples, scene.iwis.stop_rule = 256, "FIXED"
    return scene


def _shade(obj, name="Baked"):
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # before Blender 5
        material.use_nodes = True
    tree = material.node_tree
    surface = tree.nodes["Principled BSDF"]
    surface.inputs["Roughness"].default_value = 0.3
    surface.inputs["Metallic"].default_value = 0.4
    surface.inputs["Emission Color"].default_value = (0.3, 0.2, 0.1, 1.0)
    surface.inputs["Emission Strength"].default_value = 0.2
    checks = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(checks.outputs["Color"], surface.inputs["Base Color"])
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = bpy.data.images.new(name, SIZE, SIZE, float_buffer=True, alpha=True)
    tree.nodes.active = target
    obj.data.materials.append(material)
    return surface


def _bake(scene, kind, engine="IWIS", samples=512, chosen=("Ball",), **options):
    """float32 (SIZE, SIZE, 4): the ball's image, the last of ``chosen`` being active."""
    if engine == "CYCLES":
        use_cycles(scene, samples, filter_width=1.5)
    scene.render.engine = engine
    bpy.ops.object.select_all(action="DESELECT")
    for name in chosen:
        obj = scene.objects[name]
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
    bpy.ops.object.bake(type=kind, **options)
    image = bpy.data.images["Baked"]
    pixels = np.empty((SIZE, SIZE, 4), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    return pixels


@pytest.mark.parametrize(
    "kind, options, mean, each",
    [
        # Of both: 500 samples of a texel's square, over which normals change.
        # Colors jump: 16 points of an edge's texel and 512 differ by .1 of white and more.
        ("NORMAL", ALONG, 1e-3, 0.03),
        ("NORMAL", {"normal_space": "TANGENT"}, 1e-3, 0.03),
        ("ROUGHNESS", {}, 1e-3, 1e-3),
        ("EMIT", {}, 1e-3, 1e-3),
        ("ENVIRONMENT", {}, 1e-3, 1e-3),
        ("DIFFUSE", {"pass_filter": {"COLOR"}}, 0.01, 0.25),
        ("GLOSSY", {"pass_filter": {"COLOR"}}, 0.01, 0.25),
        # Their noise, too: 3 % a texel at its edges.
        ("AO", {}, 0.01, 0.12),
        ("SHADOW", {}, 0.01, 0.15),
        ("DIFFUSE", {"pass_filter": {"DIRECT"}}, 0.01, 0.2),
        ("GLOSSY", {"pass_filter": {"DIRECT", "COLOR"}}, 0.015, 0.6),
        ("COMBINED", {}, 0.01, 0.45),
    ],
)
def test_bakes_are_those_of_cycles(ball_scene, kind, options, mean, each):
    """In the mean and texel by texel: relative to the picture's mean."""
    found = _bake(ball_scene, kind, **options)
    there = found[..., 3] > 0.0  # beside the islands Cycles' shadow is white, ours black
    expected = _bake(ball_scene, kind, "CYCLES", **options)[there][:, :3]
    found, scale = found[there][:, :3], expected.mean()
    assert scale > 0.0
    assert abs(found.mean() - scale) < mean * scale
    assert np.quantile(np.abs(found - expected), 0.99) < each * scale


def test_positions_are_those_of_cycles(ball_scene):
    """Of the texels' centres; Cycles' own of more samples than one are wrong."""
    found, expected = (_bake(ball_scene, "POSITION", e, 1) for e in ("IWIS", "CYCLES"))
    np.testing.assert_allclose(found[..., :3], expected[..., :3], atol=1e-5)


def test_uv_is_the_place_on_the_map(ball_scene):
    """A texel's own place in its image, and 1: which is what a map is."""
    found = _bake(ball_scene, "UV")
    there = found[..., 2] == 1.0
    x, y = np.meshgrid(*((np.arange(SIZE) + 0.5) / SIZE,) * 2)
    # half a texel: points of its square, and more of it at the islands' borders
    np.testing.assert_allclose(found[there][:, :2], np.stack([x, y], -1)[there], atol=0.5 / SIZE)
    assert there.mean() > 0.8


def test_alpha_counts_as_in_cycles(ball_scene):
    """The surface alone, by its alpha: nothing behind it, nor the world."""
    inputs = bpy.data.materials["Baked"].node_tree.nodes["Principled BSDF"].inputs
    inputs["Alpha"].default_value = 0.6
    found, expected = (_bake(ball_scene, "COMBINED", engine) for engine in ("IWIS", "CYCLES"))
    # 32 points a texel, of which .6 show anything: .087 each
    np.testing.assert_allclose(found[..., 3], expected[..., 3], atol=0.3)
    np.testing.assert_allclose(found.mean((0, 1)), expected.mean((0, 1)), rtol=0.02)
    normals = _bake(ball_scene, "NORMAL", **ALONG)
    np.testing.assert_allclose(normals[normals[..., 3] > 0.5, 3], 1.0)


def test_gloss_from_the_camera(ball_scene):
    """view_from: what the camera sees there, not what is seen from above each point."""
    ball_scene.render.bake.view_from = "ACTIVE_CAMERA"
    options = {"pass_filter": {"COLOR"}}
    found, expected = (_bake(ball_scene, "GLOSSY", e, **options) for e in ("IWIS", "CYCLES"))
    ball_scene.render.bake.view_from = "ABOVE_SURFACE"
    above = _bake(ball_scene, "GLOSSY", **options)
    scale = expected[..., :3].mean()
    assert abs(found[..., :3].mean() - scale) < 0.01 * scale
    assert abs(above[..., :3].mean() - scale) > 0.03 * scale


def test_selected_to_active(ball_scene):
    """The ball's own normals, on the texels of a coarser one: those of Cycles."""
    bake = ball_scene.render.bake
    coarse_at = {"segments": 10, "ring_count": 6, "radius": 0.8}
    ball = ball_scene.objects["Ball"]
    ball.data.materials.clear()
    bpy.ops.mesh.primitive_uv_sphere_add(location=ball.location, **coarse_at)
    coarse = bpy.context.object
    coarse.name, coarse.scale = "Coarse", ball.scale
    coarse.data.materials.append(bpy.data.materials["Baked"])
    bake.use_selected_to_active, bake.cage_extrusion = True, 0.3
    own = {"chosen": ("Ball", "Coarse"), **ALONG}
    found, expected = (_bake(ball_scene, "NORMAL", e, **own) for e in ("IWIS", "CYCLES"))
    # coarse texels, whose points are on few faces: .003
    np.testing.assert_allclose(found[..., :3].mean(), expected[..., :3].mean(), rtol=6e-3)
    assert np.quantile(np.abs(found - expected)[..., :3], 0.98) < 0.05


def test_vertex_colors(ball_scene):
    """Points at the corners of faces, where rays may start in a neighbour: none is black."""
    ball_scene.render.bake.target = "VERTEX_COLORS"
    colors = ball_scene.objects["Ball"].data.color_attributes.new("C", "FLOAT_COLOR", "CORNER")
    pictures = []
    for engine in ("IWIS", "CYCLES"):
        _bake(ball_scene, "COMBINED", engine)
        values = np.empty((len(colors.data), 4), np.float32)
        colors.data.foreach_get("color", values.ravel())
        pictures.append(values[:, :3])
    np.testing.assert_allclose(pictures[0].mean(axis=0), pictures[1].mean(axis=0), rtol=0.01)
    assert np.abs(pictures[0] - pictures[1]).max() < 0.5 * pictures[1].mean()


def test_each_image_gets_its_own_faces(ball_scene):
    """Two materials with an image each: both are as Cycles bakes them."""
    ball = ball_scene.objects["Ball"]
    _shade(ball, "Second")
    flags = np.arange(len(ball.data.polygons)) % 2
    ball.data.polygons.foreach_set("material_index", flags)
    means = []
    for engine in ("IWIS", "CYCLES"):
        _bake(ball_scene, "NORMAL", engine, **ALONG)
        own = [np.array(bpy.data.images[name].pixels[:]) for name in ("Baked", "Second")]
        means.append([values.reshape(-1, 4)[:, :3].mean() for values in own])
    np.testing.assert_allclose(*means, rtol=4e-3)  # .002 of coarse texels' normals


def test_faces_without_area_are_black(ball_scene):
    """They are left out of the scene: all others keep their texels."""
    ball = ball_scene.objects["Ball"]
    for k in range(3):
        ball.data.vertices[k].co = ball.data.vertices[40].co
    found, expected = (_bake(ball_scene, "EMIT", engine) for engine in ("IWIS", "CYCLES"))
    same = np.abs(found - expected)[..., :3].max(axis=2) < 1e-3
    assert same.mean() > 0.9
    assert not found[~same][:, :3].any()


def test_without_camera_and_world(ball_scene):
    """A bake needs neither: it has the lamp's light."""
    ball_scene.camera, ball_scene.world = None, None
    found, expected = (_bake(ball_scene, "COMBINED", engine) for engine in ("IWIS", "CYCLES"))
    np.testing.assert_allclose(found[..., :3].mean(), expected[..., :3].mean(), rtol=0.02)


@pytest.mark.parametrize("persistent", [False, True])
def test_after_a_render(ball_scene, persistent):
    """Blender then keeps the picture's size, with Persistent Data the engine object as well."""
    ball_scene.render.use_persistent_data = persistent
    ball_scene.iwis.max_samples = 4
    before = _bake(ball_scene, "EMIT")
    bpy.ops.render.render()
    np.testing.assert_array_equal(_bake(ball_scene, "EMIT"), before)
    bpy.ops.render.render()
    assert RenderJob.current.records[-1].stats.width == ball_scene.render.resolution_x


def test_what_is_not_baked_is_told(ball_scene):
    """One line, with what to do; as an error, so that scripts and farms stop."""
    with pytest.raises(RuntimeError, match=r"does not bake Transmission: .* or this one with"):
        _bake(ball_scene, "TRANSMISSION")
    shown = {kind for kind, _, _ in KINDS}
    assert not is_baked("TRANSMISSION") and all(map(is_baked, shown))


def test_a_bake_that_fails_names_the_object(ball_scene, monkeypatch):
    """Here where the mesh that Blender has found texels of is not the one that is rendered."""
    from iwis.iwis_addon.export import bake

    monkeypatch.setattr(bake, "_instance_of", lambda _obj, _geometry: 0)  # the cube or its floor
    with pytest.raises(RuntimeError, match=r"Object Ball: it is baked as .* triangles"):
        _bake(ball_scene, "NORMAL")


def test_bits_are_blenders():
    """-1 has all parts; others as RE_BakePassFilter has them."""
    assert parts_of(-1) == {"EMIT", "DIFFUSE", "GLOSSY", "DIRECT", "COLOR"}
    assert parts_of(324) == {"DIFFUSE", "DIRECT", "COLOR"}
    each = {1 << k: parts_of(1 << k) for k in range(12) if parts_of(1 << k)}
    assert each == {2: {"EMIT"}, 4: {"DIFFUSE"}, 8: {"GLOSSY"}, 64: {"DIRECT"}, 256: {"COLOR"}}


def test_the_panel_shows_what_a_kind_asks_for(ball_scene):
    """Parts only where there are any."""
    shown = {}
    for kind, _, _ in KINDS:
        ball_scene.iwis.bake_type = kind
        ball_scene.render.engine = "IWIS"
        shown[kind] = panels_bake.IWIS_PT_bake_influence.poll(bpy.context)
    assert {kind for kind in shown if shown[kind]} == {"NORMAL", "COMBINED", "DIFFUSE", "GLOSSY"}

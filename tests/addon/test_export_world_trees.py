"""Trees of worlds: what a camera sees of them in Cycles, and which of them light."""

import bpy
import numpy as np
import pytest

from iwis.core.data.program import WorldProgram
from iwis.core.scene import EnvironmentMap
from iwis.core.surfaces.backdrop import Backdrop
from iwis.iwis_addon.export.worlds import world_picture
from support.world_render import (
    add,
    cycles_background,
    link,
    looked_up,
    mapped_world,
    new_image,
    new_world,
    noisy_world,
    pixel_directions,
    read,
    some_texels,
    textured_world,
)


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


@pytest.fixture(autouse=True)
def small_maps(monkeypatch):
    """Few rows: what is tested is where they come from."""
    monkeypatch.setattr(world_picture, "LEAST_HEIGHT", 64)


def show(tree, output, factor=1.0):
    """Make |output| the world's colour, as light cannot be negative."""
    absolute, background = add(tree, "VectorMath", operation="ABSOLUTE"), add(tree, "Background")
    background.inputs["Strength"].default_value = factor
    tree.links.new(output, absolute.inputs[0])
    link(tree, absolute, background, add(tree, "OutputWorld"))
    return background


def by_camera_ray(tree, first, second):
    """Mix two shaders by Is Camera Ray."""
    mix, path = add(tree, "MixShader"), add(tree, "LightPath")
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    for node, socket in ((first, 1), (second, 2)):
        tree.links.new(node.outputs[0], mix.inputs[socket])
    link(tree, mix, tree.nodes.get("World Output") or add(tree, "OutputWorld"))
    return mix


SEEN = {
    "TexCoord": ("Generated", "Normal", "Object", "Camera", "Window", "Reflection"),
    "NewGeometry": ("Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing"),
    "LightPath": ("Is Camera Ray", "Ray Depth", "Is Diffuse Ray", "Is Shadow Ray"),
    "CameraData": ("View Vector", "View Z Depth", "View Distance"),
    "ObjectInfo": ("Location", "Color", "Random"),
    "Attribute": ("Color", "Fac", "Alpha"),
    "AmbientOcclusion": ("Color", "AO"),
    "Fresnel": (0,),
    "LayerWeight": (0, 1),
    "Bump": (0,),
    "TexGradient": (0,),
    "TexNoise": (0, 1),
    "TexMagic": (0,),
}


@pytest.mark.parametrize(
    ("kind", "output"), [(kind, name) for kind, names in SEEN.items() for name in names]
)
def test_a_camera_sees_what_cycles_shows(scene, tree, tmp_path, kind, output):
    """All that a world can ask of a direction, in eight views, 0.2 %: float32 and Cycles' ray."""
    scene.camera.location = 0.3, -0.2, 0.1
    show(tree, add(tree, kind).outputs[output])
    world, warnings = read()
    told = [line for line in warnings if "it gives no light" not in line]
    assert bool(told) == (kind == "Bump" or output in ("Ray Depth", "Is Diffuse Ray"))
    depends = kind == "CameraData" or output in ("Camera", "Window")
    if depends:  # on where the camera looks: the last view, which is still there
        cycles = cycles_background(scene, tmp_path)
        world, _ = read()
    else:
        cycles = cycles_background(scene, tmp_path)
    seen = Backdrop(world.backdrop or world.light).radiance(pixel_directions())
    if depends:
        n = len(seen) // 8
        seen, cycles = seen[-n:], cycles[-n:]
    difference = np.abs(seen - cycles).max(axis=1) / max(cycles.max(), 1e-3)
    assert np.quantile(difference, 0.999) < 2e-3 and difference.mean() < 5e-4


OF_LAYERS = {
    "number": ("Fac", "Color", "Alpha"),
    "vector": ("Fac", "Color", "Vector", "Alpha"),
    "of the world": ("Color",),
    "frame_current": ("Fac",),
    "nothing": ("Fac", "Alpha"),
}


@pytest.mark.parametrize(
    ("name", "output"), [(name, output) for name in OF_LAYERS for output in OF_LAYERS[name]]
)
def test_properties_of_the_scene_as_in_cycles(scene, tree, tmp_path, name, output):
    """What an Attribute node reads of view layer, scene and world, as a color or as a strength."""
    scene["number"], scene["vector"] = 0.3, (0.2, 0.5, 0.9)
    scene.world["number"], scene.world["of the world"] = 0.6, (0.1, 0.3, 0.7)
    scene.frame_set(3)
    node = add(tree, "Attribute", attribute_type="VIEW_LAYER", attribute_name=name)
    show(tree, node.outputs[output])
    cycles = cycles_background(scene, tmp_path)
    world, warnings = read()
    assert not [line for line in warnings if "it gives no light" not in line]
    seen = Backdrop(world.backdrop or world.light).radiance(pixel_directions())
    np.testing.assert_allclose(seen, cycles, atol=1e-4)


@pytest.mark.parametrize("kind", ["POINT", "VECTOR", "NORMAL"])
@pytest.mark.parametrize("ways", [("WORLD", "CAMERA"), ("CAMERA", "WORLD"), ("OBJECT", "WORLD")])
def test_vector_transform_as_in_cycles(scene, tree, tmp_path, kind, ways):
    scene.camera.location = 0.3, -0.2, 0.1
    node = add(tree, "VectorTransform", vector_type=kind)
    node.convert_from, node.convert_to = ways
    tree.links.new(add(tree, "TexCoord").outputs["Generated"], node.inputs[0])
    show(tree, node.outputs[0])
    cycles = cycles_background(scene, tmp_path)
    world, warnings = read()
    assert not warnings
    seen = Backdrop(world.backdrop or world.light).radiance(pixel_directions())
    n = len(seen) // 8
    np.testing.assert_allclose(seen[-n:], cycles[-n:], atol=2e-3 * cycles.max())


def test_the_light_is_a_map_of_what_the_camera_sees(tree):
    """A smooth tree: the map, between its texels, and each ray agree to a part of a texel."""
    noisy_world(tree, Scale=1.0, Detail=0.0)
    world, warnings = read()
    assert not warnings and isinstance(world.backdrop, WorldProgram)
    assert world.light.radiance.shape == (64, 128, 3)
    seen = Backdrop(world.backdrop).radiance(pixel_directions())
    level = np.abs(pixel_directions()[:, 2]) < np.cos(np.radians(5.0))  # a pole: see environment
    np.testing.assert_allclose(looked_up(world.light)[level], seen[level], atol=0.02)


def test_images_in_one_place_keep_their_texels(tree, texels):
    """Two images, both turned alike, mixed by a number: no map of directions is made."""
    other = 2.0 * texels[::-1].copy()
    mapping = mapped_world(tree, new_image(texels), "POINT", Rotation=(0.3, 0.2, 0.1))
    second = add(tree, "TexEnvironment", image=new_image(other))
    link(tree, mapping, second)
    mix = add(tree, "MixRGB", Fac=0.25)
    tree.links.new(tree.nodes["Environment Texture"].outputs[0], mix.inputs["Color1"])
    tree.links.new(second.outputs[0], mix.inputs["Color2"])
    link(tree, mix, tree.nodes["Background"])
    world, warnings = read()
    assert not warnings and world.backdrop is None
    np.testing.assert_allclose(world.light.radiance, 0.75 * texels + 0.25 * other, rtol=1e-6)
    assert not np.allclose(world.light.world_to_map, np.eye(3, 4))


@pytest.mark.parametrize("gamma, bends", [(1.0, False), (2.2, True)])
@pytest.mark.parametrize("rows", [16, 64])
@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
def test_few_texels_that_nodes_bend_become_a_map(tree, rng, gamma, bends, rows, interpolation):
    """Cycles blends texels first: so does a map of at least as many rows, and a camera's rays."""
    image = new_image(rng.random((rows, 2 * rows, 3)).astype(np.float32))
    textured_world(tree, image)
    picture, bent = tree.nodes["Environment Texture"], add(tree, "Gamma")
    picture.interpolation, bent.inputs["Gamma"].default_value = interpolation, gamma
    link(tree, picture, bent)
    link(tree, bent, tree.nodes["Background"])
    world, warnings = read()
    assert not warnings
    is_map = bends and rows < 64 and interpolation == "Linear"
    assert (world.backdrop is not None) == is_map
    assert len(world.light.radiance) == (64 if is_map else rows)


def test_one_sun_that_nodes_bend_is_not_overlooked(tree):
    """One texel of 32 768 that most of the light comes from; without it nothing bends."""
    texels = np.full((128, 256, 3), 0.05, np.float32)
    image, bent = new_image(texels), add(tree, "Gamma")
    textured_world(tree, image)
    link(tree, tree.nodes["Environment Texture"], bent)
    link(tree, bent, tree.nodes["Background"])
    bent.inputs["Gamma"].default_value = 2.2
    assert read(least_height=256)[0].backdrop is None
    texels[90, 100] = 100.0
    image.pixels.foreach_set(np.dstack([texels, np.ones((128, 256))]).astype(np.float32).ravel())
    image.update()
    assert read(least_height=256)[0].backdrop is not None


def test_camera_rays_see_another_picture_than_the_light(tree, texels):
    """The light keeps the image's texels; a colour is what the camera sees; nothing is told."""
    _, background = textured_world(tree, new_image(texels))
    plain = add(tree, "Background", Color=(0.1, 0.2, 0.3, 1.0), Strength=2.0)
    by_camera_ray(tree, background, plain)
    world, warnings = read()
    assert not warnings
    np.testing.assert_array_equal(world.light.radiance, texels)
    np.testing.assert_allclose(looked_up(world.backdrop)[0], (0.2, 0.4, 0.6), rtol=1e-6)


def test_a_light_path_that_changes_nothing_makes_no_backdrop(tree, texels):
    _, background = textured_world(tree, new_image(texels))
    by_camera_ray(tree, background, background)
    mix = add(tree, "MixShader", Fac=0.0)
    tree.links.new(background.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes["Mix Shader"].outputs[0], mix.inputs[2])
    link(tree, mix, tree.nodes["World Output"])
    unused, _ = read()
    assert unused.backdrop is None and unused.light.radiance is not None
    np.testing.assert_array_equal(unused.light.radiance, texels)


def test_a_hidden_world_has_no_backdrop(scene, tree):
    noisy_world(tree)
    scene.world.cycles_visibility.camera = False
    world, _ = read()
    assert world.backdrop is None and not world.light.visible_to_camera


@pytest.mark.parametrize(("output", "light"), [("Is Diffuse Ray", 1.0), ("Is Glossy Ray", 0.0)])
def test_light_is_that_on_diffuse_surfaces(tree, output, light):
    show(tree, add(tree, "LightPath").outputs[output], 0.7)
    world, warnings = read()
    assert looked_up(world.light).max() == pytest.approx(0.7 * light)
    assert any(output in line and '"Light Path"' in line for line in warnings)


def test_view_layers_may_have_a_world_of_their_own(scene, tree, texels):
    textured_world(tree, new_image(texels))
    other = bpy.data.worlds.new("Other")
    if bpy.app.version < (5, 0):
        other.use_nodes = True
    other.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.7, 1.0)
    bpy.context.view_layer.world_override = other
    world, warnings = read()
    assert not warnings
    np.testing.assert_allclose(looked_up(world.light)[0], (0.3, 0.5, 0.7), rtol=1e-6)
    bpy.context.view_layer.world_override = None
    np.testing.assert_array_equal(read()[0].light.radiance, texels)


def test_lookups_by_what_is_no_matrix(scene, tree, texels, tmp_path):
    """An Environment Texture whose vector is bent by a node is evaluated ray by ray."""
    texture, _ = textured_world(tree, new_image(texels))
    bend = add(tree, "VectorMath", operation="SINE")
    tree.links.new(add(tree, "TexCoord").outputs["Generated"], bend.inputs[0])
    link(tree, bend, texture)
    world, warnings = read()
    assert not warnings and isinstance(world.light, EnvironmentMap)
    seen = Backdrop(world.backdrop).radiance(pixel_directions())
    cycles = cycles_background(scene, tmp_path)
    difference = np.abs(seen - cycles).max(axis=1)
    assert np.quantile(difference, 0.99) < 2e-3

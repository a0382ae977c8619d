"""The world as IWIS looks it up is the one that Cycles shows: nodes, warnings, bad input."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.images import sky
from iwis.iwis_addon.export.images.sky import SkyError
from iwis.iwis_addon.export.shaders.program_nodes import HANDLERS
from iwis.iwis_addon.world_bake import bake_world
from support.world_render import (
    RELATIVE,
    add,
    assert_as_cycles,
    cycles_background,
    exported,
    link,
    looked_up,
    new_image,
    new_world,
    save_image,
    some_texels,
    textured_world,
)


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


def test_strength_and_colour(scene, tree, texels, tmp_path):
    _, background = textured_world(tree, new_image(texels))
    background.inputs["Strength"].default_value = 2.7
    assert_as_cycles(scene, tmp_path)
    environment, _ = exported()
    np.testing.assert_array_equal(environment.radiance, texels)
    assert environment.strength == pytest.approx(2.7)
    tree.links.remove(background.inputs["Color"].links[0])
    background.inputs["Color"].default_value = (0.2, 0.5, 0.9, 1.0)
    assert_as_cycles(scene, tmp_path)


def test_groups_reroutes_and_muted_nodes(scene, tree, texels, tmp_path):
    """The texture in a group, rotation and strength handed in, links bent, a node muted."""
    inner = bpy.data.node_groups.new("Sky", "ShaderNodeTree")
    for name, kind, way in (
        ("Turn", "NodeSocketVector", "INPUT"),
        ("Power", "NodeSocketFloat", "INPUT"),
        ("Light", "NodeSocketShader", "OUTPUT"),
    ):
        inner.interface.new_socket(name, socket_type=kind, in_out=way)
    entry, leave = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    texture = add(inner, "TexEnvironment", image=new_image(texels))
    background = add(inner, "Background")
    inner.links.new(entry.outputs["Turn"], texture.inputs["Vector"])
    inner.links.new(entry.outputs["Power"], background.inputs["Strength"])
    link(inner, texture, background, leave)
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    group.inputs["Power"].default_value = 1.5
    mapping = add(tree, "Mapping", Rotation=(0.3, 0.2, 0.1))
    muted = add(tree, "Mapping", Rotation=(1.0, 1.0, 1.0))
    muted.mute = True
    bend = tree.nodes.new("NodeReroute")
    link(tree, add(tree, "TexCoord"), muted, mapping, bend, group, add(tree, "OutputWorld"))
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize(
    "kind, values",
    [
        ("Gamma", {"Gamma": 1.8}),
        ("BrightContrast", {"Contrast": 0.2}),
        ("HueSaturation", {"Hue": 0.6, "Saturation": 1.4, "Value": 0.9}),
        ("Invert", {}),
        ("RGBToBW", {}),
        ("MixRGB", {"blend_type": "MULTIPLY", "Color2": (0.3, 0.6, 0.9, 1.0)}),
        ("MixRGB", {"blend_type": "SCREEN", "Color2": (0.3, 0.6, 0.9, 1.0)}),
        ("Mix", {"data_type": "RGBA", "blend_type": "ADD"}),
        ("VectorMath", {"operation": "SCALE", "Scale": 1.7}),
        ("Math", {"operation": "MULTIPLY"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "-".join(map(str, value.values())),
)
def test_colour_nodes(scene, tree, texels, tmp_path, kind, values):
    """Between texture and background. Ours change texels, so: without interpolation."""
    texture, background = textured_world(tree, new_image(texels), interpolation="Closest")
    node = add(tree, kind, **values)
    kinds = ("VALUE",) if kind == "Math" else ("RGBA", "VECTOR")
    socket = next(s for s in node.inputs if s.enabled and s.type in kinds)
    tree.links.new(texture.outputs[0], socket)
    tree.links.new(next(s for s in node.outputs if s.enabled), background.inputs["Color"])
    environment, warnings = exported()
    assert not warnings
    ours, cycles = looked_up(environment), cycles_background(scene, tmp_path)
    # 1e-4: Cycles' powf, and its luminance from the OCIO configuration, 5 digits in one version, 7
    # in the other; a texel's border as in assert_as_cycles.
    assert np.mean(np.abs(ours - cycles).max(axis=1) > 1e-4) < 0.005


def test_emission_and_plain_colour_are_a_background(scene, tree, texels, tmp_path):
    texture, background = textured_world(tree, new_image(texels))
    emission, output = add(tree, "Emission", Strength=1.3), tree.nodes["World Output"]
    link(tree, texture, emission, output)
    assert_as_cycles(scene, tmp_path)
    link(tree, texture, output)
    assert_as_cycles(scene, tmp_path)
    link(tree, background, output)


def test_mixed_shaders(scene, tree, texels, tmp_path):
    """Image and colour, added and mixed by a constant."""
    _, background = textured_world(tree, new_image(texels))
    plain = add(tree, "Background", Color=(0.1, 0.2, 0.3, 1.0), Strength=2.0)
    mix, both = add(tree, "MixShader"), add(tree, "AddShader")
    mix.inputs[0].default_value = 0.3
    for index, node in ((1, background), (2, plain)):
        tree.links.new(node.outputs[0], mix.inputs[index])
        tree.links.new((mix if index == 1 else plain).outputs[0], both.inputs[index - 1])
    link(tree, both, tree.nodes["World Output"])
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize("kind", ["TexSky", "Wavelength"])
def test_unsupported_colour_is_never_black_without_a_word(tree, kind, monkeypatch):
    def fails(*_):
        raise SkyError("no process")

    monkeypatch.setattr(sky, "read_sky", fails)
    monkeypatch.delitem(HANDLERS, "ShaderNodeWavelength")
    node, background = add(tree, kind), add(tree, "Background")
    output = next(s for s in node.outputs if s.type == "RGBA")
    tree.links.new(output, background.inputs["Color"])
    link(tree, background, add(tree, "OutputWorld"))
    environment, warnings = exported()
    assert looked_up(environment).min() > 0.05
    assert len(warnings) == 1 and node.name in warnings[0] and '"World"' in warnings[0]
    assert kind != "TexSky" or "Convert World to HDRI" in warnings[0]


def test_a_sky_that_cannot_be_rendered_says_why(tree, monkeypatch):
    """Settings that Blender does not know: the child's own words, and nothing is kept."""
    monkeypatch.setattr(sky, "sky_settings", lambda node: {"sky_type": "GREEN"})
    with pytest.raises(SkyError, match="GREEN"):
        sky.read_sky(add(tree, "TexSky"), 8)


@pytest.mark.slow
def test_a_sky_lights_as_the_panorama_of_its_world(tree, scene, tmp_path, monkeypatch):
    """Its light along the axes with the sun's disc, beside Convert World's panorama of many
    samples; the second time it is read, not rendered."""
    monkeypatch.setenv("IWIS_CACHE_DIR", str(tmp_path))
    node, background = add(tree, "TexSky"), add(tree, "Background")
    node.sun_elevation, node.sun_rotation, node.sun_size = 1.2, 2.9, 0.03
    tree.links.new(node.outputs[0], background.inputs["Color"])
    link(tree, background, add(tree, "OutputWorld"))
    height = 64
    own = sky.read_sky(node, height)
    image = bake_world(scene, height, 2048)
    baked = np.empty(2 * height * height * 4, np.float32)
    image.pixels.foreach_get(baked)
    baked = baked.reshape(height, 2 * height, 4)[..., :3]
    up = (np.arange(height) + 0.5) / height * np.pi - 0.5 * np.pi
    round_ = np.pi - (np.arange(2 * height) + 0.5) / height * np.pi
    axes = np.cos(up)[:, None] * np.cos(round_), np.cos(up)[:, None] * np.sin(round_)
    for axis in (*axes, np.sin(up)[:, None] + 0.0 * round_, 1.0 + 0.0 * axes[0]):
        weight = np.cos(up)[:, None, None] * axis[..., None]
        light = [(picture * weight).sum((0, 1)) for picture in (own, baked)]
        np.testing.assert_allclose(*light, rtol=0.01, atol=0.003 * light[1].max())
    sky._LAST.clear()
    monkeypatch.setattr(sky, "render_sky", None)
    np.testing.assert_array_equal(sky.read_sky(node, height), own)


def test_a_shader_that_cannot_glow_is_black_with_a_warning(tree):
    link(tree, add(tree, "BsdfDiffuse"), add(tree, "OutputWorld"))
    environment, warnings = exported()
    assert looked_up(environment).max() == 0.0
    assert len(warnings) == 1 and "Diffuse BSDF gives no light" in warnings[0]


def test_bad_strength_is_black_with_a_warning(tree, texels):
    _, background = textured_world(tree, new_image(texels))
    background.inputs["Strength"].default_value = float("nan")
    environment, warnings = exported()
    assert looked_up(environment).max() == 0.0
    assert len(warnings) == 1 and "strength" in warnings[0]


def test_a_negative_strength_takes_light_away(scene, tree, texels, tmp_path):
    """As in Cycles, without a word."""
    _, background = textured_world(tree, new_image(texels))
    background.inputs["Strength"].default_value = -1.5
    environment, warnings = exported()
    assert looked_up(environment).max() < 0.0 and warnings == []
    assert_as_cycles(scene, tmp_path)


def test_no_world_is_black_with_a_warning(scene, tree):
    scene.world = None
    environment, warnings = exported()
    assert looked_up(environment).max() == 0.0
    assert len(warnings) == 1 and "no world" in warnings[0]


def test_nothing_linked_is_black_with_a_warning(tree):
    for _ in range(2):
        environment, warnings = exported()
        assert looked_up(environment).max() == 0.0
        assert len(warnings) == 1 and '"World"' in warnings[0]
        add(tree, "OutputWorld")


def test_world_hidden_from_the_camera(scene, tree, texels):
    textured_world(tree, new_image(texels))
    assert exported()[0].visible_to_camera
    scene.world.cycles_visibility.camera = False
    environment, warnings = exported()
    assert not environment.visible_to_camera and not warnings


def test_world_hidden_from_other_rays_is_a_warning(scene, tree, texels):
    textured_world(tree, new_image(texels))
    scene.world.cycles_visibility.diffuse = False
    _, warnings = exported()
    assert len(warnings) == 1 and "diffuse" in warnings[0] and '"World"' in warnings[0]


if bpy.app.version < (5, 0):  # later, worlds always use nodes

    def test_world_without_nodes(scene, tree, tmp_path):
        scene.world.use_nodes = False
        scene.world.color = (0.2, 0.4, 0.6)
        assert_as_cycles(scene, tmp_path)

else:  # before, the working space could not be chosen

    @pytest.mark.parametrize("space", ["sRGB", "Linear Rec.709", "Linear Rec.2020"])
    def test_working_space_of_the_file(scene, tree, texels, tmp_path, space):
        """Rendered are the file's own linear numbers; Cycles' half floats as for colour spaces."""
        numbers = 0.6 * texels + 0.4 * texels.mean(axis=2, keepdims=True)
        image = save_image(numbers, tmp_path / "map.png", "PNG")
        image.colorspace_settings.name = space
        bpy.ops.wm.set_working_color_space(working_space="Linear Rec.2020", convert_colors=False)
        textured_world(tree, image)
        assert_as_cycles(scene, tmp_path, RELATIVE, 3.4 * 2**-11)


if bpy.app.version >= (5, 2):

    def test_shadows_that_are_off_are_told(scene, tree, texels):
        """Since Blender 5.2: Cycles then leaves out those of its light samples alone."""
        textured_world(tree, new_image(texels))
        scene.world.cycles.use_shadows = False
        _, warnings = exported()
        assert sum("Shadows are off" in line for line in warnings) == 1

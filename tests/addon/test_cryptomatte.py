"""Cryptomatte, Mist and UV beside Cycles', in files and in Blender's compositor."""

import json

import bpy
import numpy as np
import OpenEXR
import pytest

from iwis.core.data.asked_passes import matte_ids
from iwis.core.exr import read_exr_layers
from iwis.iwis_addon.job import RenderJob
from iwis.iwis_addon.passes import MATTES
from iwis.operators.save_film import film_layers
from support.compositor import IS_5, empty_tree
from support.cycles_render import use_cycles
from support.iwis_render import by_pass, render_iwis


@pytest.fixture
def matte_scene(cube_scene):
    """The cube on its floor, a ball that hangs from the cube, three copies of a cone, a hole, a
    catcher; no world in the picture."""
    scene = cube_scene
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4, location=(0.4, 1.1, 0.4))
    ball = bpy.context.object
    ball.name, ball.parent = "Ball ü", bpy.data.objects["Cube"]
    ball.data.materials.append(bpy.data.materials.new("Grün"))
    for name, x in (("Hole", 0.6), ("Catcher", 1.4)):
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(x, -1.0, 0.25))
        bpy.context.object.name = name
    bpy.data.objects["Hole"].is_holdout = True
    bpy.data.objects["Catcher"].is_shadow_catcher = True
    _add_cones(scene)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.render.film_transparent = True
    world = scene.world.mist_settings
    world.start, world.depth, world.falloff = 4.0, 6.0, "INVERSE_QUADRATIC"
    layer = scene.view_layers[0]
    for flag in (*MATTES.values(), "use_pass_mist", "use_pass_uv"):
        setattr(layer, flag, True)
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 256
    return scene


def _add_cones(scene):
    cones = bpy.data.collections.new("Cones")
    bpy.ops.mesh.primitive_cone_add(radius1=0.3, depth=0.8)
    cone = bpy.context.object
    cone.name = "Cone"
    scene.collection.objects.unlink(cone)
    cones.objects.link(cone)
    for k in range(3):
        copies = bpy.data.objects.new(f"Copies {k}", None)
        copies.instance_type, copies.instance_collection = "COLLECTION", cones
        copies.location = (-1.4, k - 1.5, 0.4)
        scene.collection.objects.link(copies)


def manifests(path):
    """Kind -> {name: hash}, and all that the header says of Cryptomatte but for them."""
    header = {}
    with OpenEXR.File(str(path), separate_channels=True) as file:
        for part in file.parts:
            header |= {key: part.header[key] for key in part.header if key.startswith("crypto")}
    names = {key[:-5]: value for key, value in header.items() if key.endswith("/name")}
    found = {name: json.loads(header.pop(f"{key}/manifest")) for key, name in names.items()}
    return found, header


def coverage(layers, kind, name):
    """What a matte covers of each pixel. layers: of a file, with the view layer's name or not"""
    identity, total = matte_ids([name])[0], 0.0
    for level in range(3):
        pairs = layers[f"Crypto{kind}{level:02d}"]
        for k in (0, 2):
            total = total + np.where(pairs[..., k] == identity, pairs[..., k + 1], 0.0)
    return total


@pytest.mark.slow
def test_all_is_that_of_cycles(matte_scene, tmp_path):
    """Ids, names and header are Cycles' to the letter; coverage, mist and places agree.

    32 rays a pixel and Cycles' 256: where edges cross a pixel the standard error of either's
    coverage is below .04 and .03, and edges are a quarter of this picture.
    """
    ours = by_pass(render_iwis(matte_scene, tmp_path))
    told, header = manifests(tmp_path / "iwis.exr")
    use_cycles(matte_scene, samples=256, filter_width=1.5)
    matte_scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(tmp_path / "cycles.exr"))
    cycles_told, cycles_header = manifests(tmp_path / "cycles.exr")
    assert header == cycles_header
    for kind in MATTES:
        own = told[f"ViewLayer.Crypto{kind}"]
        assert own.items() <= cycles_told[f"ViewLayer.Crypto{kind}"].items()
        for name in own:
            a, b = coverage(ours, kind, name), coverage(theirs, kind, name)
            assert abs(a.mean() - b.mean()) < 0.002
            assert np.sqrt(((a - b) ** 2).mean()) < 0.02
            assert (b.max() > 0.0) == (name != "Hole")
    assert "Ball ü" in told["ViewLayer.CryptoObject"]
    assert "Ball ü" not in told["ViewLayer.CryptoAsset"]  # the cube's
    for name in ("Mist", "UV"):
        assert np.sqrt(((ours[name] - theirs[name]) ** 2).mean()) < 0.02


@pytest.mark.parametrize("levels", [2, 6])
def test_sockets_are_those_of_cycles(cube_scene, levels):
    """As many passes as half the levels; none where no kind is asked for."""
    layer = cube_scene.view_layers[0]
    tree = empty_tree(cube_scene)
    node = tree.nodes.new("CompositorNodeRLayers")
    layer.pass_cryptomatte_depth = levels
    found = {}
    for engine in ("CYCLES", "IWIS"):
        cube_scene.render.engine = engine
        for on in (False, True):
            layer.use_pass_cryptomatte_material = on
            layer.update_render_passes()
            names = {output.name for output in node.outputs if output.enabled}
            found[engine, on] = {name for name in names if name.startswith("Crypto")}
    assert found["IWIS", False] == set()
    assert len(found["IWIS", True]) == levels // 2
    assert found["IWIS", True] == found["CYCLES", True]


@pytest.mark.slow
def test_blenders_node_finds_the_mattes(matte_scene, tmp_path):
    """The Cryptomatte node picks the cube and its ball by name: its matte is their coverage."""
    matte_scene.iwis.max_samples = 16
    tree = empty_tree(matte_scene)
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.scene, node.layer_name = "RENDER", matte_scene, "ViewLayer.CryptoObject"
    node.matte_id = "Cube,Ball ü"
    image = tree.nodes.new("CompositorNodeRLayers")
    image.scene = matte_scene
    tree.links.new(image.outputs["Image"], node.inputs["Image"])
    _connect_output(tree, node.outputs["Matte"])
    matte_scene.render.use_compositing = True
    layers = render_iwis(matte_scene, tmp_path)
    shown = layers.pop("Composite.Combined")[..., 0]
    found = by_pass(layers)
    wanted = sum(coverage(found, "Object", name) for name in ("Cube", "Ball ü"))
    assert wanted.max() == 1.0 and 0.05 < wanted.mean() < 0.9
    np.testing.assert_allclose(shown, wanted, atol=1e-3)


def _connect_output(tree, socket):
    if IS_5:
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        tree.links.new(socket, tree.nodes.new("NodeGroupOutput").inputs[0])
    else:
        tree.links.new(socket, tree.nodes.new("CompositorNodeComposite").inputs["Image"])


def test_a_kept_film_has_its_mattes(cube_scene, tmp_path):
    """Save Film writes them under Blender's names, and scripts find them in their layers."""
    layer = cube_scene.view_layers[0]
    layer.use_pass_cryptomatte_object, layer.pass_cryptomatte_depth = True, 4
    cube_scene.iwis.keep_film = True
    render_iwis(cube_scene, tmp_path)
    films = RenderJob.current.films
    layers, letters = film_layers(films)
    names = [name for name in layers if "Crypto" in name]
    assert names == ["ViewLayer.CryptoObject00", "ViewLayer.CryptoObject01"]
    assert all(letters[name] == "rgba" and layers[name].shape[2] == 4 for name in names)
    (film,) = films.values()
    assert film.layers["crypto_object"].shape[2] == 8

"""Movies as textures: the frame that a node asks for, whatever Blender has looked at before."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.images.texel_cache import TexelCache
from iwis.iwis_addon.export.shaders.program_images import ImageStore
from support.above import look_from_above
from support.movies import write_movie

RED = (40, 80, 120, 160, 200)  # of each frame


@pytest.fixture
def movie(scene, tmp_path):
    """Five frames, of one color each."""
    frames = np.zeros((5, 8, 16, 3), np.uint8)
    frames[..., 0] = np.reshape(RED, (5, 1, 1))
    write_movie(tmp_path / "movie.avi", frames)
    image = bpy.data.images.load(str(tmp_path / "movie.avi"))
    assert image.source == "MOVIE"
    return image


def textured(tree, kind, image, **user):
    """A node of a tree that shows a movie."""
    node = tree.nodes.new(kind)
    node.image = image
    for name, value in ({"frame_duration": 5, "frame_start": 1} | user).items():
        setattr(node.image_user, name, value)
    return node


def red_of(material):
    """Of the first texel that a material's node shows now."""
    graph = bpy.context.evaluated_depsgraph_get()
    node = material.evaluated_get(graph).node_tree.nodes["Image Texture"]
    cache = TexelCache()
    cache.frame = graph.scene.frame_current
    return int(ImageStore(cache).tiles(node.image, node.image_user).tiles[0, 0][0, 0, 0])


@pytest.fixture
def material(scene, movie):
    material = bpy.data.materials.new("M")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    node = textured(material.node_tree, "ShaderNodeTexImage", movie)
    target = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    material.node_tree.links.new(node.outputs["Color"], target)
    look_from_above(scene)
    bpy.ops.mesh.primitive_plane_add(size=2.0)
    bpy.context.object.data.materials.append(material)
    return material


@pytest.mark.parametrize("refreshed", [True, False])
def test_frames_follow_the_scene(scene, material, refreshed):
    """Forward and back; before the first and after the last one these stay, as in Cycles."""
    user = material.node_tree.nodes["Image Texture"].image_user
    user.use_auto_refresh = refreshed
    for frame, expected in ((1, 0), (4, 3), (2, 1), (9, 4), (-3, 0)):
        scene.frame_set(frame)
        assert red_of(material) == pytest.approx(RED[expected], abs=1), frame


@pytest.mark.parametrize(
    ("settings", "expected"),
    [({"frame_start": 3}, 1), ({"frame_offset": 1}, 4), ({"use_cyclic": True}, 3)],
)
def test_nodes_say_which_frame(scene, material, settings, expected):
    """At frame 4."""
    for name, value in settings.items():
        setattr(material.node_tree.nodes["Image Texture"].image_user, name, value)
    scene.frame_set(4)
    assert red_of(material) == pytest.approx(RED[expected], abs=1)


def test_two_nodes_may_show_two_frames(scene, movie, material):
    """Of one movie; nothing is told, and nothing is left behind."""
    textures = len(bpy.data.textures)
    scene.world = bpy.data.worlds.new("W")
    if bpy.app.version < (5, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    node = textured(tree, "ShaderNodeTexEnvironment", movie, frame_offset=2)
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    scene.frame_set(2)
    lines = []
    found = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    assert lines == [] and len(bpy.data.textures) == textures
    encoded = 255.0 * (1.055 * found.environment.radiance[0, 0, 0] ** (1 / 2.4) - 0.055)
    assert encoded == pytest.approx(RED[3], abs=1.0)
    assert red_of(material) == pytest.approx(RED[1], abs=1)

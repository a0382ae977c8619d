"""culling.py, texture_size.py: what Simplify leaves out, and how small it makes images.

tests/parity has pictures beside Cycles'.
"""

import bpy
import numpy as np
import pytest

from iwis.core.data.program import ImageTiles
from iwis.iwis_addon.export import ExportCache, export_scene
from iwis.iwis_addon.export.images.image import Texels
from iwis.iwis_addon.export.images.texel_cache import TexelCache
from iwis.iwis_addon.export.images.texture_size import (
    WHOLE,
    TextureSize,
    smaller_texels,
    smaller_tiles,
    texture_size,
)
from support.above import look_from_above
from support.live_window import Window


@pytest.fixture
def far_cubes(scene):
    """Three cubes, of which a camera above sees the middle one; all of them may be culled."""
    look_from_above(scene)
    for x in (0.0, 4.0, 9.0):
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(x, 0.0, 0.0))
        bpy.context.object.cycles.use_camera_cull = True
        bpy.context.object.cycles.use_distance_cull = True
    scene.render.use_simplify = True
    scene.cycles.camera_cull_margin, scene.cycles.distance_cull_margin = 0.1, 8.0
    return scene


def places(scene):
    mesh = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[]).mesh
    middle = mesh.vertices[mesh.triangles].mean(1)[:, 0]
    return sorted({x for x in (0.0, 4.0, 9.0) if (np.abs(middle - x) < 0.6).any()})


CHOICES = {
    "nothing is chosen": ({}, [0.0, 4.0, 9.0]),
    "camera": ({"use_camera_cull": True}, [0.0]),
    "camera, wide": ({"use_camera_cull": True, "camera_cull_margin": 0.5}, [0.0, 4.0]),
    "distance": ({"use_distance_cull": True}, [0.0, 4.0]),
    "distance 0": ({"use_distance_cull": True, "distance_cull_margin": 0.0}, [0.0, 4.0, 9.0]),
    "both": ({"use_camera_cull": True, "use_distance_cull": True}, [0.0, 4.0]),
}


@pytest.mark.parametrize("name", CHOICES)
def test_what_is_culled_is_not_there(far_cubes, name):
    """Of what may be by both, what is by both; a distance of 0 is none, as in Cycles."""
    settings, expected = CHOICES[name]
    for key, value in settings.items():
        setattr(far_cubes.cycles, key, value)
    assert places(far_cubes) == expected
    far_cubes.render.use_simplify = False
    assert places(far_cubes) == [0.0, 4.0, 9.0]


def test_objects_say_whether_they_may_be_culled(far_cubes):
    """Each by itself; and a stereo picture culls nothing."""
    far_cubes.cycles.use_camera_cull = True
    bpy.data.objects["Cube.001"].cycles.use_camera_cull = False
    assert places(far_cubes) == [0.0, 4.0]
    far_cubes.render.use_multiview = True
    assert places(far_cubes) == [0.0, 4.0, 9.0]


def test_a_camera_that_moves_brings_others_into_the_picture(far_cubes):
    """From frame to frame, beside geometry that is kept."""
    far_cubes.cycles.use_camera_cull, cache = True, ExportCache()

    def count():
        graph = bpy.context.evaluated_depsgraph_get()
        return len(export_scene(graph, warnings=[], cache=cache).mesh.triangles)

    assert count() == 12
    far_cubes.camera.location.x = 2.0
    assert count() == 24


BLOCKS = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)


@pytest.mark.parametrize(
    ("limit", "resolution", "step"),
    [(0, 1.0, 1), (128, 1.0, 4), (256, 1.0, 2), (512, 1.0, 1), (0, 0.6, 2), (128, 0.5, 4)],
)
def test_sides_are_halved_until_they_fit(limit, resolution, step):
    """Of 300 x 200 pixels, the longer one decides."""
    assert TextureSize(limit, resolution).step_of(200, 300) == step


def test_new_texels_are_means():
    """Of bytes rounded to bytes, half a one up; what is left of a block is left out."""
    tiles = ImageTiles({(0, 0): BLOCKS}, True)
    assert smaller_tiles(tiles, WHOLE) is tiles
    found = smaller_tiles(tiles, TextureSize(2)).tiles[0, 0]
    np.testing.assert_array_equal(found, [[[8, 9, 10, 11]]])
    floats = ImageTiles({(0, 0): BLOCKS.astype(np.float32)}, False)
    found = smaller_tiles(floats, TextureSize(2)).tiles[0, 0]
    np.testing.assert_array_equal(found, [[[8, 9, 10, 11]]])
    thin = ImageTiles({(0, 0): BLOCKS[:1]}, True)
    assert smaller_tiles(thin, TextureSize(1)).tiles[0, 0].shape == (1, 1, 4)


def test_a_worlds_texels_are_means_of_what_is_interpolated():
    """Encoded ones, of sRGB: of black and white .5 of them, rounded up to a byte."""
    rgb = np.float32([[[0.0] * 3, [1.0] * 3]])
    plain = smaller_texels(Texels(rgb, False), TextureSize(1), False).rgb
    np.testing.assert_allclose(plain, np.full((1, 1, 3), 0.5))
    encoded = smaller_texels(Texels(rgb, True), TextureSize(1), True).rgb
    np.testing.assert_allclose(encoded, ((128 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-5)


def test_the_scene_says_how_small(cube_scene):
    """While Simplify is on; a render and a window each have a limit of their own."""
    graph = bpy.context.evaluated_depsgraph_get()  # of a window
    cube_scene.cycles.texture_limit, cube_scene.cycles.texture_limit_render = "128", "256"
    assert texture_size(graph) == WHOLE
    cube_scene.render.use_simplify = True
    assert texture_size(graph).limit == 128
    cube_scene.cycles.texture_limit = "OFF"
    assert texture_size(graph) == WHOLE


def test_images_are_read_again_for_another_limit(scene):
    """Of the same job."""
    image, cache = bpy.data.images.new("I", 256, 256), TexelCache()
    assert cache.read(image, None).rgb.shape == (256, 256, 3)
    cache.size = TextureSize(128)
    assert cache.read(image, None).rgb.shape == (128, 128, 3)


def test_a_window_follows_the_limit(cube_scene, monkeypatch):
    """Its world is made anew, though no material and no image has changed."""
    image = bpy.data.images.new("I", 256, 128)
    tree = cube_scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    window = Window(monkeypatch)
    bpy.context.view_layer.update()
    cube_scene.render.use_simplify = True
    assert window.export(cube_scene.update_tag)[0].environment.radiance.shape[1] == 256
    cube_scene.cycles.texture_limit = "128"
    assert window.export(cube_scene.update_tag)[0].environment.radiance.shape[1] == 128

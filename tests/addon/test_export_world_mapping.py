"""Projections, coordinates and mappings look up the same texel as Cycles."""

import bpy
import numpy as np
import pytest
from mathutils import Euler

from iwis.iwis_addon.export.images.color_spaces import srgb_decode, srgb_encode
from iwis.iwis_addon.export.images.smooth_texels import finer, smooth_texels
from support.world_render import (
    RELATIVE,
    add,
    assert_as_cycles,
    cycles_background,
    exported,
    link,
    looked_up,
    mapped_world,
    new_image,
    new_world,
    some_texels,
    textured_world,
)


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.parametrize("projection", ["EQUIRECTANGULAR", "MIRROR_BALL"])
def test_projection_and_interpolation(scene, tree, texels, tmp_path, projection, interpolation):
    """Texel centres, seam, poles and the ball's rim are Cycles'."""
    textured_world(tree, new_image(texels), projection=projection, interpolation=interpolation)
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize("interpolation", ["Cubic", "Smart"])
def test_smoother_interpolation_is_a_finer_image(tree, texels, interpolation):
    """Of which nothing is told."""
    textured_world(tree, new_image(texels), interpolation=interpolation)
    environment, warnings = exported()
    height, width = texels.shape[:2]
    assert environment.radiance.shape[:2] == (8 * height, 8 * width) and warnings == []


@pytest.mark.parametrize("encoded", [False, True])
def test_a_finer_image_is_the_spline(rng, encoded):
    """At the middles of finer texels, by the definition: the sum of bells over all texels, which
    repeat. Wide images are not made wider."""

    def bell(x):
        x = np.abs(x)
        inner, outer = 2 / 3 - x * x * (2 - x) / 2, np.maximum(2 - x, 0.0) ** 3 / 6
        return np.where(x < 1.0, inner, outer)

    rgb = rng.random((3, 5, 3)).astype(np.float32)
    found = smooth_texels(rgb, encoded)
    own = srgb_encode(rgb) if encoded else rgb
    for row, column in ((0, 0), (11, 20), (23, 39), (4, 35)):
        y, x = (row + 0.5) / 8 - 0.5, (column + 0.5) / 8 - 0.5
        i, j = np.arange(-6, 9), np.arange(-10, 15)
        weights = bell(y - i)[:, None] * bell(x - j)
        expected = np.einsum("ij,ijc->c", weights, own[i % 3][:, j % 5])
        expected = srgb_decode(expected) if encoded else expected
        np.testing.assert_allclose(found[row, column], expected, rtol=1e-4)
    assert [finer(width) for width in (100, 512, 1024, 2048, 4096, 9000)] == [8, 8, 4, 2, 1, 1]


@pytest.mark.parametrize("vector_type", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
@pytest.mark.parametrize(
    "rotation", [(0.7, 0, 0), (0, -1.1, 0), (0, 0, 2.3), (0.7, -1.1, 2.3)], ids=str
)
def test_mapping_rotation(scene, tree, texels, tmp_path, vector_type, rotation):
    mapped_world(tree, new_image(texels), vector_type, Rotation=rotation)
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize("projection", ["EQUIRECTANGULAR", "MIRROR_BALL"])
@pytest.mark.parametrize("vector_type", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_mapping_location_rotation_scale(scene, tree, texels, tmp_path, vector_type, projection):
    mapped_world(
        tree,
        new_image(texels),
        vector_type,
        projection,
        Rotation=(0.4, 1.0, -0.6),
        Scale=(1.2, -0.8, 1.5),
        **({"Location": (0.2, -0.1, 0.3)} if vector_type in ("POINT", "TEXTURE") else {}),
    )
    # The scale stretches the map by up to 2: so does the distance that the pixel filter spans.
    assert_as_cycles(scene, tmp_path, relative=2 * RELATIVE)


def test_mapping_scale_zero_and_vector_unlinked_give_one_colour(scene, tree, texels, tmp_path):
    """A zero vector is looked up at (0, 0); an unlinked Mapping maps its constant."""
    mapping = mapped_world(tree, new_image(texels), "POINT", Scale=(0, 0, 0))
    assert_as_cycles(scene, tmp_path)
    tree.links.remove(mapping.inputs["Vector"].links[0])
    mapping.inputs["Location"].default_value = (0.3, 0.2, 0.1)
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize(
    "types", [("POINT", "TEXTURE"), ("NORMAL", "VECTOR"), ("TEXTURE", "POINT")]
)
def test_two_mappings(scene, tree, texels, tmp_path, types):
    first = mapped_world(tree, new_image(texels), types[0], Rotation=(0.5, 0.1, 1.0))
    texture = first.outputs[0].links[0].to_node
    second = add(tree, "Mapping", vector_type=types[1], Rotation=(0.2, -0.4, 0.3))
    link(tree, first, second, texture)
    assert_as_cycles(scene, tmp_path)


def test_mapping_inputs_from_constant_nodes(scene, tree, texels, tmp_path):
    mapping = mapped_world(tree, new_image(texels), "POINT")
    vector = add(tree, "CombineXYZ", X=0.3, Y=0.2)
    angle = add(tree, "Math", operation="MULTIPLY")
    angle.inputs[0].default_value, angle.inputs[1].default_value = 2.0, 0.6
    tree.links.new(angle.outputs[0], vector.inputs["Z"])
    tree.links.new(vector.outputs[0], mapping.inputs["Rotation"])
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize(
    "node, output",
    [
        ("TexCoord", "Generated"),
        ("TexCoord", "Normal"),
        ("TexCoord", "Object"),
        ("TexCoord", "Camera"),
        ("TexCoord", "Reflection"),
        ("NewGeometry", "Position"),
        ("NewGeometry", "Normal"),
        ("NewGeometry", "True Normal"),
        ("NewGeometry", "Incoming"),
    ],
)
def test_coordinates(scene, tree, texels, tmp_path, node, output):
    texture, _ = textured_world(tree, new_image(texels))
    tree.links.new(add(tree, node).outputs[output], texture.inputs["Vector"])
    if output != "Camera":
        return assert_as_cycles(scene, tmp_path)
    # Turns with the camera: what one camera sees, the others see too.
    parts = cycles_background(scene, tmp_path).reshape(8, -1, 3)
    np.testing.assert_allclose(parts[0], parts[5], rtol=RELATIVE)
    scene.camera.rotation_euler = (0.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    ours = looked_up(exported()[0]).reshape(8, -1, 3)[0]
    difference = np.abs(ours / parts[0] - 1.0)
    assert np.quantile(difference, 0.99) < RELATIVE  # the rest: the map's pole is in this picture


def test_coordinate_of_an_object(scene, tree, texels, tmp_path):
    """Its inverse matrix, with location and scale: the direction is taken for a point."""
    texture, _ = textured_world(tree, new_image(texels))
    empty = bpy.data.objects.new("Empty", None)
    scene.collection.objects.link(empty)
    empty.location, empty.rotation_euler = (0.1, -0.2, 0.3), (0.4, 1.0, 2.0)
    empty.scale = (1.0, 1.3, 0.8)
    coordinate = add(tree, "TexCoord", object=empty)
    tree.links.new(coordinate.outputs["Object"], texture.inputs["Vector"])
    bpy.context.view_layer.update()
    assert_as_cycles(scene, tmp_path, relative=2 * RELATIVE)  # stretched, as above


def test_mapping_of_the_texture_node_itself(scene, tree, texels, tmp_path):
    texture, _ = textured_world(tree, new_image(texels))
    mapping = texture.texture_mapping
    mapping.vector_type, mapping.rotation = "TEXTURE", (0.3, 0.5, -0.9)
    mapping.mapping_x, mapping.mapping_y = "Y", "X"
    assert_as_cycles(scene, tmp_path)


def test_rotation_by_a_driver_is_evaluated(scene, tree, texels, tmp_path):
    """The depsgraph's values count, not the stored ones."""
    mapping = mapped_world(tree, new_image(texels), "POINT")
    driver = mapping.inputs["Rotation"].driver_add("default_value", 2).driver
    driver.expression = "frame / 10"
    scene.frame_set(13)
    environment, _ = exported()
    turn = np.array(Euler((0, 0, 1.3)).to_matrix())
    np.testing.assert_allclose(environment.world_to_map[:, :3], turn, atol=1e-6)

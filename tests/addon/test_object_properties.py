"""What the Attribute node reads of data-blocks (iwis_addon/export/object_properties.py)."""

import bpy
import pytest

from iwis.iwis_addon.export.object_properties import Asked, blocks_of, rgba_of

NOTHING = (0.0, 0.0, 0.0, 0.0)


@pytest.fixture
def cube(scene):
    bpy.ops.mesh.primitive_cube_add(location=(1.0, 2.0, 3.0))
    cube = bpy.context.object
    cube["number"], cube["flag"], cube["whole"], cube["text"] = 0.25, True, [1, 2], "red"
    cube["color"], cube["five"] = (0.1, 0.2, 0.3, 0.5), (1.0,) * 5
    cube.data["number"], cube.data["of the mesh"] = 0.75, 0.5
    return cube


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("number", (0.25, 0.25, 0.25, 1.0)),  # the object's, before its mesh's
        ("of the mesh", (0.5, 0.5, 0.5, 1.0)),
        ("flag", (1.0, 1.0, 1.0, 1.0)),
        ("whole", (1.0, 2.0, 0.0, 1.0)),
        ("color", (0.1, 0.2, 0.3, 0.5)),
        ("location", (1.0, 2.0, 3.0, 1.0)),
        ("location[0]", NOTHING),
        ("text", NOTHING),
        ("five", NOTHING),
        ("name", NOTHING),
        ("data", NOTHING),
        ("nothing", NOTHING),
        ("", NOTHING),
    ],
)
def test_number_or_vector_is_a_color(cube, name, expected):
    asked = Asked(cube, None)
    assert rgba_of(blocks_of("object", asked, ()), name) == pytest.approx(expected)


def test_instancer_comes_first_and_layers_are_asked_in_order(cube):
    empty = bpy.data.objects.new("E", None)
    empty["number"] = 0.125
    assert rgba_of(blocks_of("instancer", Asked(cube, empty), ()), "number")[0] == 0.125
    assert rgba_of(blocks_of("instancer", Asked(cube, None), ()), "number")[0] == 0.25
    assert rgba_of(blocks_of("object", Asked(empty, None), ()), "of the mesh") == NOTHING
    scene = bpy.context.scene
    layer = scene.view_layers[0], scene, None
    scene["number"] = 2.0
    assert rgba_of(blocks_of("layer", Asked(cube, None), layer), "number")[0] == 2.0
    layer[0]["number"] = 3.0
    assert rgba_of(blocks_of("layer", Asked(cube, None), layer), "number")[0] == 3.0

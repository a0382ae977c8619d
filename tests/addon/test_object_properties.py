"""What the Attribute node reads of data-blocks (iwis_addon/export/objects/object_properties.py)."""

import bpy
import pytest

from iwis.iwis_addon.export.objects.object_properties import Asked, blocks_of, rgba_of
from iwis.iwis_addon.export.placed.instances import collect_instances

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


def test_an_instance_has_the_color_of_what_made_it(cube):
    """Of several, as Blender's iterator tells it for the first one alone; nested: the outermost."""
    scene, boxes, inner = bpy.context.scene, *map(bpy.data.collections.new, ("Boxes", "Inner"))
    cube.color = (0.1, 0.9, 0.2, 1.0)
    boxes.objects.link(cube)
    colors = [(0.5, 0.25, 0.125 * k, 1.0) for k in range(5)]
    for k, color in enumerate(colors):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection, empty.color = "COLLECTION", boxes, color
        (scene.collection if k else inner).objects.link(empty)
    nested = bpy.data.objects.new("Nested", None)
    nested.instance_type, nested.instance_collection = "COLLECTION", inner
    nested.color = (0.0, 0.0, 1.0, 1.0)
    scene.collection.objects.link(nested)
    looks = collect_instances(bpy.context.evaluated_depsgraph_get(), []).looks
    expected = [tuple(cube.color), *colors[1:], (0.0, 0.0, 1.0, 1.0)]
    found = sorted(look.color for look in looks)
    assert found == [pytest.approx(color) for color in sorted(expected)]

"""IES files: what of them is read, and what is told of those that cannot be."""

import bpy
import numpy as np
import pytest

from iwis.core.nodes.ies import FUNCTIONS, IES
from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.images.ies import IesError, parse_ies
from support.above import look_from_above

WATTS = 0.0706650768394  # Cycles' own W/sr for a candela


def table(horizontal, vertical, rows, kind=1, tilt="NONE", factors=(1, 1, 1)):
    """The text of a file."""
    head = f"1 1000 {factors[0]} {len(vertical)} {len(horizontal)} {kind} 2 0 0 0"
    lines = ["IESNA:LM-63-2002", "[TEST] 1 2 3", f"TILT={tilt}", head]
    lines += [f"{factors[1]} {factors[2]} 100"]
    for numbers in (vertical, horizontal, *rows):
        lines.append(" ".join(map(str, numbers)))
    return "\n".join(lines) + "\n"


def test_values_are_watts():
    """Times the file's three factors."""
    read = parse_ies(table([0], [0, 90], [[100, 50]], factors=(2, 0.5, 3)))
    np.testing.assert_allclose(read["values"], np.float32([[300, 150]] * 2) * WATTS, rtol=1e-6)
    np.testing.assert_array_equal(read["horizontal"], [0, 360])
    assert all(one.dtype == np.float32 for one in read.values())


@pytest.mark.parametrize(
    ("horizontal", "rows", "expected"),
    [
        ((0, 45, 90), (1, 2, 3), {45: 2, 135: 2, 180: 1, 225: 2, 270: 3, 360: 1}),
        ((0, 90, 180), (1, 2, 3), {90: 2, 180: 3, 270: 2, 360: 1}),
        ((90, 180, 270), (1, 2, 3), {0: 1, 90: 2, 180: 3, 270: 2, 360: 1}),
        ((0, 120, 240), (1, 2, 3), {120: 2, 240: 3, 360: 1}),
        ((0, 180, 360), (1, 2, 1), {0: 1, 180: 2, 360: 1}),
    ],
)
def test_what_is_symmetrical_is_written_once(horizontal, rows, expected):
    """A quarter, a half, one that begins at 90, one without its last angle, a whole."""
    read = parse_ies(table(horizontal, [0, 90], [[row, row] for row in rows]))
    found = dict(zip(read["horizontal"].tolist(), read["values"][:, 0] / WATTS, strict=True))
    for angle, value in expected.items():
        assert found[angle] == pytest.approx(value)


def test_an_included_tilt_is_passed_over():
    """Its geometry, the number of pairs, the angles, the factors."""
    text = table([0], [0, 90], [[100, 50]], tilt="INCLUDE\n1\n3\n0 45 90\n1 .9 .8")
    np.testing.assert_allclose(parse_ies(text)["values"][0] / WATTS, (100, 50), rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "TILT"),
        ("no file of lamps", "TILT"),
        (table([0], [0, 90], [[100]]), "ends before"),
        (table([0], [0, 90], [[100, "x"]]), '"x" is no number'),
        (table([0], [0, 90], [[100, "nan"]]), "no numbers"),
        (table([0, 10], [90, 0], [[1, 2], [1, 2]]), "do not rise"),
        (table([30, 90], [0, 90], [[1, 2], [1, 2]]), "begin at 30"),
        (table([0], [0, 90], [[1, 2]], kind=2), "type C"),
        (table([], [0, 90], []), "0 x 2 angles"),
        ("TILT=NONE\n1 1 1 1e9 1e9 1 2 0 0 0\n1 1 1\n", "angles"),
    ],
)
def test_bad_files_are_told(text, told):
    """Of any kind: one message."""
    with pytest.raises(IesError, match=told):
        parse_ies(text)


def shines(settings, degrees, around=0.0):
    """Fac along directions that far from the axis."""
    v, h = np.radians(degrees), np.radians(around)
    way = np.stack(np.broadcast_arrays(-np.sin(v) * np.sin(h), -np.sin(v) * np.cos(h), -np.cos(v)))
    inputs = {"Vector": way.T.astype(np.float32), "Strength": np.float32(1.0)}
    return FUNCTIONS[IES](None, settings, inputs)["Fac"]


def test_angles_of_the_table_have_its_values():
    """And nothing is beyond the last one."""
    values = [10, 30, 20, 5]
    settings = parse_ies(table([0], [0, 30, 60, 80], [values]))
    found = shines(settings, np.array([0.0, 30.0, 60.0, 79.999, 81.0, 170.0])) / WATTS
    np.testing.assert_allclose(found, (*values, 0.0, 0.0), atol=2e-3)


def test_between_angles_values_are_those_of_cycles():
    """As measured in Blender 5.2, of tables that rise evenly with one of the angles."""
    vertical = np.arange(0, 91, 10)
    by_height = parse_ies(table([0], vertical, [vertical]))
    found = shines(by_height, np.array([7.4, 43.8, 51.6, 60.9])) / WATTS
    np.testing.assert_allclose(found, (6.9, 43.8, 51.6, 60.9), atol=0.1)
    horizontal = np.arange(0, 361, 30)
    by_side = parse_ies(table(horizontal, [0, 90], [[h, h] for h in horizontal]))
    found = shines(by_side, np.full(4, 45.0), np.array([20.5, 69.8, 159.7, 347.8])) / WATTS
    np.testing.assert_allclose(found, (19.5, 69.8, 159.7, 352.1), atol=0.2)


def test_beside_the_table_values_are_those_of_cycles():
    """As measured: half a step from either end of vertical angles that begin at 30, and of
    horizontal ones, of a cubic through what is beyond: the value at the end, or in 4.5 none."""
    low, high = 10.0, 20.0
    rises = parse_ies(table([0], [30, 50, 70], [[low, high, low]]))
    rows = [[value] * 4 for value in (low, high, high, low)]
    turns = parse_ies(table([0, 120, 240, 360], [0, 60, 120, 180], rows))
    for dark, beyond in ((False, low), (True, 0.0)):
        expected = (9.0 * (low + high) - beyond - low) / 16.0  # Catmull-Rom, in the middle
        found = shines(rises | {"dark_ends": dark}, np.array([40.0, 60.0])) / WATTS
        np.testing.assert_allclose(found, expected, rtol=1e-4)
        expected = (9.0 * (low + high) - (0.0 if dark else low) - high) / 16.0
        found = shines(turns | {"dark_ends": dark}, np.array([90.0]), np.array([60.0])) / WATTS
        np.testing.assert_allclose(found, expected, rtol=1e-4)


def _lit_by(scene, mode="INTERNAL", **fields):
    look_from_above(scene)
    light = bpy.data.lights.new("Lamp data", "POINT")
    obj = bpy.data.objects.new("Lamp", light)
    scene.collection.objects.link(obj)
    if bpy.app.version < (5, 0):
        light.use_nodes = True
    tree = light.node_tree
    node = tree.nodes.new("ShaderNodeTexIES")
    node.mode = mode
    for name, value in fields.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[0], tree.nodes["Emission"].inputs["Strength"])
    lines = []
    lamps = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines).lamps
    return lamps, [line for line in lines if "Lamp" in line]


def test_a_file_is_read(scene, tmp_path):
    """By direction, as bright as its table says; in 4.5 a cubic through two equal values
    is up to 1/8 above them where both values beside them are 0, and 2/27 where one is."""
    path = tmp_path / "lamp.ies"
    path.write_text(table([0], [0, 180], [[100, 100]]), encoding="latin-1")
    lamps, lines = _lit_by(scene, "EXTERNAL", filepath=str(path))
    assert not lines and lamps.picture[0, 3] == 1
    whole = lamps.texels * lamps.radiance[0]
    strength = bpy.data.lights[0].energy / (4.0 * np.pi**2) * np.pi
    relative = whole / (100 * WATTS * strength)
    highest = 1.0 if bpy.app.version >= (5, 0) else 1.125 * (1.0 + 2.0 / 27.0)
    np.testing.assert_allclose((relative.min(), relative.max()), (1.0, highest), rtol=1e-3)


def test_a_file_that_is_missing_is_told(scene):
    """The lamp shines as without it."""
    lamps, lines = _lit_by(scene, "EXTERNAL", filepath="//gone.ies")
    assert len(lamps.kind) == 1 and len(lines) == 1
    assert "IES file" in lines[0] and "gone.ies" in lines[0] and "No such file" in lines[0]


def test_no_text_is_told(scene):
    """Of a node that was left empty."""
    _, lines = _lit_by(scene)
    assert len(lines) == 1 and "no text is chosen" in lines[0]

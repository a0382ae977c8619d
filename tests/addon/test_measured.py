"""Materials with a measured BRDF in place of their nodes: kept, exported, rendered, refused."""

import types

import bpy
import numpy as np
import pytest

from iwis.core.scene import DIFFUSE, MEASURED
from iwis.iwis_addon import measured
from iwis.iwis_addon.export import ExportError, export_scene
from support import bad_scenes
from support.iwis_render import render_iwis
from support.merl import SIDES, lambert_table, write_merl


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A MERL file of a matte material."""
    return write_merl(tmp_path_factory.mktemp("merl") / "matte.binary", lambert_table())


def new_material(name):
    """A material with Blender's own nodes."""
    return bad_scenes.new_material(name)[0]


def _give(material, path, tint=(1.0, 1.0, 1.0)):
    material.iwis.use_measured = True
    material.iwis.measured_path = str(path)
    material.iwis.measured_tint = tint
    return material


def _cube(scene):
    return next(o for o in scene.objects if o.type == "MESH" and o.name.startswith("Cube"))


def _export(warnings=None):
    return export_scene(
        bpy.context.evaluated_depsgraph_get(), warnings=[] if warnings is None else warnings
    )


def test_kept_in_the_file(cube_scene, table, tmp_path):
    """File, tint and switch outlive saving; a relative path is found from the .blend."""
    material = _give(new_material("Rubber"), table, (0.5, 0.25, 1.0))
    _cube(cube_scene).data.materials.append(material)
    path = tmp_path / "a.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    material.iwis.measured_path = bpy.path.relpath(str(table))
    assert material.iwis.measured_path.startswith("//")
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    kept = bpy.data.materials["Rubber"]
    assert kept.iwis.use_measured
    assert list(kept.iwis.measured_tint) == [0.5, 0.25, 1.0]
    assert len(_export().measured.values) == 1


def test_rows_stand_in_place_of_nodes(cube_scene, table):
    """One row of tables for a file, whoever names it; nodes are not read, so nothing is warned."""
    first, second, plain = (new_material(name) for name in ("First", "Second", "Plain"))
    nodes = first.node_tree.nodes
    portal = nodes.new("ShaderNodeBsdfRayPortal")
    output = first.node_tree.get_output_node("CYCLES")
    first.node_tree.links.new(portal.outputs[0], output.inputs["Surface"])
    first.pass_index = 7
    cube = _cube(cube_scene)
    for material in (_give(first, table, (0.5, 1.0, 1.0)), _give(second, table), plain):
        cube.data.materials.append(material)
    warnings = []
    scene = _export(warnings)
    assert warnings == []
    rows = np.flatnonzero(scene.materials.model == MEASURED)
    assert scene.materials.distribution[rows].tolist() == [0, 0]
    assert scene.materials.base_color[rows].tolist() == [[0.5, 1.0, 1.0], [1.0, 1.0, 1.0]]
    assert scene.material_pass_index[rows].tolist() == [7.0, 0.0]
    assert len(scene.measured.values) == 1
    first.iwis.use_measured = False
    assert len(_export(warnings).measured.values) == 1
    assert warnings  # of the portal


def test_nodes_come_back_when_it_is_off(cube_scene, table):
    """The switch alone decides; without any, a scene has no tables."""
    material = _give(new_material("M"), table)
    _cube(cube_scene).data.materials.append(material)
    material.iwis.use_measured = False
    scene = _export()
    assert not (scene.materials.model == MEASURED).any()
    assert len(scene.measured.values) == 0


@pytest.mark.slow
def test_matte_table_renders_as_diffuse(cube_scene, table, tmp_path):
    """The engine's picture of a constant table and of a Diffuse BSDF of its colour: equal in mean.

    2 %: both are noisy at 64 samples; half the tint gives half the light, within the same.
    """
    cube_scene.iwis.max_samples = 64
    cube_scene.iwis.stop_rule = "FIXED"
    cube_scene.iwis.pixel_filter = "CENTER"  # no pixel shows the white world in part
    cube = _cube(cube_scene)
    material = new_material("M")
    cube.data.materials.append(material)
    bsdf = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    bsdf.inputs["Color"].default_value = (0.8, 0.5, 0.2, 1.0)
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(bsdf.outputs[0], output.inputs["Surface"])
    cube_scene.view_layers[0].use_pass_material_index = True
    material.pass_index = 1

    def mean():
        layers = render_iwis(cube_scene, tmp_path)
        index = next(v for k, v in layers.items() if "Material Index" in k or "IndexMA" in k)
        picture = next(v for k, v in layers.items() if k.endswith("Combined"))
        return picture[..., :3][index[..., 0] == 1.0].mean(axis=0)

    nodes = mean()
    assert _export().materials.model[0] == DIFFUSE
    _give(material, table)
    np.testing.assert_allclose(mean(), nodes, rtol=0.02)
    material.iwis.measured_tint = (0.5, 0.5, 0.5)
    np.testing.assert_allclose(mean(), 0.5 * nodes, rtol=0.02)


def _cut(path, table):
    path.write_bytes(table.read_bytes()[:1000])


def _wrong_size(path, _table):
    path.write_bytes(np.array((45, 90, 180), "<i4").tobytes() + bytes(100))


def _negative(path, _table):
    with path.open("wb") as file:
        file.write(np.array(SIDES, "<i4").tobytes())
        file.write(np.full(3 * 90 * 90 * 180, -1.0).tobytes())


def _infinite(path, table):
    data = bytearray(table.read_bytes())
    data[12:20] = np.array([np.inf]).tobytes()
    path.write_bytes(data)


BAD = {
    _cut: "is cut off: 1000 bytes of 34992012",
    _wrong_size: "its header says 45 x 90 x 180",
    _negative: "has no defined value: all are negative",
    _infinite: "infinite",
    (lambda path, _table: path.write_bytes(b"")): "is no MERL table: 0 bytes",
    (lambda path, _table: path.mkdir()): "cannot be read",
    (lambda path, _table: None): "there is no such file",
}


@pytest.mark.parametrize(("damage", "text"), BAD.items(), ids=list(BAD.values()))
def test_bad_files_are_refused(cube_scene, table, tmp_path, damage, text):
    """One message with the material, its object, the file, and what to do; the preview says it."""
    path = tmp_path / "bad.binary"
    damage(path, table)
    _cube(cube_scene).data.materials.append(_give(new_material("Rubber"), path))
    message = rf"material 'Rubber' of object 'Cube': .*bad\.binary: .*{text}.*; choose another"
    with pytest.raises(ExportError, match=message):
        _export()
    assert text in measured.READER.read(str(path))


def test_no_file_chosen_stops_the_render(cube_scene, tmp_path):
    """Blender's operator fails with the message."""
    _cube(cube_scene).data.materials.append(_give(new_material("Rubber"), ""))
    with pytest.raises(RuntimeError, match="'Rubber' of object 'Cube' has no file: choose"):
        render_iwis(cube_scene, tmp_path)
    assert not list(tmp_path.iterdir())


def test_file_is_read_again_when_it_changes(cube_scene, table, tmp_path):
    """Not before: every frame of an animation would read 35 MB."""
    path = tmp_path / "a.binary"
    path.write_bytes(table.read_bytes())
    _cube(cube_scene).data.materials.append(_give(new_material("M"), path))
    first = _export().measured
    assert _export().measured.values is first.values
    write_merl(path, 0.5 * lambert_table())
    second = _export().measured
    assert second.keys != first.keys
    np.testing.assert_allclose(second.values.max(), 0.5 * first.values.max(), rtol=1e-5)


class _Layout:
    def __init__(self):
        self.said = []

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties
        self.said.append(name)

    def label(self, text="", **_options):
        self.said.append(text)

    def template_icon(self, icon_value, **_options):
        self.said.append(type(icon_value).__name__)

    def row(self):
        return self

    column = row


def _drawn(material):
    panel = types.SimpleNamespace(layout=_Layout())
    context = types.SimpleNamespace(material=material, engine="IWIS")
    assert measured.IWIS_PT_measured.poll(context)
    measured.IWIS_PT_measured.draw_header(panel, context)
    measured.IWIS_PT_measured.draw(panel, context)
    return panel.layout.said


def test_panel(scene, table, tmp_path):
    """What it offers, and the preview: what is wrong, or the albedo of the file times the tint."""
    material = new_material("M")
    assert "Choose a MERL table (.binary)" in _drawn(material)
    _give(material, table, (1.0, 0.5, 1.0))
    measured.READER.read(str(table))
    said = _drawn(material)
    assert said[:3] == ["use_measured", "measured_path", "measured_tint"]
    assert "int" in said
    assert any(line.startswith("From 0\N{DEGREE SIGN}: 0.8") for line in said)
    _give(material, tmp_path / "none.binary")
    measured.READER.read(str(tmp_path / "none.binary"))
    assert "there is no such file" in " ".join(_drawn(material))
    assert not measured.IWIS_PT_measured.poll(
        types.SimpleNamespace(material=material, engine="CYCLES")
    )


def test_preview_is_the_directional_albedo(table):
    """A matte table reflects .8, .5, .2 at all angles: sRGB of it, times the tint, in all columns.

    2 % of the light: the fit's quadrature and the horizon.
    """
    albedo = measured.READER.read(str(table))
    np.testing.assert_allclose(albedo[5:], np.broadcast_to([0.8, 0.5, 0.2], (20, 3)), rtol=0.02)
    pixels = measured.preview_pixels(albedo, (1.0, 1.0, 0.5))
    assert pixels.shape == (64, 64, 4)
    linear = ((pixels[:, 0, :3] + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(linear, np.broadcast_to([0.8, 0.5, 0.1], (64, 3)), rtol=0.02)

"""Depth of field and panoramas leave Blender as Cycles reads them. (Pictures: tests/parity.)"""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from iwis.core.scene import PANORAMAS
from iwis.iwis_addon.export.cameras.camera import export_camera
from support.iwis_render import render_iwis


@pytest.fixture
def view(cube_scene):
    """A camera three metres from a cube, with its lens open."""
    camera = cube_scene.camera
    camera.matrix_world = Matrix.Translation((0.0, 0.0, 4.0))
    dof = camera.data.dof
    dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 2.0, 3.5
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.25, 1.5
    camera.data.lens = 40.0
    return cube_scene


def _exported(warnings=None):
    bpy.context.view_layer.update()
    warnings = [] if warnings is None else warnings
    return export_camera(bpy.context.evaluated_depsgraph_get(), warnings)


def test_a_lens_is_as_wide_as_its_focal_length_over_the_f_stop(view):
    """Radius in metres: half of 40 mm / 2; all else as it is set."""
    lens = _exported().lens
    assert lens == pytest.approx((0.01, 3.5, 5, 0.25, 1.5), rel=1e-6)  # float32 properties


def test_an_orthographic_lens_is_a_metre_over_the_f_stop(view):
    """Cycles': the sensor plays no part."""
    view.camera.data.type = "ORTHO"
    assert _exported().lens.radius == pytest.approx(0.25)


def test_a_closed_lens_is_none(view):
    """Without use_dof all is sharp."""
    view.camera.data.dof.use_dof = False
    assert _exported().lens is None


def test_focus_is_along_the_axis_to_an_object_or_its_bone(view):
    """However far aside the object is; behind the camera counts as before it."""
    target = bpy.data.objects.new("Focus", bpy.data.armatures.new("Rig"))
    view.collection.objects.link(target)
    target.location = (2.0, -1.0, 1.5)
    view.camera.data.dof.focus_object = target
    assert _exported().lens.focus == pytest.approx(2.5)
    bpy.context.view_layer.objects.active = target
    bpy.ops.object.mode_set(mode="EDIT")
    bone = target.data.edit_bones.new("Tip")
    bone.head, bone.tail = (0.0, 0.0, 1.0), (0.0, 0.0, 2.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    view.camera.data.dof.focus_subtarget = "Tip"
    assert _exported().lens.focus == pytest.approx(1.5)
    target.location = (0.0, 0.0, 6.0)
    assert _exported().lens.focus == pytest.approx(3.0)


@pytest.mark.parametrize("kind", PANORAMAS)
def test_every_panorama_of_blender_is_exported(view, kind):
    """With its own numbers; the lens is that of the camera."""
    data = view.camera.data
    data.type = "PANO"
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = kind
    warnings = []
    camera = _exported(warnings)
    assert warnings == []
    assert (camera.kind, camera.panorama.kind) == ("PANORAMIC", kind)
    assert camera.window == (0.0, 1.0, 0.0, 1.0)
    assert camera.lens.radius == pytest.approx(0.01)
    known = dict(zip(PANORAMAS[kind], camera.panorama.parameters, strict=True))
    expected = {
        "fov": math.pi,
        "lens": 10.5,
        "longitude_min": -math.pi,
        "latitude_max": math.pi / 2,
    }
    for name in known.keys() & expected.keys():
        assert known[name] == pytest.approx(expected[name], rel=1e-6)


def test_blender_has_no_panorama_that_is_unknown(view):
    """A new Blender with another kind fails here first."""
    data = view.camera.data
    owner = data if hasattr(data, "panorama_type") else data.cycles
    kinds = {item.identifier for item in owner.bl_rna.properties["panorama_type"].enum_items}
    assert kinds == set(PANORAMAS)


def test_a_panorama_sees_all_around(view, tmp_path):
    """The camera is in the cube: a render shows all six walls, at their distance."""
    bpy.ops.mesh.primitive_cube_add(size=2.0, location=(20.0, 0.0, 0.0))
    view.camera.matrix_world = Matrix.Translation((20.0, 0.0, 0.0))
    data = view.camera.data
    data.type, data.dof.use_dof = "PANO", False
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    view.iwis.pixel_filter, view.iwis.max_samples = "CENTER", 4
    view.render.resolution_x, view.render.resolution_y = 32, 16
    view.view_layers[0].use_pass_z = True
    layers = render_iwis(view, tmp_path)
    depth = next(v for k, v in layers.items() if k.endswith("Depth"))[..., 0]
    # the nearest walls are a metre away, the corners sqrt(3)
    assert (depth >= 0.999).all() and (depth <= math.sqrt(3.0) + 1e-3).all()
    assert np.ptp(depth) > 0.5


def test_one_point_a_pixel_says_that_it_shows_no_blur(view, tmp_path):
    """Center: a sharp picture, and one line that names the setting."""
    from iwis.iwis_addon.job import RenderJob

    view.iwis.pixel_filter, view.iwis.max_samples = "CENTER", 4
    view.render.resolution_x, view.render.resolution_y = 16, 16
    render_iwis(view, tmp_path)
    lines = RenderJob.get().records[-1].stats.warnings
    assert sum("Pixel Filter Center" in line for line in lines) == 1
    view.iwis.pixel_filter = "BOX"
    render_iwis(view, tmp_path)
    lines = RenderJob.get().records[-1].stats.warnings
    assert not any("Pixel Filter" in line for line in lines)

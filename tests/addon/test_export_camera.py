"""Rays through the exported window meet the scene in the points where Cycles' rays meet it."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from iwis.iwis_addon.export import ExportError
from iwis.iwis_addon.export.cameras.camera import border_region, export_camera
from support.trace_scene import assert_seen_as_in_cycles, export_as_render

FITS = ("AUTO", "HORIZONTAL", "VERTICAL")
SIZES = ((64, 36), (36, 64), (48, 48))


@pytest.fixture
def view(scene):
    """A monkey above a plane, seen obliquely by a camera that fills the frame."""
    bpy.ops.mesh.primitive_monkey_add(location=(0.1, -0.2, 0.6))
    bpy.context.object.pass_index = 4
    bpy.ops.mesh.primitive_plane_add(size=7.0)
    bpy.context.object.pass_index = 9
    bpy.ops.object.camera_add(location=(2.5, -5.0, 2.5))
    camera = bpy.context.object
    camera.rotation_euler = (
        (Vector((0, 0, 0.5)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    )
    camera.data.ortho_scale = 5.0
    scene.camera = camera
    return scene


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_camera_window_is_that_of_cycles(view, tmp_path, kind, fit, size):
    """Sensor fit, both lens shifts and pixel aspect, in wide, tall and square frames."""
    data = view.camera.data
    data.type, data.sensor_fit = kind, fit
    data.sensor_width, data.sensor_height, data.lens = 32.0, 20.0, 38.0
    data.shift_x, data.shift_y = 0.13, -0.07
    view.render.resolution_x, view.render.resolution_y = size
    view.render.pixel_aspect_x, view.render.pixel_aspect_y = 1.0, 1.4
    exported = assert_seen_as_in_cycles(view, tmp_path)
    assert exported.camera.kind == {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}[kind]


@pytest.mark.parametrize("fit", FITS)
def test_camera_fov_in_degrees_is_that_of_cycles(view, tmp_path, fit):
    """The lens may be set by its angle, and pixels may be wider than tall."""
    data = view.camera.data
    data.lens_unit, data.sensor_fit, data.angle = "FOV", fit, math.radians(62.0)
    view.render.pixel_aspect_x = 1.7
    assert_seen_as_in_cycles(view, tmp_path)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_camera_clips_at_depths_as_cycles(view, tmp_path, kind):
    """Both distances are measured along the axis; the near one cuts into the monkey's head."""
    data = view.camera.data
    data.type, data.clip_start, data.clip_end = kind, 5.1, 7.3
    exported = assert_seen_as_in_cycles(view, tmp_path)
    assert (exported.camera.clip_start, exported.camera.clip_end) == pytest.approx((5.1, 7.3))


def test_camera_percentage_is_truncated(view, tmp_path):
    """A third of 65 x 49 pixels is 21 x 16."""
    view.render.resolution_x, view.render.resolution_y = 65, 49
    view.render.resolution_percentage = 33
    exported = assert_seen_as_in_cycles(view, tmp_path)
    assert (exported.camera.width, exported.camera.height) == (21, 16)


@pytest.mark.parametrize("crop", [False, True])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_camera_border_is_that_of_cycles(view, tmp_path, crop, kind):
    """Cropped or not, a border moves no pixel: Cycles' layers and the region have the same size."""
    view.camera.data.type = kind
    render = view.render
    render.use_border, render.use_crop_to_border = True, crop
    render.resolution_x, render.resolution_y = 61, 43
    render.border_min_x, render.border_max_x = 0.23, 0.79
    render.border_min_y, render.border_max_y = 0.11, 0.64
    exported = assert_seen_as_in_cycles(view, tmp_path)
    assert exported.camera.region == (14, 4, 48, 27)
    assert (exported.camera.width, exported.camera.height) == (61, 43)


def test_camera_region_replaces_the_border(view):
    """Whoever exports may ask for other pixels than the border's."""
    view.render.use_border = True
    view.render.border_max_x = 0.5
    assert export_as_render(view, region=(3, 4, 5, 6)).camera.region == (3, 4, 5, 6)


def test_camera_border_without_a_pixel_keeps_one(view):
    """A border thinner than a pixel still renders the pixel that it begins in."""
    render = view.render
    render.use_border = True
    render.border_min_x = render.border_max_x = 1.0
    render.border_min_y, render.border_max_y = 0.5, 0.501
    assert border_region(render) == (31, 12, 32, 13)


PARENTS = {
    "scaled camera": (Matrix.Identity(4), (3.0, 0.4, 2.0)),
    "scaled parent": (Matrix.Diagonal((2.0, 2.0, 2.0, 1.0)), (1.0, 1.0, 1.0)),
    "turned parent": (Euler((0.2, 0.1, -0.3)).to_matrix().to_4x4(), (1.0, 1.0, 1.0)),
    "mirrored camera": (Matrix.Identity(4), (-1.0, 1.0, 1.0)),
    "skewing parent": (Matrix.Diagonal((1.0, 1.3, 0.8, 1.0)), (1.0, 1.0, 1.0)),
}


@pytest.mark.parametrize("name", PARENTS)
def test_camera_matrix_has_no_scale(view, tmp_path, name):
    """Blender ignores the scale of a camera and of its parents, but not mirroring nor skew."""
    matrix, scale = PARENTS[name]
    parent = bpy.data.objects.new("Parent", None)
    view.collection.objects.link(parent)
    parent.matrix_world = matrix
    view.camera.parent = parent
    view.camera.scale = scale
    exported = assert_seen_as_in_cycles(view, tmp_path)
    lengths = np.linalg.norm(exported.camera.camera_to_world[:3, :3], axis=0)
    np.testing.assert_allclose(lengths, 1.0, rtol=1e-12)  # float64


def test_camera_without_size_is_an_error(view):
    """A scale of 0 leaves no direction to look along."""
    view.camera.scale = (0.0, 1.0, 1.0)
    with pytest.raises(ExportError, match=r"Camera Camera .*scale"):
        export_as_render(view)


def test_camera_missing_is_an_error(view):
    """Blender itself stops such a render, but a script may export: the scene is named."""
    view.camera = None
    with pytest.raises(ExportError, match=f"Scene {view.name} has no camera: add one"):
        export_camera(bpy.context.evaluated_depsgraph_get(), [])


def test_camera_may_be_any_object(view, tmp_path):
    """Blender looks along an empty, too, as through a 50 mm lens."""
    bpy.context.view_layer.update()
    empty = bpy.data.objects.new("Post", None)
    view.collection.objects.link(empty)
    empty.matrix_world = view.camera.matrix_world
    view.camera = empty
    # Cycles of 5.2.3 dies of such a camera: there the window and the place must do.
    exported = (
        assert_seen_as_in_cycles(view, tmp_path)
        if bpy.app.version < (5, 0)
        else export_as_render(view)
    )
    assert exported.warnings == ["Object Post is no camera: seen as through a 50 mm lens"]
    assert exported.camera.window[1] == pytest.approx(0.36)
    assert exported.camera.camera_to_world[1, 3] == pytest.approx(-5.0)


def test_camera_tells_what_it_leaves_out(view):
    """A camera of its own kind: one line that names the owner."""
    view.camera.data.type = "CUSTOM"
    exported = export_as_render(view)
    assert exported.camera.kind == "PERSPECTIVE"
    assert exported.warnings == [
        "Camera Camera: type CUSTOM is not supported, rendered as perspective",
    ]


def test_camera_of_a_frame_is_the_animated_one(view):
    """Camera objects and lenses are read from the evaluated scene."""
    data = view.camera.data
    for frame, lens in ((1, 30.0), (2, 60.0)):
        data.lens = lens
        data.keyframe_insert("lens", frame=frame)
    widths = []
    for frame in (1, 2):
        view.frame_set(frame)
        left, right, _, _ = export_as_render(view).camera.window
        widths.append(right - left)
    assert widths[0] == pytest.approx(2.0 * widths[1], rel=1e-6)  # float32 lens

"""The camera's motion blur: times, shutter, and that Blender stands at its frame afterwards."""

import functools
import math

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.motion.motion import export_in_motion, shutter_times
from iwis.iwis_addon.job import RenderJob
from iwis.iwis_addon.session import FinalRender
from support.frames import engine_of
from support.iwis_render import render_iwis


def _linear(owner):
    action = owner.animation_data.action
    layered = getattr(action, "layers", None)
    curves = action.layers[0].strips[0].channelbags[0].fcurves if layered else action.fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


@pytest.fixture
def moving(cube_scene, monkeypatch):
    """A camera that goes 10 m a frame and turns by 30 degrees; scenes that were rendered."""
    camera = cube_scene.camera
    camera.rotation_mode, camera.rotation_euler = "XYZ", (0.0, 0.0, 0.0)
    for frame in (0, 10):
        camera.location = (10.0 * frame, 0.0, 5.0)
        camera.rotation_euler[2] = math.radians(30.0) * frame
        camera.keyframe_insert("location", frame=frame)
        camera.keyframe_insert("rotation_euler", frame=frame)
    _linear(camera)
    cube_scene.render.use_motion_blur = True
    cube_scene.render.motion_blur_shutter = 0.5
    cube_scene.render.resolution_x = cube_scene.render.resolution_y = 8
    cube_scene.iwis.pixel_filter, cube_scene.iwis.max_samples = "BOX", 4
    cube_scene.frame_set(4)
    return cube_scene


@pytest.fixture
def rendered(moving, monkeypatch, tmp_path):
    """Renders the scene: the exported one."""
    seen = []
    render_view = FinalRender._render_view

    def spy(self, view, scene, rows):
        seen.append(scene)
        return render_view(self, view, scene, rows)

    monkeypatch.setattr(FinalRender, "_render_view", spy)

    def run(whole=False):
        render_iwis(moving, tmp_path)
        return seen[-1] if whole else seen[-1].camera

    return run


def _keyed(obj, **values):
    """Properties at frame 0 and 10, straight between them."""
    for name, ends in values.items():
        for frame, value in zip((0, 10), ends, strict=True):
            setattr(obj, name, value)
            obj.keyframe_insert(name, frame=frame)
    _linear(obj)


@pytest.mark.parametrize(("position", "first"), [("START", 4.0), ("CENTER", 3.75), ("END", 3.5)])
def test_the_camera_is_read_over_the_shutters_time(moving, rendered, position, first):
    """From first to last in half a frame; all else is of its middle; then the frame is back."""
    moving.render.motion_blur_position = position
    camera = rendered()
    x = camera.motion.matrices[:, 0, 3]
    np.testing.assert_allclose(x, np.linspace(10 * first, 10 * first + 5, len(x)), atol=1e-4)
    assert camera.camera_to_world[0, 3] == pytest.approx(10 * first + 2.5, abs=1e-4)
    turn = np.arctan2(camera.motion.matrices[:, 1, 0], camera.motion.matrices[:, 0, 0])
    steps = np.diff(np.unwrap(turn))
    np.testing.assert_allclose(steps, math.radians(15.0) / len(steps), atol=1e-5)  # float32
    assert (moving.frame_current, moving.frame_subframe) == (4, 0.0)
    assert moving.camera.matrix_world[0][3] == pytest.approx(40.0)


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_at_a_cut_the_frames_own_camera_is_blurred(moving, rendered, position):
    """A marker gives the frames before another camera, which Cycles does not look through."""
    moving.render.motion_blur_position = position
    expected = rendered().motion.matrices
    other = moving.camera.copy()
    other.animation_data_clear()
    moving.collection.objects.link(other)
    for frame, camera in ((1, other), (4, moving.camera)):
        moving.timeline_markers.new(f"cut {frame}", frame=frame).camera = camera
    moving.frame_set(4)
    np.testing.assert_allclose(rendered().motion.matrices, expected, atol=1e-6)
    moving.frame_set(3)
    assert rendered().motion is None  # the other one stands, and the next one is not looked through


def test_a_camera_that_stands_has_no_motion(moving, rendered):
    """Nothing to blur: neither passes nor samples are spent on it."""
    moving.camera.animation_data_clear()
    assert rendered().motion is None


def test_a_camera_may_be_kept_from_blurring(moving, rendered):
    """Its own Motion Blur option, and motion blur as a whole."""
    moving.camera.cycles.use_motion_blur = False
    assert rendered().motion is None
    moving.camera.cycles.use_motion_blur = True
    assert rendered().motion is not None
    moving.render.use_motion_blur = False
    assert rendered().motion is None


def _cube(scene):
    return next(obj for obj in scene.objects if "ube" in obj.name)


def test_objects_move_over_the_shutters_time(moving, rendered):
    """Along a line and about their own origin, from the middle pose, which the mesh table has."""
    moving.camera.animation_data_clear()
    cube = _cube(moving)
    turns = (0.0, 0.0, 0.0), (0.0, 0.0, math.radians(300.0))
    _keyed(cube, location=((1.0, 2.0, 0.5), (11.0, 2.0, 0.5)), rotation_euler=turns)
    scene = rendered(whole=True)
    motion, k = scene.motion, len(scene.motion.times)
    assert len(motion.objects) == 1 and (scene.camera.motion is not None)
    middle = np.array([1.0 + 4.0, 2.0, 0.5])
    moved = motion.matrices[:, 0, :3, :3] @ middle + motion.matrices[:, 0, :3, 3]
    np.testing.assert_allclose(moved[:, 0], 5.0 + 0.5 * (motion.times - 0.5), atol=1e-5)
    np.testing.assert_allclose(moved[:, 1:], np.tile(middle[1:], (k, 1)), atol=1e-5)
    turn = np.arctan2(motion.matrices[:, 0, 1, 0], motion.matrices[:, 0, 0, 0])
    wanted = math.radians(30.0) * 0.5 * (motion.times - 0.5)
    np.testing.assert_allclose(turn, wanted, atol=1e-5)
    assert not [w for w in RenderJob.get().records[-1].stats.warnings if "motion" in w]
    assert cube.matrix_world.translation.x == pytest.approx(5.0)


def test_an_object_may_be_kept_from_blurring(moving, rendered):
    """Its own Motion Blur option; then nothing of it moves."""
    cube = _cube(moving)
    _keyed(cube, location=((0.0, 0.0, 0.0), (10.0, 0.0, 0.0)))
    cube.cycles.use_motion_blur = False
    assert rendered(whole=True).motion is None
    cube.cycles.use_motion_blur = True
    assert len(rendered(whole=True).motion.objects) == 1


def test_steps_of_an_object_follow_its_bends(moving, rendered):
    """With 3 steps (9 places) a swing is followed where 1 (3 places) cuts its corners."""
    moving.camera.animation_data_clear()
    moving.render.motion_blur_shutter = 1.0
    cube = _cube(moving)
    for frame, x in ((3.5, 0.0), (3.75, 1.0), (4.0, 0.0), (4.25, 1.0), (4.5, 0.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    _linear(cube)
    cube.cycles.motion_steps = 1
    assert rendered(whole=True).motion is None  # at all three places it is at 0
    cube.cycles.motion_steps = 3
    motion = rendered(whole=True).motion
    x = motion.matrices[:, 0, 0, 3]
    swing = np.interp(motion.times, np.linspace(0, 1, 5), [0.0, 1.0, 0.0, 1.0, 0.0])
    np.testing.assert_allclose(x, swing, atol=1e-4)


def test_instances_move_with_what_instances_them(moving, rendered):
    """Each instance by itself, known again by Blender's number."""
    moving.camera.animation_data_clear()
    cube = _cube(moving)
    plane = bpy.data.meshes.new("Places")
    plane.from_pydata([(0, 0, 3), (2, 0, 3), (4, 0, 3)], [], [])
    owner = bpy.data.objects.new("Places", plane)
    moving.collection.objects.link(owner)
    owner.instance_type = "VERTS"
    cube.parent = owner
    _keyed(owner, location=((0.0, 0.0, 0.0), (0.0, 10.0, 0.0)))
    scene = rendered(whole=True)
    assert len(scene.motion.objects) == 3
    last = scene.motion.matrices[-1, :, :3, 3]
    np.testing.assert_allclose(last[:, 1], 0.5 * (scene.motion.times[-1] - 0.5), atol=1e-5)


def test_what_cannot_be_blurred_is_told(moving, rendered):
    """An object that is mirrored half way is drawn as in the middle, with one line."""
    cube = _cube(moving)
    _keyed(cube, scale=((-4.1, 1.0, 1.0), (5.9, 1.0, 1.0)))
    assert rendered(whole=True).motion is None
    told = [w for w in RenderJob.get().records[-1].stats.warnings if "not blurred" in w]
    assert len(told) == 1 and "1 moving objects" in told[0] and cube.name in told[0]


def test_the_shutters_curve_says_when_light_comes_in(scene):
    """Open all the time: evenly; a ramp from 0 to 1: as the square root."""
    curve = scene.render.motion_blur_shutter_curve
    points = curve.curves[0].points
    for point, y in ((points[0], 1.0), (points[len(points) - 1], 1.0)):
        point.location = (point.location[0], y)
    while len(points) > 2:
        points.remove(points[1])
    points[0].location, points[1].location = (0.0, 1.0), (1.0, 1.0)
    curve.update()
    u = np.linspace(0.0, 1.0, 257)
    np.testing.assert_allclose(shutter_times(scene.render), u, atol=1e-6)
    points[0].location = (0.0, 0.0)
    for point in points:
        point.handle_type = "VECTOR"
    curve.update()
    np.testing.assert_allclose(shutter_times(scene.render), np.sqrt(u), atol=2e-3)  # 256 parts


def test_an_f_curve_of_the_lens_is_motion(moving, rendered):
    """A zoom: the window's width changes with the time, though the camera stands."""
    moving.camera.animation_data_clear()
    data = moving.camera.data
    for frame, lens in ((0, 20.0), (10, 60.0)):
        data.lens = lens
        data.keyframe_insert("lens", frame=frame)
    _linear(data)
    windows = rendered().motion.windows
    widths = 36.0 / (windows[:, 1] - windows[:, 0])
    assert widths[0] == pytest.approx(35.0, rel=1e-4) and widths[-1] == pytest.approx(
        37.0, rel=1e-4
    )
    assert bpy.context.scene.camera.data.lens == pytest.approx(36.0)


@pytest.fixture
def told(moving):
    """Exports with motion: the scene, and what is told."""

    def run():
        lines = []
        depsgraph = bpy.context.evaluated_depsgraph_get()
        export = functools.partial(export_scene, depsgraph, warnings=lines)
        return export_in_motion(engine_of(moving), depsgraph, lines, export), lines

    return run


def test_a_moving_lamp_stands_as_in_the_middle(moving, told):
    """As in Cycles, so nothing is told of it; nothing else is then in motion."""
    moving.camera.animation_data_clear()
    lamp = bpy.data.objects.new("Torch", bpy.data.lights.new("Torch", "POINT"))
    moving.collection.objects.link(lamp)
    _keyed(lamp, location=((0.0, 0.0, 3.0), (10.0, 0.0, 3.0)))
    moving.render.motion_blur_position = "START"
    scene, lines = told()
    assert lines == [] and scene.motion is None
    assert scene.lamps.position[0, 0] == pytest.approx(4.25)

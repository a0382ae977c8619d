"""A view's own matrices say what it sees: as the exported camera, and as its border leaves it."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from iwis.core.data.asked_passes import NO_PASSES
from iwis.iwis_addon.export.cameras.camera import export_camera
from iwis.iwis_addon.export.same import same
from iwis.iwis_addon.view_camera import view_camera

WIDTH, HEIGHT = 64, 48


def make_view(scene, perspective="CAMERA", size=(WIDTH, HEIGHT), **space):
    """What Blender's window would give: region, region_3d, space, scene."""
    camera = scene.camera
    depsgraph = bpy.context.evaluated_depsgraph_get()
    overlay = SimpleNamespace(show_overlays=True)
    defaults = {"camera": camera, "use_render_border": False, "overlay": overlay}
    return (
        SimpleNamespace(width=size[0], height=size[1]),
        SimpleNamespace(
            window_matrix=camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1]),
            view_matrix=camera.matrix_world.normalized().inverted(),
            view_perspective=perspective,
        ),
        SimpleNamespace(**defaults | space),
        scene,
    )


@pytest.fixture
def seen(cube_scene):
    """A camera with everything that moves its frame, and room around it."""
    render, data = cube_scene.render, cube_scene.camera.data
    render.resolution_x, render.resolution_y = WIDTH, HEIGHT
    data.shift_x, data.shift_y, data.lens = 0.1, -0.05, 35.0
    data.show_passepartout = False
    bpy.context.view_layer.update()
    return cube_scene


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_view_through_the_camera_sees_what_a_render_does(seen, kind):
    """Window, place and clipping are those of the exported camera."""
    seen.camera.data.type = kind
    bpy.context.view_layer.update()
    got = view_camera(*make_view(seen), 1)
    expected = export_camera(bpy.context.evaluated_depsgraph_get(), [])
    assert (got.kind, got.width, got.height) == (expected.kind, WIDTH, HEIGHT)
    assert got.region == expected.region
    # float32 matrices; the far plane is what is left of 1 - 2 near / far
    np.testing.assert_allclose(got.window, expected.window, atol=1e-5)
    np.testing.assert_allclose(got.camera_to_world, expected.camera_to_world, atol=1e-5)
    assert got.clip_start == pytest.approx(expected.clip_start, rel=1e-3)
    assert got.clip_end == pytest.approx(expected.clip_end, rel=1e-2)


def test_pixel_size_keeps_pixels_in_their_places(seen):
    """A size that does not divide the region reaches out to the right and to the top."""
    fine, coarse = (view_camera(*make_view(seen, size=(62, 45)), size) for size in (1, 4))
    assert (coarse.width, coarse.height) == (16, 12)
    left, right, bottom, top = fine.window
    expected = (left, left + (right - left) * 64 / 62, bottom, bottom + (top - bottom) * 48 / 45)
    np.testing.assert_allclose(coarse.window, expected, rtol=1e-12)


def test_border_of_a_view_is_a_part_of_the_region(seen):
    """In a view that is not the camera's; one of no size leaves nothing."""
    border = {
        "use_render_border": True,
        "render_border_min_x": 0.25,
        "render_border_max_x": 0.5,
        "render_border_min_y": 0.0,
        "render_border_max_y": 1.0,
    }
    assert view_camera(*make_view(seen, "PERSP", **border), 1).region == (16, 0, 32, 48)
    border["render_border_max_x"] = 0.25
    assert view_camera(*make_view(seen, "PERSP", **border), 1) is None


def test_render_border_is_a_part_of_the_cameras_frame(seen):
    """The frame fills the region here, but for its shift: calc_matrix_camera() includes that."""
    render = seen.render
    render.use_border = True
    render.border_min_x, render.border_max_x = 0.25, 0.75
    render.border_min_y, render.border_max_y = 0.5, 1.0
    x0, y0, x1, y1 = view_camera(*make_view(seen), 1).region
    # One pixel for float32: edges are rounded outwards.
    assert abs(np.array([x0, y0, x1, y1]) - [16, 24, 48, 48]).max() <= 1


def test_opaque_passepartout_hides_what_is_around(seen):
    """Twice as wide a region: only the frame in its middle is rendered."""
    data = seen.camera.data
    data.shift_x = data.shift_y = 0.0
    data.show_passepartout, data.passepartout_alpha = True, 1.0
    view = make_view(seen, size=(2 * WIDTH, HEIGHT))
    view[1].window_matrix[0][0] *= 0.5  # room at both sides, as in a wide window
    x0, _, x1, _ = view_camera(*view, 1).region
    everything = view_camera(
        *view[:2], SimpleNamespace(**vars(view[2]) | {"camera": None}), seen, 1
    )
    assert everything.region == (0, 0, 2 * WIDTH, HEIGHT)
    assert 0 < x0 < x1 < 2 * WIDTH
    data.passepartout_alpha = 0.5
    assert view_camera(*view, 1).region == everything.region


def test_a_view_through_the_camera_has_its_lens(seen):
    """Depth of field as in the render, in the camera's view only; an edit is another camera."""
    dof = seen.camera.data.dof
    dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 0.5, 3.0
    got = view_camera(*make_view(seen), 1)
    assert got.lens == export_camera(bpy.context.evaluated_depsgraph_get(), []).lens
    assert view_camera(*make_view(seen, "PERSP"), 1).lens is None
    dof.focus_distance = 4.0
    assert not same(got, view_camera(*make_view(seen), 1))


@pytest.mark.parametrize("size", [(WIDTH, HEIGHT), (2 * WIDTH, HEIGHT)])
def test_a_panorama_fills_the_cameras_frame(seen, size):
    """In a view of the frame's size the render's picture; in a wider one it goes on beside it."""
    data = seen.camera.data
    data.type = "PANO"
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    bpy.context.view_layer.update()
    expected = export_camera(bpy.context.evaluated_depsgraph_get(), [])
    view = make_view(seen, size=size)
    got = view_camera(*view, 1)
    assert (got.kind, got.panorama) == ("PANORAMIC", expected.panorama)
    assert (got.clip_start, got.clip_end) == (expected.clip_start, expected.clip_end)
    x0, y0, x1, y1 = view_frame(view, size)
    left, right, bottom, top = got.window
    x, y = np.array([x0, x1]) / got.width, np.array([y0, y1]) / got.height
    np.testing.assert_allclose(left + (right - left) * x, expected.window[:2], atol=1e-5)  # float32
    np.testing.assert_allclose(bottom + (top - bottom) * y, expected.window[2:], atol=1e-5)


def view_frame(view, size):
    """The camera's frame in pixels of the region, by its corners in the window's matrix."""
    _, region_3d, space, scene = view
    corners = np.array(space.camera.data.view_frame(scene=scene))
    points = np.c_[corners, np.ones(4)] @ np.array(region_3d.window_matrix).T
    screen = (points[:, :2] / points[:, 3:] + 1.0) * 0.5 * size
    return *screen.min(axis=0), *screen.max(axis=0)


def test_a_view_takes_several_points_a_pixel_where_one_says_nothing(seen, monkeypatch):
    """The view's default filter, Center, has no blur and no walks: Box stands in, only there."""
    from iwis.iwis_addon import viewport

    asked, view = [], standing_view()
    view.thread.request = lambda scene, settings: asked.append(settings)
    monkeypatch.setattr(viewport, "_replace", lambda scene, **changes: scene)
    for use_dof, scatters in ((False, False), (True, False), (False, True)):
        seen.camera.data.dof.use_dof = use_dof
        shaders = SimpleNamespace(scatters=scatters)
        scene = SimpleNamespace(shaders=shaders, asked=NO_PASSES)
        viewport.Viewport._want(view, scene, seen, view_camera(*make_view(seen), 1))
    assert [own.pixel_filter for own in asked] == ["CENTER", "BOX", "BOX"]


def standing_view():
    """What Viewport._want knows of a view whose thread does nothing."""
    thread = SimpleNamespace(denoise=lambda *wanted: None, request=lambda *wanted: None)
    own = {"_scene": None, "_settings": None, "_camera": None, "_denoise": None, "_guided": False}
    return SimpleNamespace(**own, restarts=0, thread=thread, picture=None)


def test_a_view_is_denoised_otherwise_without_a_new_picture(seen, monkeypatch):
    """Only turning it on begins anew: the picture before kept nothing that a denoiser needs."""
    from iwis.iwis_addon import viewport

    told, view = [], standing_view()
    view.thread.denoise = lambda denoising, start: told.append((denoising.settings, start))
    monkeypatch.setattr(viewport, "_replace", lambda scene, **changes: scene)
    scene = SimpleNamespace(shaders=None, asked=NO_PASSES)
    camera, own = view_camera(*make_view(seen), 1), seen.iwis.viewport
    for change, restarts in (
        ({}, 1),
        ({"denoise_quality": "FAST"}, 1),  # off: nobody asks
        ({"denoise": True}, 2),
        ({"denoise_quality": "HIGH"}, 2),
        ({"denoise_start": 32}, 2),
        ({"denoise": False}, 2),
        ({"denoise": True}, 2),
    ):
        for name, value in change.items():
            setattr(own, name, value)
        viewport.Viewport._want(view, scene, seen, camera)
        assert view.restarts == restarts, change
    assert [settings.denoise for settings, _ in told] == [
        False,
        False,
        True,
        True,
        True,
        False,
        True,
    ]
    assert told[-1][0].denoise_quality == "HIGH" and told[-1][1] == 32

"""Show Sampling of Pixel in a 3D view: the view's own camera, the region under the mouse."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from iwis.operators import inspect_pixel as operator
from iwis.operators.inspect_pixel import IWIS_OT_inspect_pixel, inspect_pixel, region_under


def make_view(scene, view_matrix, window_matrix, perspective="PERSP"):
    """(space, region) as Blender's window would give them, 64x48 pixels."""
    overlay = SimpleNamespace(show_overlays=True)
    data = SimpleNamespace(
        view_matrix=view_matrix, window_matrix=window_matrix, view_perspective=perspective
    )
    space = SimpleNamespace(camera=scene.camera, use_render_border=False, overlay=overlay)
    return space, SimpleNamespace(width=64, height=48, data=data)


def orthographic(half_width: float, half_height: float, far: float) -> Matrix:
    return Matrix.Diagonal((1.0 / half_width, 1.0 / half_height, -1.0 / far, 1.0))


@pytest.mark.slow
def test_a_view_through_the_camera_shows_the_same_point(cube_scene):
    """Pixel for pixel what a frame of the region's size shows."""
    cube_scene.render.resolution_x, cube_scene.render.resolution_y = 64, 48
    graph, camera = bpy.context.evaluated_depsgraph_get(), cube_scene.camera
    seen = make_view(
        cube_scene,
        camera.matrix_world.normalized().inverted(),
        camera.calc_matrix_camera(graph, x=64, y=48),
        "CAMERA",
    )
    expected, _ = inspect_pixel(graph, 32, 24, 16)
    got, picture = inspect_pixel(graph, 32, 24, 16, seen)
    np.testing.assert_allclose(got.position, expected.position, atol=1e-4)
    assert picture.shape == (40, 72, 4)


@pytest.mark.parametrize("x", [22, 42])
def test_an_orthographic_view_from_above_needs_no_camera(cube_scene, x):
    """The point lies where the pixel's centre is, at 8 pixels a metre; the scene has no camera."""
    bpy.data.objects.remove(cube_scene.camera)
    view = Matrix.Translation((0.0, 0.0, -20.0))
    seen = make_view(cube_scene, view, orthographic(4.0, 3.0, 100.0))
    graph = bpy.context.evaluated_depsgraph_get()
    got, _ = inspect_pixel(graph, x, 30, 16, seen)
    expected = (x + 0.5 - 32) / 8, (30 + 0.5 - 24) / 8
    np.testing.assert_allclose(got.position[:2], expected, atol=1e-4)
    with pytest.raises(ValueError, match="outside"):
        inspect_pixel(graph, 64, 30, 16, seen)


def rectangle(kind, x, y, width, height, **more):
    return SimpleNamespace(type=kind, x=x, y=y, width=width, height=height, **more)


def make_screen():
    """A solid and a rendered view side by side, each with a header; above them an image."""
    areas = []
    for number, shading in enumerate(("SOLID", "RENDERED")):
        x = 100 * number
        regions = [rectangle("WINDOW", x, 0, 100, 100), rectangle("HEADER", x, 90, 100, 10)]
        space = SimpleNamespace(shading=SimpleNamespace(type=shading))
        areas.append(rectangle("VIEW_3D", x, 0, 100, 100, regions=regions))
        areas[-1].spaces = SimpleNamespace(active=space)
    image = rectangle("IMAGE_EDITOR", 0, 100, 200, 50, regions=[])
    image.regions.append(rectangle("WINDOW", 0, 100, 200, 50))
    image.spaces = SimpleNamespace(active=SimpleNamespace(image=object()))
    return SimpleNamespace(areas=[*areas, image])


def test_the_region_under_the_mouse_is_picked():
    """Not the one that the operator was called from; headers and solid views are no pictures."""
    screen = make_screen()
    _solid, rendered, image = screen.areas
    assert region_under(screen, 150, 40) == (rendered, rendered.regions[0])
    assert region_under(screen, 150, 95) is None
    assert region_under(screen, 50, 40) is None
    assert region_under(screen, 50, 120) == (image, image.regions[0])
    image.spaces.active.image = None
    assert region_under(screen, 50, 120) is None


def test_a_click_names_the_pixel_of_its_region():
    """Counted from the region's corner, wherever the region lies in the window."""
    _solid, rendered, _image = make_screen().areas
    operator = SimpleNamespace()
    IWIS_OT_inspect_pixel._pick(operator, None, rendered, rendered.regions[0], 150, 40)
    assert (operator.source, operator.x, operator.y) == ("VIEW", 50, 40)
    assert operator.picked == (rendered.spaces.active, rendered.regions[0])


def test_the_mouse_tells_that_blender_is_busy(scene, monkeypatch):
    """As long as it takes, and no longer where nothing can be shown."""
    cursors = []
    window = SimpleNamespace(
        cursor_modal_set=cursors.append, cursor_modal_restore=lambda: cursors.append("back")
    )

    def fails(*_arguments):
        assert cursors == ["WAIT"]
        raise ValueError("no object")

    monkeypatch.setattr(operator, "inspect_pixel", fails)
    context = SimpleNamespace(window=window, evaluated_depsgraph_get=lambda: None)
    asked = SimpleNamespace(source="CAMERA", x=1, y=1, height=64, report=lambda *_: None)
    assert IWIS_OT_inspect_pixel.execute(asked, context) == {"CANCELLED"}
    assert cursors == ["WAIT", "back"]

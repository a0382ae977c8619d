"""The Wireframe node (core/nodes/wireframe.py)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.nodes import ShadeContext
from iwis.core.nodes.wireframe import wireframe
from iwis.core.scene import Camera
from support.programs import with_programs
from support.scenes import camera_at, constant_world, diffuse, make_scene, quad

# On a square of 4 m, of two triangles whose diagonal is x = y; metres from the nearest edge.
PLACES = np.float32([[1.0, 0.05, 0.0], [3.95, 1.0, 0.0], [2.0, 2.05, 0.0], [2.9, 1.1, 0.0]])
FAR = np.float32([0.05, 0.05, 0.05 / np.sqrt(2.0), 1.1])


def _context(camera=None, places=PLACES):
    camera = camera or camera_at((2.0, 2.0, 5.0), (2.0, 2.01, 0.0), 8, 8, 0.6)
    square = quad((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    scene = with_programs(make_scene([square], [diffuse()], constant_world(), camera), None)
    n, up = len(places), np.tile(np.float32([0.0, 0.0, 1.0]), (len(places), 1))
    triangle = np.where(places[:, 1] > places[:, 0], 1, 0).astype(np.int32)
    corners = scene.mesh.vertices[scene.mesh.triangles[triangle]]
    assert (corners[:, :, :2].min(1) <= places[:, :2]).all()  # the triangles are as said above
    own = scene.shaders.surface, camera, np.zeros(1, np.float32), triangle
    return ShadeContext(scene.mesh, *own, np.zeros((n, 2), np.float32), places, up, up, up)


@pytest.mark.parametrize("size", [0.06, 0.08, 0.12, 2.0, 2.3])
def test_it_is_one_within_half_its_size_of_an_edge(size):
    """The diagonal is an edge as any."""
    found = wireframe(_context(), {"use_pixel_size": False}, {"Size": np.float32(size)})["Fac"]
    np.testing.assert_array_equal(found, FAR < 0.5 * size)
    assert found.dtype == np.float32


def test_size_may_differ_from_point_to_point():
    sizes = np.float32([0.09, 0.11, 0.09, 2.1])
    found = wireframe(_context(), {"use_pixel_size": False}, {"Size": sizes})["Fac"]
    np.testing.assert_array_equal(found, FAR < 0.5 * sizes)


@pytest.mark.parametrize("kind", ["ORTHOGRAPHIC", "PERSPECTIVE"])
def test_pixels_are_as_wide_as_they_are_seen(kind):
    """Straight below a camera at 4 m whose picture is 8 pixels wide: 4 m there, or a pixel .5 m."""
    window = (-2.0, 2.0, -2.0, 2.0) if kind == "ORTHOGRAPHIC" else (-0.5, 0.5, -0.5, 0.5)
    matrix = np.eye(4)
    matrix[:3, 3] = 2.0, 0.4, 4.0
    camera = Camera(
        kind=kind,
        camera_to_world=matrix,
        window=window,
        width=8,
        height=8,
        region=(0, 0, 8, 8),
        clip_start=0.1,
        clip_end=100.0,
    )
    below = _context(camera, np.float32([[2.0, 0.4, 0.0]]))
    for pixels, expected in ((1.55, 0.0), (1.65, 1.0)):  # .4 m away: 1.6 pixels of .5 m wide
        found = wireframe(below, {"use_pixel_size": True}, {"Size": np.float32(pixels)})["Fac"]
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("name", ["Is Strand", "Radius"])
def test_strands_and_points_have_none(name):
    """Here they are triangles, in Cycles not."""
    context = _context()
    tables = {f"element:{name}": np.full((1, 3, 1), 0.5, np.float32)}
    context.surface = dataclasses.replace(context.surface, row=np.zeros(2, np.int32), tables=tables)
    found = wireframe(context, {"use_pixel_size": False}, {"Size": np.float32(9.0)})["Fac"]
    np.testing.assert_array_equal(found, 0.0)
